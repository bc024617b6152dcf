// Embree 3. Robust traversal, so that its answers at shared edges are those of the other two.

#include "pie/intersect/intersectors.h"
#include "pie/intersect/triangle_test.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

namespace pie::intersect {
namespace {

struct DeviceRelease {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneRelease {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct GeometryRelease {
    void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<RTCDeviceTy, DeviceRelease>;
using SceneHandle = std::unique_ptr<RTCSceneTy, SceneRelease>;
using Geometry = std::unique_ptr<RTCGeometryTy, GeometryRelease>;

/// Embree answers tNear < t <= tFar, we promise tMin <= t < tMax. At zero nothing is left to step back to: Debian's
/// Embree asserts that tNear is not negative.
float nearOf(const Ray& ray) { return ray.tMin > 0.0F ? std::nextafter(ray.tMin, 0.0F) : 0.0F; }
float farOf(const Ray& ray) { return std::isinf(ray.tMax) ? ray.tMax : std::nextafter(ray.tMax, 0.0F); }

RTCRay toEmbree(const Ray& ray) {
    RTCRay out{};
    out.org_x = ray.origin.x;
    out.org_y = ray.origin.y;
    out.org_z = ray.origin.z;
    out.dir_x = ray.direction.x;
    out.dir_y = ray.direction.y;
    out.dir_z = ray.direction.z;
    out.tnear = nearOf(ray);
    out.tfar = farOf(ray);
    out.mask = 0xffffffffU;
    return out;
}

class Embree final : public Intersector {
public:
    /// `device` is not null.
    Embree(Device device, const scene::Scene& scene) : device_(std::move(device)) {
        rtcSetDeviceMemoryMonitorFunction(device_.get(), &countBytes, &bytes_);
        for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
            if (scene.normals[t] == Vec3(0.0F)) continue;
            triangles_[isOpaque(scene, t) ? 0 : 1].push_back(static_cast<std::uint32_t>(t));
        }
        const Geometry opaque(makeGeometry(scene, triangles_[0]));
        opaque_.reset(makeScene({opaque.get()}));
        if (triangles_[1].empty()) return;
        const Geometry others(makeGeometry(scene, triangles_[1]));
        all_.reset(makeScene({opaque.get(), others.get()}));
    }

    void closest(std::span<const Ray> rays, std::span<Hit> hits) const override {
        RTCScene scene = all_ ? all_.get() : opaque_.get();
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            hits[i] = Hit{};
            if (!usable(rays[i])) continue;
            RTCRayHit ray{};
            ray.ray = toEmbree(rays[i]);
            ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene, &context, &ray);
            if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
            hits[i] = {triangles_[ray.hit.geomID][ray.hit.primID], std::max(ray.ray.tfar, 0.0F), ray.hit.u, ray.hit.v};
        }
    }

    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const override {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            blocked[i] = 0;
            if (!usable(rays[i])) continue;
            RTCRay ray = toEmbree(rays[i]);
            rtcOccluded1(opaque_.get(), &context, &ray);
            blocked[i] = ray.tfar < 0.0F ? 1 : 0;
        }
    }

    [[nodiscard]] std::string_view name() const override { return "Embree"; }
    [[nodiscard]] std::size_t bytes() const override {
        const auto held = std::max<std::ptrdiff_t>(bytes_.load(), 0);
        return sizeof(*this) + static_cast<std::size_t>(held) +
               (triangles_[0].capacity() + triangles_[1].capacity()) * sizeof(std::uint32_t);
    }

private:
    static bool countBytes(void* sum, std::ptrdiff_t bytes, bool /*post*/) {
        *static_cast<std::atomic<std::ptrdiff_t>*>(sum) += bytes;
        return true;
    }

    [[nodiscard]] RTCGeometry makeGeometry(const scene::Scene& scene,
                                           const std::vector<std::uint32_t>& triangles) const {
        RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        if (!triangles.empty()) {
            void* positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                      sizeof(Vec3), scene.positions.size());
            std::memcpy(positions, scene.positions.data(), scene.positions.size() * sizeof(Vec3));
            auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
                geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles.size()));
            for (const std::uint32_t t : triangles)
                indices = std::copy(scene.triangles[t].vertices.begin(), scene.triangles[t].vertices.end(), indices);
        }
        rtcCommitGeometry(geometry);
        return geometry;
    }

    [[nodiscard]] RTCScene makeScene(std::initializer_list<RTCGeometry> geometries) const {
        RTCScene scene = rtcNewScene(device_.get());
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        unsigned id = 0;
        for (RTCGeometry geometry : geometries) rtcAttachGeometryByID(scene, geometry, id++);
        // One thread builds the same hierarchy every time, so of two triangles at the same distance the same one is
        // hit.
        tbb::task_arena(1).execute([&] { rtcCommitScene(scene); });
        return scene;
    }

    std::atomic<std::ptrdiff_t> bytes_{0}; ///< outlives the device, which reports its last frees to it
    Device device_;
    SceneHandle opaque_, all_;                            ///< all_: only when there is something that is not Opaque
    std::array<std::vector<std::uint32_t>, 2> triangles_; ///< geometry and primitive → Scene::triangles
};

} // namespace

std::unique_ptr<Intersector> makeEmbree(const scene::Scene& scene) {
    Device device(rtcNewDevice(nullptr));
    // A processor that Embree does not know: the answers are the same, only slower.
    if (!device) return makeBspTree(scene, {});
    return std::make_unique<Embree>(std::move(device), scene);
}

} // namespace pie::intersect
