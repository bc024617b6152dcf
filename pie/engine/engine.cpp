#include "pie/engine/engine.h"

#include "pie/core/parallel.h"
#include "pie/gather/direct.h"
#include "pie/gather/nearest_photons.h"
#include "pie/intersect/intersector.h"
#include "pie/maps/realtime.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>

namespace pie::engine {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

bool showsOurLight(const Settings& settings) { return settings.view == View::Lit || settings.view == View::Light; }

scene::SceneOptions sceneOptions(const Settings& settings) {
    scene::SceneOptions options;
    options.reflectance = settings.reflectance;
    options.maxReflectance = settings.maxReflectance;
    options.linear = settings.colorSpace == ColorSpace::Srgb;
    return options;
}

scene::RefineOptions refineOptions(const Settings& settings) {
    scene::RefineOptions options;
    options.maxSplits = static_cast<std::size_t>(settings.meshRefinement);
    options.maxEdge = settings.maxEdge;
    options.maxTriangles = static_cast<std::size_t>(settings.maxTriangles);
    return options;
}

lights::ImportOptions importOptions(const Settings& settings) {
    lights::ImportOptions options;
    options.entities = settings.lightEntities;
    options.scripts = settings.lightScripts;
    options.backsplash = settings.backsplash;
    options.pointScale = settings.pointScale * settings.lightScale;
    options.areaScale = settings.areaScale * settings.lightScale;
    options.skyScale = settings.skyScale * settings.lightScale;
    options.linear = settings.colorSpace == ColorSpace::Srgb;
    return options;
}

photons::TracerOptions tracerOptions(const Settings& settings) {
    photons::TracerOptions options;
    options.scattering = settings.scattering;
    options.diffuseReflections = static_cast<unsigned>(settings.diffuseReflections);
    options.recursionDepth = static_cast<unsigned>(settings.recursionDepth);
    options.storeDirectLight = settings.storesDirectLight();
    options.seed = settings.seed;
    return options;
}

gather::NearestOptions nearestOptions(const Settings& settings) {
    gather::NearestOptions options;
    options.maxCount = static_cast<std::size_t>(settings.maxSearchCount);
    options.maxRadius = settings.maxSearchRadius;
    options.radiusHeuristic = settings.useRadiusHeuristic;
    options.heuristicAlpha = settings.radiusHeuristicAlpha;
    options.sphereSlice = settings.useSphereSlice;
    options.slice.halfThickness = settings.sphereSlice;
    options.kernel = settings.kernel == KernelKind::Constant ? gather::Kernel::Constant : gather::Kernel::Epanechnikov;
    options.indirectOnly = settings.directLight == DirectLight::ShadowRays;
    return options;
}

} // namespace

/// What tracing and estimating need; made once, by prepare().
struct Transport {
    std::shared_ptr<const scene::Scene> scene;
    lights::ImportedLights imported;
    lights::LightSet lights;
    std::unique_ptr<intersect::Intersector> intersector;
    std::unique_ptr<photons::PhotonTracer> tracer;
    maps::RealtimeMap map;
    std::unique_ptr<gather::TrueArea> area;
    std::unique_ptr<gather::AreaTable> areaTable;
    std::unique_ptr<gather::DirectLight> direct; ///< null: direct light comes from photons
    std::unique_ptr<gather::Estimator> photons;  ///< light from the map
    std::size_t framesTraced = 0;

    Transport(const level::Level& level, const scene::Receivers& receivers, const Settings& settings);
};

Transport::Transport(const level::Level& level, const scene::Receivers& receivers, const Settings& settings)
    : scene(std::make_shared<const scene::Scene>(scene::makeScene(level, sceneOptions(settings)))),
      imported(lights::importLights(level, *scene, importOptions(settings))), lights(imported.lights, scene),
      intersector(intersect::makeIntersector(settings.intersector, *scene, level.tree)),
      tracer(std::make_unique<photons::PhotonTracer>(*scene, lights, *intersector, tracerOptions(settings))),
      map(static_cast<std::size_t>(settings.accumulationFrames),
          settings.photonMap == PhotonMapKind::Exact ? maps::Search::Exact : maps::Search::KdTree) {
    const gather::NearestOptions options = nearestOptions(settings);
    if (settings.directLight == DirectLight::ShadowRays) {
        gather::DirectOptions directOptions;
        directOptions.softSamples = static_cast<unsigned>(settings.directSamples);
        directOptions.absoluteTolerance = settings.directTolerance;
        directOptions.seed = settings.seed;
        direct = std::make_unique<gather::DirectLight>(*scene, lights, *intersector, receivers, directOptions);
    }
    if (settings.estimator == EstimatorKind::TrueArea) {
        area = std::make_unique<gather::TrueArea>(*scene, options.kernel, options.slice, options.maxRadius);
        areaTable = std::make_unique<gather::AreaTable>(*area, receivers);
        photons = std::make_unique<gather::NearestPhotons>(*scene, receivers, map, options, *area, *areaTable);
    } else {
        photons = std::make_unique<gather::NearestPhotons>(*scene, receivers, map, options);
    }
}

/// The paper's estimate cache by index: what a receiver's light was, and of which revision it is.
struct Cache {
    std::vector<Rgb> irradiance;
    std::vector<std::uint64_t> revision; ///< 0: never estimated

    explicit Cache(std::size_t receivers) : irradiance(receivers), revision(receivers, 0) {}
    [[nodiscard]] std::size_t bytes() const { return revision.size() * (sizeof(Rgb) + sizeof(std::uint64_t)); }
};

struct Engine::State {
    std::shared_ptr<const level::Level> level;
    Settings settings;
    scene::Mesh mesh;
    scene::Receivers receivers;
    Cache cache{0};
    std::once_flag prepared;
    std::optional<Transport> transport; ///< written once, under `prepared`
    std::atomic<bool> ready{false};
    std::atomic<std::uint64_t> lightRevision{0};
    std::mutex mutex; ///< map, cache and statistics: advance() swaps a frame in while no estimate runs
    Statistics statistics;

    void estimate(std::span<const std::uint32_t> which, std::uint64_t revision);
};

Engine::Engine(std::shared_ptr<const level::Level> level, const Settings& settings)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.level = std::move(level);
    s.settings = settings;
    s.mesh = scene::makeMesh(*s.level);
    if (showsOurLight(settings)) {
        scene::refine(s.mesh, refineOptions(settings));
        scene::closeTJunctions(s.mesh, settings.tJunctionTolerance);
        s.receivers = scene::makeReceivers(s.mesh, *s.level);
        s.cache = Cache(s.receivers.points.size());
    }
    s.statistics.receivers = s.receivers.points.size();
    s.statistics.drawnTriangles = s.mesh.triangles.size();
    s.statistics.receiverBytes = s.cache.bytes() + s.receivers.points.size() * sizeof(scene::Receiver) +
                                 s.receivers.ofVertex.size() * sizeof(std::uint32_t);
}

Engine::~Engine() = default;

const level::Level& Engine::level() const { return *state_->level; }
const std::shared_ptr<const level::Level>& Engine::sharedLevel() const { return state_->level; }
const Settings& Engine::settings() const { return state_->settings; }
const scene::Mesh& Engine::mesh() const { return state_->mesh; }
const scene::Receivers& Engine::receivers() const { return state_->receivers; }
std::uint64_t Engine::lightRevision() const { return state_->lightRevision; }

void Engine::prepare() {
    State& s = *state_;
    std::call_once(s.prepared, [&s] {
        const auto start = Clock::now();
        s.transport.emplace(*s.level, s.receivers, s.settings);
        const Transport& t = *s.transport;
        const std::lock_guard lock(s.mutex);
        s.statistics.coarseTriangles = t.scene->triangles.size();
        s.statistics.lights = t.lights.lights().size();
        s.statistics.sceneBytes = t.scene->triangles.size() * (sizeof(scene::Triangle) + sizeof(Vec3)) +
                                  t.scene->positions.size() * sizeof(Vec3) +
                                  t.scene->textureCoordinates.size() * sizeof(Vec2);
        s.statistics.intersectorBytes = t.intersector->bytes();
        s.statistics.prepareMs = millisecondsSince(start);
        s.ready = true;
    });
}

const lights::ImportedLights& Engine::lights() const {
    static const lights::ImportedLights none;
    return state_->ready ? state_->transport->imported : none;
}

bool Engine::advance() {
    State& s = *state_;
    if (!showsOurLight(s.settings)) return false;
    prepare();
    Transport& t = *s.transport;
    const auto pool = static_cast<std::size_t>(s.settings.accumulationFrames);
    // The same indices give the same photons: once every frame of the pool is there, a still scene has nothing left to
    // trace.
    if (t.framesTraced >= pool) {
        const std::lock_guard lock(s.mutex);
        ++s.statistics.frames;
        return false;
    }
    const auto start = Clock::now();
    const auto perFrame = static_cast<std::uint64_t>(s.settings.photonsFromLight);
    std::vector<photons::Photon> photons;
    const photons::TraceCounts counts = t.tracer->trace(t.framesTraced * perFrame, perFrame, photons);
    const double traceMs = millisecondsSince(start);

    const std::lock_guard lock(s.mutex);
    const auto build = Clock::now();
    t.map.replaceOldest(std::move(photons));
    t.map.rebuild();
    ++t.framesTraced;
    ++s.lightRevision;
    Statistics& statistics = s.statistics;
    ++statistics.frames;
    ++statistics.framesTraced;
    statistics.photonsEmitted += counts.emitted;
    statistics.raysTraced += counts.rays;
    statistics.photonsStored += counts.stored;
    statistics.photonsEscaped += counts.escaped;
    statistics.photonsInMap = t.map.photons().size();
    statistics.mapBytes = t.map.bytes();
    statistics.traceMs += traceMs;
    statistics.buildMs += millisecondsSince(build);
    return true;
}

void Engine::State::estimate(std::span<const std::uint32_t> which, std::uint64_t revision) {
    auto start = Clock::now();
    std::vector<Rgb> direct(which.size(), Rgb(0.0F));
    if (transport->direct) {
        transport->direct->estimate(which, direct);
        statistics.directEstimates = transport->direct->receiversComputed();
        statistics.directRays = transport->direct->raysTraced();
        statistics.directMs += millisecondsSince(start);
    }
    start = Clock::now();
    std::vector<Rgb> indirect(which.size());
    transport->photons->estimate(which, indirect);
    for (std::size_t i = 0; i < which.size(); ++i) {
        cache.irradiance[which[i]] = direct[i] + indirect[i];
        cache.revision[which[i]] = revision;
    }
    statistics.estimatesMade += which.size();
    statistics.estimateMs += millisecondsSince(start);
}

void Engine::irradiance(std::span<const std::uint32_t> which, std::span<Rgb> out) {
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

Statistics Engine::statistics() const {
    const std::lock_guard lock(state_->mutex);
    return state_->statistics;
}

void Engine::countUpload(double milliseconds) {
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
