// Embree 3. Robust traversal, so that its answers at shared edges are those of the other two.
//
// What is nearest is found by streams (wide_tree.h) in a tree that Embree builds, where the processor can: for rays
// without order that is faster than Embree's own traversal. Elsewhere, and for whether anything is hit, Embree is
// asked.
//
// Rays that stay together go in packets of 16, which is three to eight times faster; others alone. An answer must not
// depend on the company a ray keeps: distances are the same to the bit either way, but of two triangles at the same
// distance Embree reports the one it came to last. So on triangles that lie on top of each other the shared triangle
// test decides, as everywhere else, and on edges a ray of a packet is asked again alone.

#include "pie/intersect/intersectors.h"
#include "pie/intersect/overlap.h"
#include "pie/intersect/triangle_test.h"
#include "pie/intersect/wide_tree.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <iterator>
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

/// Embree's limits are inclusive.
float nearOf(const Ray& ray) { return std::max(ray.tMin, 0.0F); }
float farOf(const Ray& ray) { return std::isinf(ray.tMax) ? ray.tMax : std::nextafter(ray.tMax, 0.0F); }

constexpr std::size_t width = 16;
/// Measured on shipped levels: beyond these, a packet is no faster than its rays one by one. Extent of the 16 unit
/// directions; extent of the origins as a share of the scene's diagonal.
constexpr float togetherDirections = 0.4F;
constexpr float togetherOrigins = 0.03F;
/// Barycentric weight below which a hit counts as on an edge.
constexpr float onEdge = 1e-4F;

float largest(const Vec3& v) { return glm::max(v.x, glm::max(v.y, v.z)); }

/// Sixteen rays that can hit something.
bool together(std::span<const Ray> rays, float originExtent) {
    Vec3 lowest = rays[0].direction;
    Vec3 highest = lowest;
    Vec3 lower = rays[0].origin;
    Vec3 upper = lower;
    bool all = usable(rays[0]);
    for (const Ray& ray : rays.subspan(1)) {
        all = all && usable(ray);
        lowest = glm::min(lowest, ray.direction);
        highest = glm::max(highest, ray.direction);
        lower = glm::min(lower, ray.origin);
        upper = glm::max(upper, ray.origin);
    }
    return all && largest(highest - lowest) <= togetherDirections && largest(upper - lower) <= originExtent;
}

void set(RTCRay16& out, std::size_t i, const Ray& ray) {
    out.org_x[i] = ray.origin.x;
    out.org_y[i] = ray.origin.y;
    out.org_z[i] = ray.origin.z;
    out.dir_x[i] = ray.direction.x;
    out.dir_y[i] = ray.direction.y;
    out.dir_z[i] = ray.direction.z;
    out.tnear[i] = nearOf(ray);
    out.tfar[i] = farOf(ray);
    out.time[i] = 0;
    out.mask[i] = 0xffffffffU;
    out.id[i] = 0;
    out.flags[i] = 0;
}

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
    Embree(Device device, const scene::Scene& scene, bool streams) : scene_(scene), device_(std::move(device)) {
        rtcSetDeviceMemoryMonitorFunction(device_.get(), &countBytes, &bytes_);
        for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
            if (scene.normals[t] == Vec3(0.0F)) continue;
            triangles_[isOpaque(scene, t) ? 0 : 1].push_back(static_cast<std::uint32_t>(t));
        }
        originExtent_ = togetherOrigins * glm::length(scene.bounds.size());
        const Geometry opaque(makeGeometry(scene, triangles_[0]));
        opaque_.reset(makeScene({opaque.get()}));
        if (streams) {
            std::vector<std::uint32_t> both;
            std::merge(triangles_[0].begin(), triangles_[0].end(), triangles_[1].begin(), triangles_[1].end(),
                       std::back_inserter(both));
            streams_ = std::make_unique<WideTree>(scene, both);
            return;
        }
        overlaps_ = findOverlaps(scene);
        if (triangles_[1].empty()) return;
        const Geometry others(makeGeometry(scene, triangles_[1]));
        all_.reset(makeScene({opaque.get(), others.get()}));
    }

    void closest(std::span<const Ray> rays, std::span<Hit> hits) const override {
        if (streams_) return streams_->closest(rays, hits);
        std::size_t i = 0;
        for (; i + width <= rays.size(); i += width) {
            const std::span<const Ray> some = rays.subspan(i, width);
            if (together(some, originExtent_))
                closestTogether(some, hits.subspan(i, width));
            else
                closestAlone(some, hits.subspan(i, width));
        }
        closestAlone(rays.subspan(i), hits.subspan(i));
    }

    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const override {
        for (std::size_t i = 0; i < rays.size(); i += width) {
            const std::size_t count = std::min(width, rays.size() - i);
            occludedTogether(rays.subspan(i, count), blocked.subspan(i, count));
        }
    }

    [[nodiscard]] std::string_view name() const override { return "Embree"; }
    [[nodiscard]] std::size_t bytes() const override {
        const auto held = std::max<std::ptrdiff_t>(bytes_.load(), 0);
        return sizeof(*this) + static_cast<std::size_t>(held) + (streams_ ? sizeof(WideTree) + streams_->bytes() : 0) +
               (triangles_[0].capacity() + triangles_[1].capacity()) * sizeof(std::uint32_t) +
               (overlaps_.begin.capacity() + overlaps_.others.capacity()) * sizeof(std::uint32_t);
    }

private:
    [[nodiscard]] RTCScene everything() const { return all_ ? all_.get() : opaque_.get(); }

    /// What Embree found, or of the triangles that lie on it the one that brute force would name.
    [[nodiscard]] Hit hitOf(const Ray& ray, std::uint32_t geometry, std::uint32_t primitive, const Hit& found) const {
        if (geometry == RTC_INVALID_GEOMETRY_ID) return {};
        Hit hit = found;
        hit.triangle = triangles_[geometry][primitive];
        const std::span<const std::uint32_t> others = overlaps_.of(hit.triangle);
        if (others.empty()) return hit;
        Hit chosen;
        Nearest nearest(ray, chosen);
        nearest.test(hit.triangle, corners(hit.triangle));
        for (const std::uint32_t other : others) nearest.test(other, corners(other));
        return chosen.found() ? chosen : hit;
    }

    [[nodiscard]] std::array<Vec3, 3> corners(std::size_t t) const {
        return {scene_.corner(t, 0), scene_.corner(t, 1), scene_.corner(t, 2)};
    }

    void closestAlone(std::span<const Ray> rays, std::span<Hit> hits) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            hits[i] = Hit{};
            if (!usable(rays[i])) continue;
            RTCRayHit ray{};
            ray.ray = toEmbree(rays[i]);
            ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(everything(), &context, &ray);
            hits[i] = hitOf(rays[i], ray.hit.geomID, ray.hit.primID, {0, ray.ray.tfar, ray.hit.u, ray.hit.v});
        }
    }

    static bool onAnEdge(const Hit& hit) { return std::min({hit.u, hit.v, 1.0F - hit.u - hit.v}) < onEdge; }

    void closestTogether(std::span<const Ray> rays, std::span<Hit> hits) const {
        alignas(64) std::array<int, width> valid{};
        valid.fill(-1);
        RTCRayHit16 packet;
        for (std::size_t i = 0; i < width; ++i) {
            set(packet.ray, i, rays[i]);
            packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        }
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        rtcIntersect16(valid.data(), everything(), &context, &packet);
        for (std::size_t i = 0; i < width; ++i) {
            const Hit found{0, packet.ray.tfar[i], packet.hit.u[i], packet.hit.v[i]};
            hits[i] = hitOf(rays[i], packet.hit.geomID[i], packet.hit.primID[i], found);
            if (hits[i].found() && onAnEdge(found)) closestAlone(rays.subspan(i, 1), hits.subspan(i, 1));
        }
    }

    /// At most sixteen rays. That any triangle is hit is the same alone or together.
    void occludedTogether(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const {
        alignas(64) std::array<int, width> valid{};
        RTCRay16 packet;
        for (std::size_t i = 0; i < rays.size(); ++i)
            if (usable(rays[i])) {
                valid[i] = -1;
                set(packet, i, rays[i]);
            }
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        if (rays.size() == width && together(rays, originExtent_)) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        rtcOccluded16(valid.data(), opaque_.get(), &context, &packet);
        for (std::size_t i = 0; i < rays.size(); ++i) blocked[i] = valid[i] != 0 && packet.tfar[i] < 0.0F ? 1 : 0;
    }

    static bool countBytes(void* sum, std::ptrdiff_t bytes, bool /*post*/) {
        *static_cast<std::atomic<std::ptrdiff_t>*>(sum) += bytes;
        return true;
    }

    [[nodiscard]] RTCGeometry makeGeometry(const scene::Scene& scene,
                                           const std::vector<std::uint32_t>& triangles) const {
        RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        if (!triangles.empty()) {
            auto* positions = static_cast<Vec3*>(rtcSetNewGeometryBuffer(
                geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), scene.positions.size()));
            std::copy(scene.positions.begin(), scene.positions.end(), positions);
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

    const scene::Scene& scene_;
    std::atomic<std::ptrdiff_t> bytes_{0}; ///< outlives the device, which reports its last frees to it
    Device device_;
    std::unique_ptr<const WideTree> streams_;             ///< null: Embree alone finds the nearest hits, too
    SceneHandle opaque_, all_;                            ///< all_: only when Embree is asked for what is not Opaque
    std::array<std::vector<std::uint32_t>, 2> triangles_; ///< geometry and primitive → Scene::triangles
    Overlaps overlaps_;
    float originExtent_ = 0;
};

} // namespace

std::unique_ptr<Intersector> makeEmbree(const scene::Scene& scene, bool streams) {
    Device device(rtcNewDevice(nullptr));
    // A processor that Embree does not know: the answers are the same, only slower.
    if (!device) return makeBspTree(scene, {});
    return std::make_unique<Embree>(std::move(device), scene, streams && WideTree::supported());
}

} // namespace pie::intersect
