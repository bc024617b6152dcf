#include "pie/engine/transport.h"

#include "pie/gather/direct.h"
#include "pie/gather/final_gather.h"
#include "pie/gather/nearest_photons.h"
#include "pie/intersect/intersector.h"
#include "pie/maps/realtime.h"
#include "pie/maps/snowball.h"
#include "pie/photons/tracer.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>

namespace pie::engine {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

photons::TracerOptions tracerOptions(const Settings& settings) {
    photons::TracerOptions options;
    options.scattering = settings.scattering;
    options.diffuseReflections = static_cast<unsigned>(settings.diffuseReflections);
    options.recursionDepth = static_cast<unsigned>(settings.recursionDepth);
    options.storeDirectLight = settings.storesDirectLight();
    options.lightDistribution = settings.lightDistribution;
    options.diffuseDistribution = settings.diffuseDistribution;
    options.photonsPerFrame = static_cast<std::uint64_t>(settings.photonsFromLight);
    options.seed = settings.seed;
    return options;
}

gather::NearestOptions nearestOptions(const Settings& settings) {
    gather::NearestOptions options;
    options.maxCount = static_cast<std::size_t>(settings.maxSearchCount);
    options.maxRadius = settings.maxSearchRadius;
    options.radiusHeuristic = settings.useRadiusHeuristic;
    options.heuristicAlpha = settings.radiusHeuristicAlpha;
    options.radius = settings.searchRadius;
    options.progressiveAlpha = settings.progressiveAlpha;
    options.volume = settings.volume();
    options.slice.halfThickness = settings.sphereSlice;
    options.incomingDirection = settings.useIncomingDirection;
    options.area = settings.usesTrueArea() ? gather::AreaEstimate::True : settings.area;
    options.kernel = settings.kernel;
    options.indirectOnly = settings.directLight == DirectLight::ShadowRays && !settings.finalGathering;
    return options;
}

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
    std::unique_ptr<intersect::Intersector> intersector;
    Settings settings;
    photons::PhotonTracer tracer;
    maps::RealtimeMap map;
    std::unique_ptr<gather::DirectLight> direct;  ///< null: direct light comes from photons
    std::unique_ptr<gather::Estimator> estimator; ///< light from the map
    Cache cache;
    std::size_t framesTraced = 0;
    std::atomic<std::uint64_t> lightRevision{0};
    std::mutex mutex; ///< map, cache and statistics: advance() swaps a frame in while no estimate runs
    Statistics statistics;

    State(std::shared_ptr<const scene::Scene> theScene, std::vector<lights::Light> theLights, const level::Tree& tree,
          const scene::Receivers& receivers, const Settings& theSettings);
    void estimate(std::span<const std::uint32_t> which, std::uint64_t revision);
};

Transport::State::State(std::shared_ptr<const scene::Scene> theScene, std::vector<lights::Light> theLights,
                        const level::Tree& tree, const scene::Receivers& receivers, const Settings& theSettings)
    : scene(std::move(theScene)), lights(std::move(theLights), scene),
      intersector(intersect::makeIntersector(theSettings.intersector, *scene, tree)), settings(theSettings),
      tracer(*scene, lights, *intersector, tracerOptions(theSettings)),
      map(static_cast<std::size_t>(theSettings.accumulationFrames),
          theSettings.photonMap == PhotonMapKind::Exact ? maps::Search::Exact : maps::Search::KdTree),
      cache(receivers.points.size()) {
    const gather::NearestOptions options = nearestOptions(settings);
    if (settings.directLight == DirectLight::ShadowRays) {
        gather::DirectOptions directOptions;
        directOptions.softSamples = static_cast<unsigned>(settings.directSamples);
        directOptions.absoluteTolerance = settings.directTolerance;
        directOptions.seed = settings.seed;
        direct = std::make_unique<gather::DirectLight>(*scene, lights, *intersector, receivers, directOptions);
    }
    if (settings.finalGathering)
        estimator = std::make_unique<gather::FinalGather>(*scene, *intersector, receivers, map, options,
                                                          finalGatherOptions(settings), direct ? &lights : nullptr);
    else
        estimator = std::make_unique<gather::NearestPhotons>(*scene, receivers, map, options);
    statistics.coarseTriangles = scene->triangles.size();
    statistics.lights = lights.lights().size();
    statistics.sceneBytes = scene->triangles.size() * (sizeof(scene::Triangle) + sizeof(Vec3)) +
                            scene->positions.size() * sizeof(Vec3) + scene->textureCoordinates.size() * sizeof(Vec2);
    statistics.intersectorBytes = intersector->bytes();
    statistics.receivers = receivers.points.size();
    statistics.receiverBytes = cache.bytes() + receivers.points.size() * sizeof(scene::Receiver) +
                               receivers.ofVertex.size() * sizeof(std::uint32_t);
}

Transport::Transport(std::shared_ptr<const scene::Scene> scene, std::vector<lights::Light> lights,
                     const level::Tree& tree, const scene::Receivers& receivers, const Settings& settings)
    : state_(std::make_unique<State>(std::move(scene), std::move(lights), tree, receivers, settings)) {}

Transport::~Transport() = default;

const scene::Scene& Transport::scene() const { return *state_->scene; }
std::uint64_t Transport::lightRevision() const { return state_->lightRevision; }

bool Transport::advance() {
    State& s = *state_;
    const auto pool = static_cast<std::size_t>(s.settings.accumulationFrames);
    // The same indices give the same photons: once every frame of the pool is there, a still scene has nothing left to
    // trace.
    if (s.framesTraced >= pool) {
        const std::lock_guard lock(s.mutex);
        ++s.statistics.frames;
        return false;
    }
    const auto start = Clock::now();
    const auto perFrame = static_cast<std::uint64_t>(s.settings.photonsFromLight);
    std::vector<photons::Photon> photons;
    const photons::TraceCounts counts = s.tracer.trace(s.framesTraced * perFrame, perFrame, photons);
    maps::snowball(photons, *s.scene, static_cast<unsigned>(s.settings.snowballSize), s.settings.snowballRadius);
    const double traceMs = millisecondsSince(start);

    const std::lock_guard lock(s.mutex);
    const auto build = Clock::now();
    s.map.replaceOldest(std::move(photons));
    s.map.rebuild();
    ++s.framesTraced;
    ++s.lightRevision;
    Statistics& statistics = s.statistics;
    ++statistics.frames;
    ++statistics.framesTraced;
    statistics.photonsEmitted += counts.emitted;
    statistics.raysTraced += counts.rays;
    statistics.photonsStored += counts.stored;
    statistics.photonsEscaped += counts.escaped;
    statistics.photonsInMap = s.map.photons().size();
    statistics.mapBytes = s.map.bytes();
    statistics.traceMs += traceMs;
    statistics.buildMs += millisecondsSince(build);
    return true;
}

void Transport::State::estimate(std::span<const std::uint32_t> which, std::uint64_t revision) {
    auto start = Clock::now();
    std::vector<Rgb> directLight(which.size(), Rgb(0.0F));
    if (direct) {
        direct->estimate(which, directLight);
        statistics.directEstimates = direct->receiversComputed();
        statistics.directRays = direct->raysTraced();
        statistics.directMs += millisecondsSince(start);
    }
    start = Clock::now();
    std::vector<Rgb> indirect(which.size());
    estimator->estimate(which, indirect);
    for (std::size_t i = 0; i < which.size(); ++i) {
        cache.irradiance[which[i]] = directLight[i] + indirect[i];
        cache.revision[which[i]] = revision;
    }
    statistics.estimatesMade += which.size();
    statistics.estimateMs += millisecondsSince(start);
}

void Transport::irradiance(std::span<const std::uint32_t> which, std::span<Rgb> out) {
    State& s = *state_;
    const std::lock_guard lock(s.mutex);
    const std::uint64_t revision = s.lightRevision;
    if (revision == 0) {
        std::fill(out.begin(), out.end(), Rgb(0.0F));
        return;
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
        out[i].irradiance += direct[i];
        out[i].standardError = std::hypot(out[i].standardError, std::sqrt(variance[i]));
    }
}

Statistics Transport::statistics() const {
    const std::lock_guard lock(state_->mutex);
    return state_->statistics;
}

void Transport::countUpload(double milliseconds) {
    const std::lock_guard lock(state_->mutex);
    state_->statistics.uploadMs += milliseconds;
}

std::string Statistics::json() const {
    return fmt::format(
        R"({{"frames":{},"frames_traced":{},"photons_emitted":{},"rays_traced":{},"photons_stored":{},"photons_escaped":{},)"
        R"("photons_in_map":{},"direct_estimates":{},"direct_rays":{},"estimates_made":{},"estimates_reused":{},"receivers":{},)"
        R"("drawn_triangles":{},"coarse_triangles":{},"lights":{},"prepare_ms":{:.3f},"trace_ms":{:.3f},"build_ms":{:.3f},)"
        R"("direct_ms":{:.3f},"estimate_ms":{:.3f},"upload_ms":{:.3f},"scene_bytes":{},"intersector_bytes":{},"map_bytes":{},"receiver_bytes":{}}})",
        frames, framesTraced, photonsEmitted, raysTraced, photonsStored, photonsEscaped, photonsInMap, directEstimates,
        directRays, estimatesMade, estimatesReused, receivers, drawnTriangles, coarseTriangles, lights, prepareMs,
        traceMs, buildMs, directMs, estimateMs, uploadMs, sceneBytes, intersectorBytes, mapBytes, receiverBytes);
}

} // namespace pie::engine
