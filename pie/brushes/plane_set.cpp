#include "pie/brushes/plane_set.h"

#include <glm/geometric.hpp>

#include <cmath>

namespace pie::brushes {
namespace {

constexpr double normalTolerance = 1e-5;
constexpr double distanceTolerance = 0.01;
constexpr double bucket = 0.0625; // units; above the tolerance, and planes that editors set lie in the middle of one

std::int64_t bucketOf(double distance) { return static_cast<std::int64_t>(std::floor(distance / bucket + 0.5)); }

} // namespace

std::optional<Plane> planeThrough(const std::array<glm::dvec3, 3>& points) {
    const glm::dvec3 a = points[0] - points[1];
    const glm::dvec3 b = points[2] - points[1];
    const glm::dvec3 normal = glm::cross(a, b);
    const double length = glm::length(normal);
    // An area of nothing against the lengths: no direction can be told.
    if (!(length > 1e-9 * glm::length(a) * glm::length(b)) || !(length > 0)) return std::nullopt;
    Plane plane{normal / length, 0};
    for (int axis = 0; axis < 3; ++axis)
        // Both others small, not this one near 1: that would flatten slopes of half a percent.
        if (std::abs(plane.normal[(axis + 1) % 3]) < normalTolerance &&
            std::abs(plane.normal[(axis + 2) % 3]) < normalTolerance) {
            const double sign = plane.normal[axis] > 0 ? 1 : -1;
            plane.normal = glm::dvec3(0);
            plane.normal[axis] = sign;
            break;
        }
    plane.distance = glm::dot(plane.normal, points[1]);
    const double whole = std::round(plane.distance);
    constexpr double nearInteger = 1e-3;
    if (std::abs(plane.distance - whole) < nearInteger) plane.distance = whole;
    return plane;
}

std::uint32_t PlaneSet::find(const Plane& plane) {
    const std::int64_t last = bucketOf(plane.distance + distanceTolerance);
    for (std::int64_t near = bucketOf(plane.distance - distanceTolerance); near <= last; ++near)
        for (std::uint32_t at = buckets_.first(near); at != ChainedIndex::none; at = buckets_.next(at)) {
            const Plane& known = planes_[at];
            if (std::abs(known.distance - plane.distance) < distanceTolerance &&
                std::abs(known.normal.x - plane.normal.x) < normalTolerance &&
                std::abs(known.normal.y - plane.normal.y) < normalTolerance &&
                std::abs(known.normal.z - plane.normal.z) < normalTolerance)
                return at;
        }
    const auto number = static_cast<std::uint32_t>(planes_.size());
    planes_.push_back(plane);
    planes_.push_back({-plane.normal, -plane.distance});
    buckets_.add(bucketOf(planes_[number].distance));
    buckets_.add(bucketOf(planes_[number + 1].distance));
    return number;
}

} // namespace pie::brushes
