#include "apps/pietrade/measure.h"

#include "pie/core/clock.h"
#include "pie/core/parallel.h"
#include "pie/engine/engine.h"

#include <algorithm>
#include <cmath>
#include <stop_token>

namespace pietrade {
namespace {

using pie::engine::Engine;
using pie::engine::Settings;
using pie::engine::Statistics;

double median(std::vector<double> values) {
    if (values.empty()) return unknown;
    const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), half, values.end());
    return *half;
}

/// One frame with all in view.
struct Frame {
    double traceMs = 0, buildMs = 0, estimateMs = 0;
    double ms = 0;            ///< of these three
    double wall = 0, cpu = 0; ///< of both calls, with refinement
    bool traced = false;
};

class Run {
public:
    Run(const Scenery& scenery, const Settings& base, const Settings& settings, const std::function<bool()>& stop)
        : s_(scenery), settings_(settings), stop_(stop), sameMesh_(sameMesh(base, settings)) {}

    std::optional<Measurement> operator()();

private:
    static bool sameMesh(const Settings& a, const Settings& b) {
        return a.maxEdge == b.maxEdge && a.meshRefinement == b.meshRefinement && a.maxTriangles == b.maxTriangles &&
               a.tJunctionTolerance == b.tJunctionTolerance && a.patchTolerance == b.patchTolerance;
    }
    bool make();
    void find();
    bool frame(bool everything);
    bool refineAll();
    bool watch();
    bool settle();
    [[nodiscard]] std::vector<double> light(const std::vector<std::uint32_t>& which);
    [[nodiscard]] std::vector<double> atPoints();
    [[nodiscard]] std::vector<double> atVertices();
    [[nodiscard]] double reached(double error) const;
    [[nodiscard]] std::size_t framesOfPhotons() const;
    void report(Measurement& m);

    const Scenery& s_;
    const Settings& settings_;
    const std::function<bool()>& stop_;
    bool sameMesh_;
    std::unique_ptr<Engine> engine_;
    View view_;
    std::vector<std::uint32_t> sampled_; ///< receivers that are compared
    std::vector<std::optional<Place>> places_;
    std::vector<Truth> pointTruth_;
    std::vector<pie::Rgb> light_;
    std::vector<Frame> frames_;
    std::vector<std::pair<double, double>> errors_; ///< time since the level was there, error
    double elapsed_ = 0, readyMs_ = 0;
};

bool Run::make() {
    const double cpu = pie::processorMilliseconds();
    const auto start = pie::Clock::now();
    engine_ = std::make_unique<Engine>(s_.level, settings_, pie::engine::Refinement::Later);
    engine_->complete();
    readyMs_ = s_.processorTime ? pie::processorMilliseconds() - cpu : pie::millisecondsSince(start);
    elapsed_ = readyMs_;
    return !stop_();
}

void Run::find() {
    view_ = seen(engine_->mesh(), *s_.level, engine_->receivers(), s_.camera,
                 static_cast<std::size_t>(settings_.cellTriangles));
    places_ = locate(engine_->mesh(), engine_->receivers(), s_.sample.points);
    std::vector<std::uint32_t> all = view_.receivers;
    for (const auto& place : places_)
        if (place) sampled_.insert(sampled_.end(), place->receivers.begin(), place->receivers.end());
    if (sameMesh_) sampled_.insert(sampled_.end(), s_.sample.vertices.begin(), s_.sample.vertices.end());
    const auto unite = [](std::vector<std::uint32_t>& list) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    };
    unite(sampled_);
    // A cell at the rim of the view may be cut otherwise than that of the default.
    view_.receivers.insert(view_.receivers.end(), sampled_.begin(), sampled_.end());
    unite(view_.receivers);
    for (std::size_t i = 0; i < places_.size(); ++i) pointTruth_.push_back(places_[i] ? s_.pointTruth[i] : Truth{});
}

std::vector<double> Run::light(const std::vector<std::uint32_t>& which) {
    light_.resize(which.size());
    engine_->irradiance(which, light_);
    std::vector<double> means;
    means.reserve(which.size());
    for (const pie::Rgb& e : light_)
        means.push_back((static_cast<double>(e.x) + static_cast<double>(e.y) + static_cast<double>(e.z)) / 3);
    return means;
}

std::vector<double> Run::atPoints() {
    const std::vector<double> means = light(sampled_);
    const auto of = [&](std::uint32_t receiver) {
        return means[static_cast<std::size_t>(std::lower_bound(sampled_.begin(), sampled_.end(), receiver) -
                                              sampled_.begin())];
    };
    std::vector<double> found;
    for (const auto& place : places_) {
        double sum = 0;
        for (int i = 0; place && i < 3; ++i)
            sum += static_cast<double>(place->weights[i]) * of(place->receivers[static_cast<std::size_t>(i)]);
        found.push_back(sum);
    }
    return found;
}

std::vector<double> Run::atVertices() { return light(s_.sample.vertices); }

/// Returns whether the light changed.
bool Run::frame(bool everything) {
    const Statistics before = engine_->statistics();
    const double cpu = pie::processorMilliseconds();
    const auto start = pie::Clock::now();
    const bool changed = engine_->advance();
    const double advanceMs = pie::millisecondsSince(start);
    const double advanceCpu = pie::processorMilliseconds() - cpu;
    light_.resize(view_.receivers.size());
    if (everything) engine_->irradiance(view_.receivers, light_);
    Frame f;
    f.wall = pie::millisecondsSince(start);
    f.cpu = pie::processorMilliseconds() - cpu;
    const Statistics after = engine_->statistics();
    f.traced = after.framesTraced > before.framesTraced;
    f.traceMs = after.traceMs - before.traceMs;
    f.buildMs = after.buildMs - before.buildMs;
    // What irradiance() does once, shadow rays of the photon map, is no part of a frame.
    f.estimateMs = std::max(0.0, f.wall - advanceMs - (after.directMs - before.directMs));
    if (s_.processorTime) {
        const double refined = after.refineMs - before.refineMs;
        const double advance = advanceMs > 0.0 ? advanceCpu / advanceMs : 1.0;
        const double estimate = f.wall > advanceMs ? (f.cpu - advanceCpu) / (f.wall - advanceMs) : 1.0;
        // By the clock, scaled by what share of it the processor was ours.
        const double parts = f.traceMs + f.buildMs;
        const double ours = parts + refined > 0.0 ? advance : 1.0;
        f.traceMs *= ours;
        f.buildMs *= ours;
        f.estimateMs *= estimate;
    }
    f.ms = f.traceMs + f.buildMs + f.estimateMs;
    elapsed_ += s_.processorTime ? f.cpu : f.wall;
    if (everything) frames_.push_back(f);
    return changed;
}

std::size_t Run::framesOfPhotons() const {
    const bool gathers = settings_.estimator == pie::engine::EstimatorKind::Gather && !settings_.finalGathering;
    return std::min(static_cast<std::size_t>(gathers ? settings_.stillFrames : settings_.accumulationFrames),
                    s_.mostFrames);
}

/// Until it is refined and near; returns false when it was stopped.
bool Run::watch() {
    constexpr std::size_t reserve = 8;
    const std::size_t all = framesOfPhotons();
    const std::size_t most = all > 2 * reserve ? all - reserve : all / 2;
    for (std::size_t i = 0; i < most; ++i) {
        if (stop_()) return false;
        const bool changed = frame(true);
        errors_.emplace_back(elapsed_, errorOf(atPoints(), pointTruth_));
        if (!changed) break;
        constexpr double near = 0.05;
        if (i > 1 && engine_->statistics().unfinished == 0 && errors_.back().second <= near) break;
    }
    return true;
}

bool Run::refineAll() {
    constexpr std::size_t some = 1024;
    const std::span<const std::uint32_t> all(view_.receivers);
    for (std::size_t first = 0; first < all.size(); first += some) {
        if (stop_()) return false;
        const double cpu = pie::processorMilliseconds();
        const auto start = pie::Clock::now();
        engine_->finish(all.subspan(first, std::min(some, all.size() - first)));
        elapsed_ += s_.processorTime ? pie::processorMilliseconds() - cpu : pie::millisecondsSince(start);
    }
    return true;
}

/// The frames in reserve, and then photons alone.
bool Run::settle() {
    const std::size_t all = framesOfPhotons();
    constexpr std::size_t reserve = 8;
    for (std::size_t i = 0; engine_->statistics().framesTraced < all; ++i) {
        if (stop_()) return false;
        if (!frame(i < reserve)) break;
        if (i < reserve) errors_.emplace_back(elapsed_, errorOf(atPoints(), pointTruth_));
    }
    if (errors_.empty() || engine_->statistics().framesTraced > 0) {
        light_.resize(view_.receivers.size());
        const double cpu = pie::processorMilliseconds();
        const auto start = pie::Clock::now();
        engine_->irradiance(view_.receivers, light_);
        elapsed_ += s_.processorTime ? pie::processorMilliseconds() - cpu : pie::millisecondsSince(start);
        errors_.emplace_back(elapsed_, errorOf(atPoints(), pointTruth_));
    }
    return true;
}

/// Milliseconds from the file until the picture is that near and stays so; NaN: never.
double Run::reached(double error) const {
    double since = unknown;
    for (auto at = errors_.rbegin(); at != errors_.rend() && at->second <= error; ++at) since = at->first;
    return since + s_.loadMs;
}

void Run::report(Measurement& m) {
    const Accuracy points = compare(atPoints(), pointTruth_);
    m.error = points.error;
    m.errorDeviation = points.errorDeviation;
    m.median = points.median;
    m.medianDeviation = points.medianDeviation;
    if (sameMesh_) {
        const Accuracy vertices = compare(atVertices(), s_.vertexTruth);
        m.vertexError = vertices.error;
        m.vertexErrorDeviation = vertices.errorDeviation;
        m.vertexMedian = vertices.median;
        m.vertexMedianDeviation = vertices.medianDeviation;
    }
    // The last ones that traced: everything is refined, the map is full.
    std::vector<double> trace, build, estimate, total, busy;
    const bool gathers = settings_.estimator == pie::engine::EstimatorKind::Gather && !settings_.finalGathering;
    const std::size_t most = gathers ? 8 : 3;
    for (auto f = frames_.rbegin(); f != frames_.rend() && total.size() < most; ++f) {
        if (!f->traced) continue;
        trace.push_back(f->traceMs);
        build.push_back(f->buildMs);
        estimate.push_back(f->estimateMs);
        total.push_back(f->ms);
        if (f->cpu > 0.0) busy.push_back(f->wall / f->cpu);
    }
    m.traceMs = median(trace);
    m.buildMs = median(build);
    m.estimateMs = median(estimate);
    m.frameMs = median(total);
    m.busy = median(busy);
    m.readyMs = readyMs_;
    const Statistics statistics = engine_->statistics();
    m.refineMs = statistics.refineMs + (gathers ? 0.0 : statistics.directMs);
    if (s_.processorTime) {
        double wall = 0;
        double cpu = 0;
        for (const Frame& f : frames_) {
            wall += f.wall;
            cpu += f.cpu;
        }
        if (wall > 0.0) m.refineMs *= cpu / wall;
    }
    m.within20Ms = reached(0.20);
    m.within10Ms = reached(0.10);
    m.within5Ms = reached(0.05);
    m.frames = static_cast<double>(statistics.framesTraced);
    m.receivers = static_cast<double>(view_.receivers.size());
    m.triangles = static_cast<double>(statistics.drawnTriangles);
    if (statistics.framesTraced > 0)
        m.photons = static_cast<double>(statistics.photonsStored) / static_cast<double>(statistics.framesTraced);
    m.bytes = static_cast<double>(statistics.sceneBytes + statistics.intersectorBytes + statistics.mapBytes +
                                  statistics.receiverBytes + statistics.estimatorBytes + statistics.directBytes);
}

std::optional<Measurement> Run::operator()() {
    if (stop_() || !make()) return std::nullopt;
    find();
    if (!watch() || !refineAll() || !settle()) return std::nullopt;
    Measurement m;
    report(m);
    return m;
}

} // namespace

std::optional<Measurement> measure(const Scenery& scenery, const Settings& base, const Settings& settings,
                                   const std::function<bool()>& stop) {
    pie::setThreads(static_cast<unsigned>(settings.threads));
    auto result = Run(scenery, base, settings, stop)();
    pie::setThreads(static_cast<unsigned>(base.threads));
    return result;
}

} // namespace pietrade
