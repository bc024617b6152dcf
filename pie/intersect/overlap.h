#pragma once
// Which triangles of a scene lie in one plane on top of each other: where a ray has no single nearest triangle. Not for
// use outside pie/intersect.

#include "pie/scene/scene.h"

#include <cstdint>
#include <vector>

namespace pie::intersect {

/// One value per triangle: 1 when another triangle covers part of it. Triangles that touch along an edge or at a corner
/// do not count. Near-linear in the number of triangles, unless most lie on top of each other.
[[nodiscard]] std::vector<std::uint8_t> findOverlaps(const scene::Scene& scene);

} // namespace pie::intersect
