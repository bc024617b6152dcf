#pragma once
// Questions about one triangle that must have the same answer in the scene, the mesh and the receivers.

#include "pie/core/vec.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>

namespace pie::scene {

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

} // namespace pie::scene
