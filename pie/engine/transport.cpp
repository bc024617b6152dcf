#include "pie/engine/transport.h"

#include "pie/core/clock.h"
#include "pie/engine/options.h"
#include "pie/gather/cached_gather.h"
#include "pie/gather/direct.h"
#include "pie/gather/final_gather.h"
#include "pie/gather/nearest_photons.h"
#include "pie/maps/realtime.h"
#include "pie/maps/snowball.h"
#include "pie/photons/tracer.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

namespace pie::engine {
namespace {

gather::FinalGatherOptions finalGatherOptions(const Settings& settings) {
    gather::FinalGatherOptions options;
    options.samples = static_cast<unsigned>(settings.finalGatheringSamples);
    options.secondaryDistance = settings.finalGatheringDistance;
    options.secondarySamples = static_cast<unsigned>(settings.finalGatheringSecondary);
    options.precompute = static_cast<unsigned>(settings.precomputeIrradiance);
    options.cacheAccuracy = settings.irradianceCache;
    options.addDirect = settings.directLight == DirectLight::Photons;
    options.seed = settings.seed;
    return options;
}

/// But for what lights decide.
gather::GatherOptions gatherOptions(const Settings& settings) {
    gather::GatherOptions options;
    options.texels.edge = settings.texelSize;
    options.rays = static_cast<unsigned>(settings.gatherRays);
    options.reflections = static_cast<unsigned>(settings.recursionDepth);
    options.standardErrors = settings.standardErrors;
    options.seed = settings.seed;
    return options;
}

/// Null where photons are one map.
std::shared_ptr<const maps::Partition> partition(const Settings& settings, const scene::Scene& scene,
                                                 const level::Tree& tree) {
    if (gathers(settings) || settings.splitMaps == maps::SplitBy::None) return nullptr;
    return std::make_shared<const maps::Partition>(scene, tree, settings.splitMaps);
}

/// The paper's estimate cache by index: what a receiver's light was, and of which revision it is.
struct Cache {
    std::vector<Rgb> irradiance;
    std::vector<std::uint64_t> revision; ///< 0: never estimated

    explicit Cache(std::size_t receivers) : irradiance(receivers), revision(receivers, 0) {}
    [[nodiscard]] std::size_t bytes() const { return revision.size() * (sizeof(Rgb) + sizeof(std::uint64_t)); }
};

} // namespace

struct Transport::State {
    std::shared_ptr<const scene::Scene> scene;
    lights::LightSet lights;
    std::unique_ptr<const intersect::Intersector> intersector;
    Settings settings;
    photons::PhotonTracer tracer;
    maps::RealtimeMap map;
    std::unique_ptr<gather::DirectLight> direct;  ///< null: direct light comes from photons
    std::unique_ptr<gather::Estimator> estimator; ///< light from the map, or all light where it gathers
    gather::CachedGather* gathering = nullptr;    ///< the estimator, when it is one: then there is no map
    Cache cache;
    std::vector<std::uint64_t> asked; ///< by receiver: round of its last question; for gathering alone
    std::vector<std::uint32_t> wanted;
    /// Questions between two frames are a round. Frames without any go on with the last.
    std::uint64_t round = 1;
    bool askedInRound = false;
    std::size_t framesTraced = 0;
    std::vector<photons::Photon> spent; ///< memory for the next frame of a gather
    std::atomic<std::uint64_t> lightRevision{0};
    std::mutex mutex; ///< map, cache and statistics: advance() swaps a frame in while no estimate runs
    Statistics statistics;

    State(Surroundings&& around, std::vector<lights::Light> theLights, const level::Tree& tree,
          const scene::Receivers& receivers, const Settings& theSettings);
    void estimate(std::span<const std::uint32_t> which, std::uint64_t revision);
    [[nodiscard]] std::size_t framesToTrace() const;
    void aim(gather::CachedGather& gather);
    void take(std::vector<photons::Photon>&& photons);
    bool refine();
};

Transport::State::State(Surroundings&& around, std::vector<lights::Light> theLights, const level::Tree& tree,
                        const scene::Receivers& receivers, const Settings& theSettings)
    : scene(std::move(around.scene)), lights(std::move(theLights), scene), intersector(std::move(around.intersector)),
      settings(theSettings), tracer(*scene, lights, *intersector, tracerOptions(theSettings, lights)),
      map(static_cast<std::size_t>(theSettings.accumulationFrames),
          theSettings.photonMap == PhotonMapKind::Exact ? maps::Search::Exact : maps::Search::KdTree,
          partition(theSettings, *scene, tree)),
      cache(receivers.points.size()) {
    const gather::NearestOptions options = nearestOptions(settings);
    if (settings.directLight == DirectLight::ShadowRays) {
        gather::DirectOptions directOptions;
        directOptions.softSamples = static_cast<unsigned>(settings.directSamples);
        directOptions.absoluteTolerance = settings.directTolerance;
        directOptions.seed = settings.seed;
        direct = std::make_unique<gather::DirectLight>(*scene, lights, *intersector, receivers, directOptions);
    }
    if (settings.finalGathering) {
        estimator = std::make_unique<gather::FinalGather>(*scene, *intersector, receivers, map, options,
                                                          finalGatherOptions(settings), direct ? &lights : nullptr);
    } else if (gathers(settings)) {
        gather::GatherOptions gatherSettings = gatherOptions(settings);
        gatherSettings.texelsByPhotons = texelsByPhotons(settings, lights);
        auto gather = std::make_unique<gather::CachedGather>(*scene, lights, *intersector, receivers, direct.get(),
                                                             gatherSettings, std::move(around.texels));
        gathering = gather.get();
        if (settings.recursionDepth > 0 && settings.aimedRays) aim(*gather);
        estimator = std::move(gather);
        asked.assign(receivers.points.size(), 0);
    } else {
        estimator = std::make_unique<gather::NearestPhotons>(*scene, receivers, map, options);
    }
    statistics.coarseTriangles = scene->triangles.size();
    statistics.lights = lights.lights().size();
    statistics.sceneBytes = scene->triangles.size() * (sizeof(scene::Triangle) + sizeof(Vec3)) +
                            scene->positions.size() * sizeof(Vec3) + scene->textureCoordinates.size() * sizeof(Vec2);
    statistics.intersectorBytes = intersector->bytes();
    statistics.receivers = receivers.points.size();
    statistics.receiverBytes = cache.bytes() + receivers.points.size() * sizeof(scene::Receiver) +
                               receivers.ofVertex.size() * sizeof(std::uint32_t);
}

/// Enough photons to tell what is bright, however many a frame has.
void Transport::State::aim(gather::CachedGather& gather) {
    constexpr std::uint64_t most = 100'000;
    photons::TracerOptions options = tracerOptions(settings, lights);
    options.recursionDepth = 0;
    options.storeDirectLight = true;
    const photons::PhotonTracer firstHits(*scene, lights, *intersector, options);
    std::vector<photons::Photon> hits;
    const auto perFrame = static_cast<std::uint64_t>(settings.photonsFromLight);
    statistics.raysTraced += firstHits.trace(0, std::min(perFrame, most), hits).rays;
    gather.aim(hits);
}

Surroundings makeSurroundings(std::shared_ptr<const scene::Scene> scene, const level::Tree& tree,
                              const Settings& settings) {
    Surroundings around;
    around.intersector = intersect::makeIntersector(settings.intersector, *scene, tree);
    if (gathers(settings)) around.texels = gather::CachedGather::makeTexels(*scene, gatherOptions(settings));
    around.scene = std::move(scene);
    return around;
}

Transport::Transport(Surroundings surroundings, std::vector<lights::Light> lights, const level::Tree& tree,
                     const scene::Receivers& receivers, const Settings& settings)
    : state_(std::make_unique<State>(std::move(surroundings), std::move(lights), tree, receivers, settings)) {}

Transport::~Transport() = default;

const scene::Scene& Transport::scene() const { return *state_->scene; }
std::uint64_t Transport::lightRevision() const { return state_->lightRevision; }

std::size_t Transport::State::framesToTrace() const {
    return static_cast<std::size_t>(gathering ? settings.stillFrames : settings.accumulationFrames);
}

void Transport::State::take(std::vector<photons::Photon>&& photons) {
    const auto start = Clock::now();
    if (gathering) {
        gathering->add(photons);
        statistics.photonsInMap += photons.size();
        if (framesTraced + 1 < framesToTrace()) spent = std::move(photons);
    } else {
        map.replaceOldest(std::move(photons));
        map.rebuild();
        statistics.photonsInMap = map.photons().size();
        statistics.mapBytes = map.bytes();
    }
    ++framesTraced;
    ++statistics.framesTraced;
    statistics.buildMs += millisecondsSince(start);
}

/// Spends the rays of a frame on what was asked for since the last one. Returns whether any light changed.
bool Transport::State::refine() {
    if (!gathering) return false;
    const auto start = Clock::now();
    wanted.clear();
    for (std::uint32_t r = 0; r < asked.size(); ++r)
        if (asked[r] == round && !gathering->finished(r)) wanted.push_back(r);
    statistics.unfinished = wanted.size();
    if (wanted.empty()) {
        gathering->update();
        return false;
    }
    statistics.gatherRays += gathering->refine(wanted, static_cast<std::uint64_t>(settings.refineRays));
    statistics.refineMs += millisecondsSince(start);
    return true;
}

bool Transport::advance() {
    State& s = *state_;
    // The same indices give the same photons: once every frame is there, a still scene has nothing left to trace.
    const bool tracing = s.framesTraced < s.framesToTrace();
    const auto start = Clock::now();
    // Summed up, photons are done with: their memory serves the next frame.
    std::vector<photons::Photon> photons = std::move(s.spent);
    photons.clear();
    photons::TraceCounts counts;
    if (tracing) {
        const auto perFrame = static_cast<std::uint64_t>(s.settings.photonsFromLight);
        counts = s.tracer.trace(s.framesTraced * perFrame, perFrame, photons);
        maps::snowball(photons, *s.scene, static_cast<unsigned>(s.settings.snowballSize), s.settings.snowballRadius);
    }
    const double traceMs = millisecondsSince(start);

    const std::lock_guard lock(s.mutex);
    Statistics& statistics = s.statistics;
    ++statistics.frames;
    if (tracing) {
        statistics.photonsEmitted += counts.emitted;
        statistics.raysTraced += counts.rays;
        statistics.photonsStored += counts.stored;
        statistics.photonsEscaped += counts.escaped;
        statistics.traceMs += traceMs;
        s.take(std::move(photons));
    }
    const bool refined = s.refine();
    if (refined || tracing) s.askedInRound = false;
    if (tracing || refined) ++s.lightRevision;
    return tracing || refined;
}

void Transport::State::estimate(std::span<const std::uint32_t> which, std::uint64_t revision) {
    auto start = Clock::now();
    std::vector<Rgb> light(which.size(), Rgb(0.0F));
    if (direct && !gathering) {
        std::vector<Rgb> directLight(which.size());
        direct->estimate(which, directLight);
        statistics.directMs += millisecondsSince(start);
        start = Clock::now();
        estimator->estimate(which, light);
        for (std::size_t i = 0; i < which.size(); ++i) light[i] += directLight[i];
    } else {
        estimator->estimate(which, light);
    }
    if (direct) {
        statistics.directEstimates = direct->receiversComputed();
        statistics.directRays = direct->raysTraced();
    }
    const maps::Visits visits = estimator->visits();
    statistics.mapNodesVisited = visits.nodes + visits.leaves;
    statistics.mapPhotonsVisited = visits.photons;
    for (std::size_t i = 0; i < which.size(); ++i) {
        cache.irradiance[which[i]] = light[i];
        cache.revision[which[i]] = revision;
    }
    statistics.estimatesMade += which.size();
    statistics.estimateMs += millisecondsSince(start);
}

void Transport::finish(std::span<const std::uint32_t> which) {
    State& s = *state_;
    if (!s.gathering) return;
    const std::lock_guard lock(s.mutex);
    const auto start = Clock::now();
    s.statistics.gatherRays += s.gathering->refine(which, std::numeric_limits<std::uint64_t>::max());
    s.statistics.refineMs += millisecondsSince(start);
    ++s.lightRevision;
}

void Transport::irradiance(std::span<const std::uint32_t> which, std::span<Rgb> out) {
    State& s = *state_;
    const std::lock_guard lock(s.mutex);
    const std::uint64_t revision = s.lightRevision;
    if (revision == 0) {
        std::fill(out.begin(), out.end(), Rgb(0.0F));
        return;
    }
    if (s.gathering) {
        if (!s.askedInRound) ++s.round;
        s.askedInRound = true;
        for (const std::uint32_t r : which) s.asked[r] = s.round;
    }
    std::vector<std::uint32_t> wanted;
    for (const std::uint32_t r : which)
        if (!s.settings.useEstimateCache || s.cache.revision[r] != revision) wanted.push_back(r);
    s.statistics.estimatesReused += which.size() - wanted.size();
    if (!wanted.empty()) s.estimate(wanted, revision);
    for (std::size_t i = 0; i < which.size(); ++i) out[i] = s.cache.irradiance[which[i]];
}

void Transport::explain(std::span<const std::uint32_t> which, std::span<gather::Estimate> out) {
    State& s = *state_;
    const std::lock_guard lock(s.mutex);
    s.estimator->explain(which, out);
    if (!s.direct) return;
    std::vector<Rgb> direct(which.size());
    std::vector<float> variance(which.size());
    s.direct->estimate(which, direct, variance);
    for (std::size_t i = 0; i < which.size(); ++i) {
        if (!s.gathering) out[i].irradiance += direct[i];
        out[i].standardError = std::hypot(out[i].standardError, std::sqrt(variance[i]));
    }
}

Statistics Transport::statistics() const {
    const std::lock_guard lock(state_->mutex);
    Statistics statistics = state_->statistics;
    statistics.estimatorBytes = state_->estimator->bytes();
    statistics.directBytes = state_->direct ? state_->direct->bytes() : 0;
    return statistics;
}

void Transport::countUpload(double milliseconds) {
    const std::lock_guard lock(state_->mutex);
    state_->statistics.uploadMs += milliseconds;
}

std::string Statistics::json() const {
    return fmt::format(
        R"({{"frames":{},"frames_traced":{},"photons_emitted":{},"rays_traced":{},"photons_stored":{},"photons_escaped":{},)"
        R"("photons_in_map":{},"map_nodes_visited":{},"map_photons_visited":{},"direct_estimates":{},"direct_rays":{},"estimates_made":{},"estimates_reused":{},"gather_rays":{},"unfinished":{},"receivers":{},)"
        R"("drawn_triangles":{},"coarse_triangles":{},"lights":{},"prepare_ms":{:.3f},"trace_ms":{:.3f},"build_ms":{:.3f},)"
        R"("direct_ms":{:.3f},"refine_ms":{:.3f},"estimate_ms":{:.3f},"upload_ms":{:.3f},"scene_bytes":{},"intersector_bytes":{},"map_bytes":{},"receiver_bytes":{},"estimator_bytes":{},"direct_bytes":{}}})",
        frames, framesTraced, photonsEmitted, raysTraced, photonsStored, photonsEscaped, photonsInMap, mapNodesVisited,
        mapPhotonsVisited, directEstimates, directRays, estimatesMade, estimatesReused, gatherRays, unfinished,
        receivers, drawnTriangles, coarseTriangles, lights, prepareMs, traceMs, buildMs, directMs, refineMs, estimateMs,
        uploadMs, sceneBytes, intersectorBytes, mapBytes, receiverBytes, estimatorBytes, directBytes);
}

} // namespace pie::engine
