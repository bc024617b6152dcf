#pragma once
// Embree as its manual shows it: the default scene of the default build, rays one by one or in packets of 16, and of
// hits only whether there was one. What tracers are compared with.

#include "pie/intersect/intersector.h"
#include "pie/scene/scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace piebench {

/// Safe from any number of threads at once.
class BareEmbree {
public:
    explicit BareEmbree(const pie::scene::Scene& scene)
        : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), scene.positions.size()));
        for (std::size_t i = 0; i < scene.positions.size(); ++i)
            for (int c = 0; c < 3; ++c) vertices[3 * i + static_cast<std::size_t>(c)] = scene.positions[i][c];
        auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), scene.triangles.size()));
        for (std::size_t i = 0; i < scene.triangles.size(); ++i)
            std::copy(scene.triangles[i].vertices.begin(), scene.triangles[i].vertices.end(), indices + 3 * i);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    BareEmbree(const BareEmbree&) = delete;
    BareEmbree& operator=(const BareEmbree&) = delete;
    ~BareEmbree() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }

    [[nodiscard]] std::size_t single(std::span<const pie::intersect::Ray> rays) const {
        std::size_t hits = 0;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (const pie::intersect::Ray& ray : rays) {
            RTCRayHit query;
            query.ray = {ray.origin.x,
                         ray.origin.y,
                         ray.origin.z,
                         ray.tMin,
                         ray.direction.x,
                         ray.direction.y,
                         ray.direction.z,
                         0.0F,
                         ray.tMax,
                         0xffffffffU,
                         0,
                         0};
            query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene_, &context, &query);
            hits += query.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
        }
        return hits;
    }
    [[nodiscard]] std::size_t packets(std::span<const pie::intersect::Ray> rays) const {
        std::size_t hits = 0;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (std::size_t first = 0; first < rays.size(); first += 16) {
            const std::size_t count = std::min<std::size_t>(16, rays.size() - first);
            alignas(64) int valid[16]{};
            RTCRayHit16 query{};
            for (std::size_t i = 0; i < count; ++i) {
                const pie::intersect::Ray& ray = rays[first + i];
                valid[i] = -1;
                query.ray.org_x[i] = ray.origin.x;
                query.ray.org_y[i] = ray.origin.y;
                query.ray.org_z[i] = ray.origin.z;
                query.ray.dir_x[i] = ray.direction.x;
                query.ray.dir_y[i] = ray.direction.y;
                query.ray.dir_z[i] = ray.direction.z;
                query.ray.tnear[i] = ray.tMin;
                query.ray.tfar[i] = ray.tMax;
                query.ray.mask[i] = 0xffffffffU;
                query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
                query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
            }
            rtcIntersect16(valid, scene_, &context, &query);
            for (std::size_t i = 0; i < count; ++i) hits += query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
        }
        return hits;
    }

private:
    RTCDevice device_;
    RTCScene scene_;
};

} // namespace piebench
