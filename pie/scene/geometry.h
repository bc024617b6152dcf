#pragma once
// Questions about one triangle that must have the same answer in the scene, the mesh and the receivers.

#include "pie/core/vec.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace pie::scene {

/// Of the distance to the far side of its triangle, how much a point where light is asked for may be moved inwards; and
/// how far at all, in units.
inline constexpr float insetShare = 0.1F;
inline constexpr float insetUnits = 1.0F;

/// The corner after corner `i` of a triangle.
[[nodiscard]] constexpr std::uint32_t following(std::uint32_t i) { return i == 2 ? 0 : i + 1; }

[[nodiscard]] inline bool finite(const Vec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// (b − a) × (c − a): twice the area long. In double, so that levels from 1e-3 to 1e7 units wide neither underflow nor
/// overflow.
[[nodiscard]] inline glm::dvec3 areaVector(const Vec3& a, const Vec3& b, const Vec3& c) {
    return glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
}

/// True for triangles that are lines, points or not finite: less than 1e-9 times as high as they are long is less than
/// the positions themselves can say.
[[nodiscard]] inline bool withoutArea(const Vec3& a, const Vec3& b, const Vec3& c) {
    if (!finite(a) || !finite(b) || !finite(c)) return true;
    const auto squaredLength = [](const Vec3& p, const Vec3& q) {
        const glm::dvec3 d = glm::dvec3(p) - glm::dvec3(q);
        return glm::dot(d, d);
    };
    const double longest = std::max({squaredLength(a, b), squaredLength(b, c), squaredLength(c, a)});
    const double twiceArea = glm::length(areaVector(a, b, c));
    return !(twiceArea > 1e-9 * longest);
}

/// How near to an edge a vertex must be to lie on it, and how far from its ends: short edges must not lose their whole
/// length.
[[nodiscard]] inline double reachOf(double length, double tolerance) { return std::min(tolerance, 0.01 * length); }

/// True for triangles with a corner in the interior of the opposite edge, as far as `tolerance` (and a hundredth of the
/// edge) can tell.
[[nodiscard]] inline bool flat(const std::array<Vec3, 3>& corners, double tolerance) {
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec3 along = glm::dvec3(corners[(i + 1) % 3]) - glm::dvec3(corners[i]);
        const glm::dvec3 d = glm::dvec3(corners[(i + 2) % 3]) - glm::dvec3(corners[i]);
        const double length = glm::length(along);
        const double reach = reachOf(length, tolerance);
        const double at = glm::dot(d, along);
        if (!(at > reach * length && at < (length - reach) * length)) continue;
        const glm::dvec3 off = d - along * (at / (length * length));
        if (glm::dot(off, off) < reach * reach) return true;
    }
    return false;
}

} // namespace pie::scene
