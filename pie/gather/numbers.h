#pragma once
// Small numbers that several estimators need. Internal to this folder.

#include "pie/core/vec.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <limits>
#include <span>

namespace pie::gather {

inline constexpr int mostCrossings = 64; ///< filters a ray may pass

[[nodiscard]] inline double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }
using pie::meanChannel; // which the next would hide
[[nodiscard]] inline double meanChannel(const glm::dvec3& c) { return (c.x + c.y + c.z) / 3; }

/// As a float in [0, largest]; what is not a number counts as 0.
[[nodiscard]] inline float finite(double value) {
    return value > 0 ? static_cast<float>(std::min(value, double{std::numeric_limits<float>::max()})) : 0.0F;
}
[[nodiscard]] inline Rgb finite(const glm::dvec3& value) { return {finite(value.x), finite(value.y), finite(value.z)}; }

/// Variance of a sum, estimated from what its parts differ by; 0 of fewer than two.
[[nodiscard]] inline double variance(std::span<const double> parts) {
    if (parts.size() < 2) return 0;
    const auto count = static_cast<double>(parts.size());
    double mean = 0;
    for (const double part : parts) mean += part / count;
    double squares = 0;
    for (const double part : parts) squares += (part - mean) * (part - mean);
    return squares * count / (count - 1);
}

} // namespace pie::gather
