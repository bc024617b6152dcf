#pragma once
// Random points on surfaces, where none are given.

#include "pie/scene/scene.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace pieprobe {

/// POINTS.csv with `count` points, spread evenly over the area of all surfaces that can be lit, on their fronts.
/// Stratified by area, so that none of the surfaces is left out by chance; a header alone where there is no surface.
[[nodiscard]] std::string randomPoints(const pie::scene::Scene& scene, std::size_t count, std::uint64_t seed);

} // namespace pieprobe
