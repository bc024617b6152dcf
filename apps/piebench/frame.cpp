#include "apps/piebench/frame.h"

#include "apps/piebench/embree_rays.h"
#include "apps/piebench/machine.h"
#include "apps/piebench/stop.h"
#include "pie/core/parallel.h"
#include "pie/engine/options.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

namespace piebench {
namespace {

using pie::engine::Settings;

constexpr std::size_t accumulated = 10; // frames of a steady frame

std::string_view nameOf(Contender contender) {
    if (contender == Contender::Embree) return "embree";
    return name(static_cast<Estimator>(contender));
}

/// One that takes its turns: two kinds of frames, or rays alone.
struct Turns {
    Contender contender = Contender::Gather;
    std::unique_ptr<Frames> full, steady;
    std::unique_ptr<EmbreeRays> rays;
    std::vector<Stages> fullTimes, steadyTimes;
    std::vector<EmbreeRays::Times> rayTimes;
    std::optional<Errors> fullErrors, steadyErrors;

    void turn() {
        if (rays) rayTimes.push_back(rays->run());
        if (full) fullTimes.push_back(full->next());
        if (steady) steadyTimes.push_back(steady->next());
    }
};

template <class T> double medianOf(const std::vector<T>& times, double T::*member) {
    std::vector<double> values;
    values.reserve(times.size());
    for (const T& time : times) values.push_back(time.*member);
    return median(std::move(values));
}

/// Median of the ratios of turns taken side by side.
template <class A, class B>
double medianRatio(const std::vector<A>& a, double A::*ofA, const std::vector<B>& b, double B::*ofB) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        ratios.push_back(a[i].*ofA / std::max(b[i].*ofB, 1e-9));
    return rounded(median(std::move(ratios)));
}

double perSecond(std::uint64_t count, double milliseconds) {
    return rounded(1e3 * static_cast<double>(count) / std::max(milliseconds, 1e-6));
}

Json errorsJson(const std::optional<Errors>& errors) {
    if (!errors) return nullptr;
    return {{"rms", rounded(errors->rms)},
            {"rms_99", rounded(errors->rms99)},
            {"median", rounded(errors->median)},
            {"mean", rounded(errors->mean)},
            {"points", errors->points}};
}

Json framesJson(const Frames& frames, const std::vector<Stages>& times, std::size_t questions,
                const std::optional<Errors>& errors) {
    const double trace = medianOf(times, &Stages::trace);
    const double estimate = medianOf(times, &Stages::estimate);
    return {{"trace_ms", rounded(trace)},
            {"build_ms", rounded(medianOf(times, &Stages::build))},
            {"estimate_ms", rounded(estimate)},
            {"upload_ms", rounded(medianOf(times, &Stages::upload))},
            {"total_ms", rounded(medianOf(times, &Stages::total))},
            {"processor_ms", rounded(medianOf(times, &Stages::processor))},
            {"photons_new", frames.photonsNew()},
            {"photons_stored_per_second", perSecond(frames.photonsNew(), trace)},
            {"estimates_per_second", perSecond(questions, estimate)},
            {"error", errorsJson(errors)}};
}

Json raysJson(const EmbreeRays& rays, const std::vector<EmbreeRays::Times>& times) {
    using T = EmbreeRays::Times;
    return {{"rays", rays.rays()},
            {"photons_stored", rays.stored()},
            {"trace_ms", rounded(std::min(medianOf(times, &T::single), medianOf(times, &T::packets)))},
            {"single_ms", rounded(medianOf(times, &T::single))},
            {"packets_ms", rounded(medianOf(times, &T::packets))},
            {"processor_ms",
             rounded(std::min(medianOf(times, &T::singleProcessor), medianOf(times, &T::packetsProcessor)))},
            {"tracer_ms", rounded(medianOf(times, &T::tracer))},
            {"tracer_processor_ms", rounded(medianOf(times, &T::tracerProcessor))}};
}

Json runJson(const Turns& turns, std::size_t questions) {
    if (turns.rays) return {{"tracer", "embree"}, {"rays", raysJson(*turns.rays, turns.rayTimes)}};
    const Memory memory = turns.full->memory();
    return {{"estimator", nameOf(turns.contender)},
            {"prepare_ms", rounded(turns.full->prepareMs())},
            {"full", framesJson(*turns.full, turns.fullTimes, questions, turns.fullErrors)},
            {"steady", framesJson(*turns.steady, turns.steadyTimes, questions, turns.steadyErrors)},
            {"bytes_per_vertex", rounded(memory.perVertex)},
            {"bytes_per_photon", rounded(memory.perPhoton)}};
}

/// First over other: below 1 the first is better. Of photons per second: above 1.
Json ratiosJson(const Turns& first, const Turns& other) {
    if (other.rays) {
        using T = EmbreeRays::Times;
        const auto& times = other.rayTimes;
        return {{"photons_per_second", std::min(medianRatio(times, &T::single, times, &T::tracer),
                                                medianRatio(times, &T::packets, times, &T::tracer))},
                {"photons_per_second_processor",
                 std::min(medianRatio(times, &T::singleProcessor, times, &T::tracerProcessor),
                          medianRatio(times, &T::packetsProcessor, times, &T::tracerProcessor))}};
    }
    const auto wall = &Stages::total;
    const auto processor = &Stages::processor;
    Json ratios{{"full", medianRatio(first.fullTimes, wall, other.fullTimes, wall)},
                {"full_processor", medianRatio(first.fullTimes, processor, other.fullTimes, processor)},
                {"steady", medianRatio(first.steadyTimes, wall, other.steadyTimes, wall)},
                {"steady_processor", medianRatio(first.steadyTimes, processor, other.steadyTimes, processor)},
                {"steady_over_full", medianRatio(first.steadyTimes, wall, other.fullTimes, wall)},
                {"steady_over_full_processor", medianRatio(first.steadyTimes, processor, other.fullTimes, processor)}};
    const auto error = [&](double Errors::*kind) -> Json {
        if (!first.fullErrors || !other.fullErrors || !((*other.fullErrors).*kind > 0)) return nullptr;
        return rounded((*first.fullErrors).*kind / (*other.fullErrors).*kind);
    };
    ratios["error_rms"] = error(&Errors::rms);
    ratios["error_rms_99"] = error(&Errors::rms99);
    ratios["error_median"] = error(&Errors::median);
    return ratios;
}

/// What issue and documents promise, of what was measured here.
Json targetsJson(const Json& ratios, const Json& scaling) {
    Json targets = Json::array();
    const auto add = [&](const char* what, const Json& value, double target, bool atMost) {
        if (!value.is_number()) return;
        const auto number = value.get<double>();
        targets.push_back({{"what", what},
                           {"value", number},
                           {atMost ? "at_most" : "at_least", rounded(target)},
                           {"met", atMost ? number <= target : number >= target}});
    };
    if (ratios.contains("nanoflann")) {
        const Json& r = ratios["nanoflann"];
        add("full frame over nanoflann's, processor time", r["full_processor"], 0.1, true);
        add("steady frame over nanoflann's full frame, processor time", r["steady_over_full_processor"], 1.0 / 30,
            true);
        add("rms error over nanoflann's", r["error_rms"], 1, true);
        add("rms error over nanoflann's, without the worst hundredth", r["error_rms_99"], 1, true);
        add("median error over nanoflann's", r["error_median"], 1, true);
    }
    if (ratios.contains("embree"))
        add("photons stored a second over bare Embree, processor time",
            ratios["embree"]["photons_per_second_processor"], 0.9, false);
    if (scaling.is_object() && scaling["threads"] == 2)
        add("two threads over one, full frame", scaling["full"], 1.8, false);
    return targets;
}

/// One thread and all of them by turns on the same frames: how many times as many frames a second.
Json scalingJson(Turns& turns, int repeats) {
    const unsigned threads = pie::threads();
    std::vector<Stages> times[2][2];
    for (int round = 0; round < repeats; ++round)
        for (const unsigned way : {0U, 1U}) {
            pie::setThreads(way == 0 ? 1 : threads);
            times[0][way].push_back(turns.full->next());
            times[1][way].push_back(turns.steady->next());
        }
    pie::setThreads(threads);
    const auto wall = &Stages::total;
    const auto part = [&](double Stages::*stage) { return medianRatio(times[0][0], stage, times[0][1], stage); };
    return {{"threads", threads},
            {"full", part(wall)},
            {"full_trace", part(&Stages::trace)},
            {"full_build", part(&Stages::build)},
            {"full_estimate", part(&Stages::estimate)},
            {"steady", medianRatio(times[1][0], wall, times[1][1], wall)}};
}

Json settingsJson(const Settings& settings) {
    Json list = Json::array();
    for (const std::string& line : settings.effective()) list.push_back(line);
    return list;
}

Reference judge(const Subject& subject, const Settings& settings, const ReferenceOptions& options) {
    const bool shown = isatty(STDERR_FILENO) != 0;
    Reference found = valueOr(reference(subject, settings, options, [&](std::size_t done, std::size_t all) {
        if (shown) fmt::print(stderr, "\rpiebench: path tracing, {} of {} vertices", done, all);
    }));
    if (shown && !found.kept) fmt::print(stderr, "\n");
    return found;
}

Json referenceJson(const Reference& reference, const ReferenceOptions& options) {
    return {{"points", reference.receivers.size()}, {"target", options.target},
            {"reached", reference.reached},         {"own_error_rms", rounded(ownError(reference))},
            {"file", reference.file.string()},      {"kept", reference.kept},
            {"seconds", rounded(reference.seconds)}};
}

} // namespace

double rounded(double value, int digits) {
    if (value == 0 || !std::isfinite(value)) return value;
    const double scale = std::pow(10.0, digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
    return std::round(value * scale) / scale;
}

Json machineJson() {
    const Machine here = machine();
    return {{"processor", here.processor}, {"cores", here.cores}, {"load", load()}};
}

Json measureFrame(const FrameOptions& options, const Settings& settings) {
    if (options.scaling && pie::threads() < 2) throw Stop{"--scaling needs --threads of 2 or more", Misused};
    const LoadedLevel level = valueOr(load(options.level, settings));
    const Subject subject = valueOr(refined(level, options.triangles, settings), Misused);
    const pie::lights::LightSet lights(level.lights, level.scene);
    // The same photons for all: those of a gather.
    pie::photons::TracerOptions tracing = pie::engine::tracerOptions(settingsFor(Estimator::Gather, settings), lights);
    const PhotonCount photons = valueOr(photonsFor(options.photons, accumulated, level, tracing));
    tracing.photonsPerFrame = photons.emitted;

    Json report{{"program", "piebench"}, {"command", "frame"}, {"level", level.name}, {"machine", machineJson()}};
    report["threads"] = pie::threads();
    report["settings"] = settingsJson(settings);
    report["triangles"] = subject.triangles;
    report["coarse_triangles"] = level.scene->triangles.size();
    report["vertices"] = subject.answerOfVertex.size();
    report["receivers"] = subject.receivers.points.size();
    report["lights"] = level.lights.size();
    report["photons"] = {{"asked", options.photons},
                         {"emitted", photons.emitted},
                         {"stored", photons.stored},
                         {"first_hits_stored", tracing.storeDirectLight}};
    report["accumulation_frames"] = accumulated;
    report["repeats"] = options.repeats;
    report["upload"] = "copied into vertex colours; no OpenGL";

    std::optional<Reference> truth;
    if (options.judged && options.measured != Contender::Embree) truth = judge(subject, settings, options.reference);
    report["reference"] = truth ? referenceJson(*truth, options.reference) : Json(nullptr);

    std::vector<Contender> contenders{options.measured};
    contenders.insert(contenders.end(), options.against.begin(), options.against.end());
    std::vector<Turns> all(contenders.size());
    for (std::size_t i = 0; i < contenders.size(); ++i) {
        Turns& turns = all[i];
        turns.contender = contenders[i];
        if (turns.contender == Contender::Embree) {
            turns.rays = std::make_unique<EmbreeRays>(level, settings, tracing, photons.emitted);
            (void)turns.rays->run();
            continue;
        }
        const auto estimator = static_cast<Estimator>(turns.contender);
        turns.full = makeFrames(estimator, subject, settings, tracing, {photons.emitted, 1});
        turns.steady = makeFrames(estimator, subject, settings, tracing, {photons.emitted / accumulated, accumulated});
        turns.full->next();
        for (std::size_t frame = 0; frame < accumulated; ++frame) turns.steady->next();
        if (!truth) continue;
        turns.fullErrors = errors(*truth, turns.full->answers());
        turns.steadyErrors = errors(*truth, turns.steady->answers());
    }
    for (int round = 0; round < options.repeats; ++round)
        for (Turns& turns : all) turns.turn();

    Json runs = Json::array();
    for (const Turns& turns : all) runs.push_back(runJson(turns, subject.which.size()));
    report["runs"] = std::move(runs);
    Json ratios = Json::object();
    for (std::size_t i = 1; i < all.size(); ++i)
        ratios[std::string(nameOf(contenders[i]))] = ratiosJson(all[0], all[i]);
    report["ratios"] = ratios;
    report["scaling"] = options.scaling && all[0].full ? scalingJson(all[0], options.repeats) : Json(nullptr);
    report["targets"] = targetsJson(ratios, report["scaling"]);
    report["load_after"] = load();
    return report;
}

} // namespace piebench
