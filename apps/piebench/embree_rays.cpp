#include "apps/piebench/embree_rays.h"

#include "apps/piebench/frames.h"
#include "pie/core/clock.h"
#include "pie/core/parallel.h"
#include "pie/intersect/intersector.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <mutex>

namespace piebench {
namespace {

using pie::intersect::Hit;
using pie::intersect::Ray;

constexpr std::size_t packet = 16;
constexpr std::size_t taskSize = 1024; // rays, whole packets

/// Keeps the rays that it passes on.
class Recorder final : public pie::intersect::Intersector {
public:
    explicit Recorder(const Intersector& inner) : inner_(inner) {}
    void closest(std::span<const Ray> asked, std::span<Hit> hits) const override {
        {
            const std::lock_guard lock(mutex_);
            rays.insert(rays.end(), asked.begin(), asked.end());
        }
        inner_.closest(asked, hits);
    }
    void occluded(std::span<const Ray> asked, std::span<std::uint8_t> blocked) const override {
        inner_.occluded(asked, blocked);
    }
    [[nodiscard]] std::string_view name() const override { return "recorder"; }
    [[nodiscard]] std::size_t bytes() const override { return 0; }

    mutable std::vector<Ray> rays;

private:
    const Intersector& inner_;
    mutable std::mutex mutex_;
};

std::size_t one(RTCScene scene, RTCIntersectContext& context, const Ray& ray) {
    RTCRayHit query{};
    query.ray.org_x = ray.origin.x;
    query.ray.org_y = ray.origin.y;
    query.ray.org_z = ray.origin.z;
    query.ray.dir_x = ray.direction.x;
    query.ray.dir_y = ray.direction.y;
    query.ray.dir_z = ray.direction.z;
    query.ray.tnear = ray.tMin;
    query.ray.tfar = ray.tMax;
    query.ray.mask = 0xffffffffU;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &query);
    return query.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
}

std::size_t several(RTCScene scene, RTCIntersectContext& context, std::span<const Ray> rays) {
    alignas(64) int valid[packet]{};
    RTCRayHit16 query{};
    for (std::size_t i = 0; i < rays.size(); ++i) {
        valid[i] = -1;
        query.ray.org_x[i] = rays[i].origin.x;
        query.ray.org_y[i] = rays[i].origin.y;
        query.ray.org_z[i] = rays[i].origin.z;
        query.ray.dir_x[i] = rays[i].direction.x;
        query.ray.dir_y[i] = rays[i].direction.y;
        query.ray.dir_z[i] = rays[i].direction.z;
        query.ray.tnear[i] = rays[i].tMin;
        query.ray.tfar[i] = rays[i].tMax;
        query.ray.mask[i] = 0xffffffffU;
        query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, scene, &context, &query);
    std::size_t hits = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) hits += query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
    return hits;
}

/// As the manual of Embree builds one.
class BareScene {
public:
    explicit BareScene(const pie::scene::Scene& scene) : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), scene.positions.size()));
        for (const pie::Vec3& position : scene.positions)
            for (int c = 0; c < 3; ++c) *vertices++ = position[c];
        auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), scene.triangles.size()));
        for (const pie::scene::Triangle& triangle : scene.triangles)
            indices = std::copy(triangle.vertices.begin(), triangle.vertices.end(), indices);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~BareScene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    BareScene(const BareScene&) = delete;
    BareScene& operator=(const BareScene&) = delete;
    [[nodiscard]] RTCScene get() const { return scene_; }

private:
    RTCDevice device_;
    RTCScene scene_;
};

} // namespace

struct EmbreeRays::State {
    State(const LoadedLevel& level, const pie::engine::Settings& settings, const pie::photons::TracerOptions& options,
          std::uint64_t emitted)
        : count(emitted), lights(level.lights, level.scene),
          intersector(pie::intersect::makeIntersector(settings.intersector, *level.scene, level.level->tree)),
          tracer(*level.scene, lights, *intersector, options), bare(*level.scene) {}
    std::uint64_t count;
    pie::lights::LightSet lights;
    std::unique_ptr<pie::intersect::Intersector> intersector;
    pie::photons::PhotonTracer tracer;
    BareScene bare;
    std::vector<pie::photons::Photon> photons;
    std::vector<Ray> rays;
    std::atomic<std::size_t> hits{0}; ///< so that no ray is left out as useless

    /// Milliseconds of wall clock and of the processor.
    template <class Trace> std::pair<double, double> time(const Trace& trace) {
        const auto start = pie::Clock::now();
        const double processor = processorMilliseconds();
        pie::parallelChunks(rays.size(), taskSize, [&](std::size_t begin, std::size_t end) {
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            hits += trace(context, std::span<const Ray>(rays).subspan(begin, end - begin));
        });
        return {pie::millisecondsSince(start), processorMilliseconds() - processor};
    }
};

EmbreeRays::EmbreeRays(const LoadedLevel& level, const pie::engine::Settings& settings,
                       const pie::photons::TracerOptions& options, std::uint64_t count)
    : state_(std::make_unique<State>(level, settings, options, count)) {
    State& s = *state_;
    const Recorder recorder(*s.intersector);
    // In the order of one thread, in which neighbours in a batch stay neighbours.
    const unsigned threads = pie::threads();
    pie::setThreads(1);
    pie::photons::PhotonTracer(*level.scene, s.lights, recorder, options).trace(0, count, s.photons);
    pie::setThreads(threads);
    s.rays = std::move(recorder.rays);
}

EmbreeRays::~EmbreeRays() = default;

std::size_t EmbreeRays::rays() const { return state_->rays.size(); }
std::size_t EmbreeRays::stored() const { return state_->photons.size(); }

EmbreeRays::Times EmbreeRays::run() const {
    State& s = *state_;
    const auto [single, singleProcessor] = s.time([&](RTCIntersectContext& context, std::span<const Ray> rays) {
        std::size_t hits = 0;
        for (const Ray& ray : rays) hits += one(s.bare.get(), context, ray);
        return hits;
    });
    const auto [packets, packetsProcessor] = s.time([&](RTCIntersectContext& context, std::span<const Ray> rays) {
        std::size_t hits = 0;
        for (std::size_t first = 0; first < rays.size(); first += packet)
            hits += several(s.bare.get(), context, rays.subspan(first, std::min(packet, rays.size() - first)));
        return hits;
    });
    const auto start = pie::Clock::now();
    const double processor = processorMilliseconds();
    s.photons.clear();
    s.tracer.trace(0, s.count, s.photons);
    const double tracer = pie::millisecondsSince(start);
    return {single, packets, tracer, singleProcessor, packetsProcessor, processorMilliseconds() - processor};
}

} // namespace piebench
