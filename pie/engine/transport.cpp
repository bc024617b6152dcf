#include "pie/engine/transport.h"

#include "pie/core/clock.h"
#include "pie/engine/options.h"
#include "pie/engine/transport_state.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace pie::engine {

Transport::Transport(Surroundings surroundings, std::vector<lights::Light> lights, const level::Tree& tree,
                     const scene::Receivers& receivers, const Settings& settings)
    : state_(std::make_unique<State>(std::move(surroundings), std::move(lights), tree, receivers, settings)) {}

Transport::~Transport() = default;

const scene::Scene& Transport::scene() const { return *state_->scene; }
std::uint64_t Transport::lightRevision() const { return state_->lightRevision; }
std::size_t Transport::lightCount() const { return state_->lightCount; }

void Transport::setLight(std::size_t number, std::optional<lights::Light> light) {
    const std::lock_guard lock(state_->mutex);
    state_->setLight(number, std::move(light));
}

bool Transport::advance() {
    State& s = *state_;
    bool lightsChanged = false;
    FrameBudget::Plan plan;
    {
        const std::lock_guard lock(s.mutex);
        s.budget.begin();
        lightsChanged = s.changeLights();
        s.collect();
        plan = s.plan();
    }
    // The same indices give the same photons: once every frame is there, a still scene has nothing left to trace.
    const bool tracing = plan.still > 0 || plan.changing > 0;
    auto start = Clock::now();
    // Summed up, photons are done with: their memory serves the next frame.
    std::vector<photons::Photon> photons = std::move(s.spent);
    photons.clear();
    photons::TraceCounts counts;
    if (plan.still > 0) counts = s.traceStill(plan.still, photons);
    const double stillMs = millisecondsSince(start);
    start = Clock::now();
    if (plan.changing > 0) counts += s.changing->trace(plan.changing);
    const double changingMs = millisecondsSince(start);

    const std::lock_guard lock(s.mutex);
    Statistics& statistics = s.statistics;
    ++statistics.frames;
    if (tracing) {
        ++statistics.framesTraced;
        s.count(counts);
        statistics.traceMs += stillMs + changingMs;
        start = Clock::now();
        if (plan.still > 0) s.take(std::move(photons), plan.still);
        const double takeMs = millisecondsSince(start);
        if (plan.changing > 0) statistics.photonsInMap += static_cast<std::uint64_t>(s.changing->apply(*s.gathering));
        const double buildMs = millisecondsSince(start);
        statistics.buildMs += buildMs;
        s.budget.report(FrameBudget::Kind::TraceStill, plan.still, stillMs + takeMs);
        s.budget.report(FrameBudget::Kind::TraceChanging, plan.changing, changingMs + buildMs - takeMs);
    }
    const bool refined = s.refine(plan.rays);
    if (lightsChanged) s.convergence.restart();
    s.judge(refined);
    const bool changed = tracing || refined || lightsChanged;
    const bool asked = s.askedInRound;
    if (changed) {
        s.askedInRound = false;
        s.behind = true;
        ++s.lightRevision;
    }
    // While light changes, who does not ask gets no answers; when it stands still, what was asked for last is brought
    // up to date.
    const bool answered = (asked || !changed) && s.answer(plan.receivers);
    statistics.still = !changed && !answered;
    return changed || answered;
}

void Transport::finish(std::span<const std::uint32_t> which) {
    State& s = *state_;
    if (!s.gathering) return;
    const std::lock_guard lock(s.mutex);
    s.ask(which);
    const auto start = Clock::now();
    s.statistics.gatherRays += s.gathering->refine(which, std::numeric_limits<std::uint64_t>::max());
    s.statistics.refineMs += millisecondsSince(start);
    s.behind = true;
    ++s.lightRevision;
}

bool Transport::irradiance(std::span<const std::uint32_t> which, std::span<Rgb> out) {
    State& s = *state_;
    const std::lock_guard lock(s.mutex);
    const std::uint64_t revision = s.lightRevision;
    if (revision == 0) {
        std::fill(out.begin(), out.end(), Rgb(0.0F));
        return true;
    }
    s.ask(which);
    s.missing.clear();
    std::size_t deferred = 0;
    for (const std::uint32_t r : which) {
        if (s.settings.useEstimateCache && s.cache.revision[r] == revision) continue;
        if (s.budget.bounded() && s.cache.revision[r] != 0)
            ++deferred; // its turn comes in one of the next frames
        else
            s.missing.push_back(r);
    }
    s.statistics.estimatesReused += which.size() - s.missing.size() - deferred;
    s.statistics.estimatesDeferred += deferred;
    s.behind = s.behind || deferred > 0;
    if (!s.missing.empty()) s.estimate(s.missing, revision);
    for (std::size_t i = 0; i < which.size(); ++i) out[i] = s.cache.irradiance[which[i]];
    return deferred == 0;
}

void Transport::explain(std::span<const std::uint32_t> which, std::span<gather::Estimate> out) {
    const std::lock_guard lock(state_->mutex);
    state_->explain(which, out);
}

void Transport::samples(std::span<const std::uint32_t> which, std::span<std::uint32_t> out) {
    State& s = *state_;
    const std::lock_guard lock(s.mutex);
    s.ask(which);
    if (s.gathering) {
        for (std::size_t i = 0; i < which.size(); ++i) out[i] = s.gathering->samples(which[i]);
        return;
    }
    std::vector<gather::Estimate> estimates(which.size());
    s.estimator->explain(which, estimates);
    for (std::size_t i = 0; i < which.size(); ++i) out[i] = estimates[i].photons;
}

std::vector<photons::Photon> Transport::photons(std::uint64_t count) {
    State& s = *state_;
    photons::TracerOptions options = tracerOptions(s.settings, s.lights);
    options.storeDirectLight = true;
    std::vector<photons::Photon> hits;
    photons::PhotonTracer(*s.scene, s.lights, *s.intersector, options).trace(0, count, hits);
    if (s.changing) s.changing->sample(count, hits);
    return hits;
}

Statistics Transport::statistics() const {
    const std::lock_guard lock(state_->mutex);
    const State& s = *state_;
    Statistics statistics = s.statistics;
    statistics.estimatorBytes = s.estimator->bytes() + (s.changing ? s.changing->bytes() : 0);
    statistics.directBytes = s.direct ? s.direct->bytes() : 0;
    statistics.frameMsMedian = s.budget.median();
    statistics.frameMs95 = s.budget.percentile95();
    return statistics;
}

void Transport::countUpload(double milliseconds) {
    const std::lock_guard lock(state_->mutex);
    state_->statistics.uploadMs += milliseconds;
    state_->budget.report(FrameBudget::Kind::Upload, 1, milliseconds);
}

} // namespace pie::engine
