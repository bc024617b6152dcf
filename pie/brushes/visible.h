#pragma once
// What remains of brush faces after everything that lies inside other solid brushes is cut away: the surface of their
// union. Where faces of two brushes coincide, the earlier brush keeps its own.

#include "pie/brushes/brush.h"

#include <span>
#include <vector>

namespace pie::brushes {

struct Fragment {
    std::size_t brush = 0, side = 0;
    Polygon polygon;
};

/// Pieces of the sides that `wanted` names, of all brushes of one entity, in the order of brushes and sides.
[[nodiscard]] std::vector<Fragment> visibleFragments(std::span<const Brush> brushes, const PlaneSet& planes,
                                                     const std::vector<std::uint8_t>& wantedShaders);

} // namespace pie::brushes
