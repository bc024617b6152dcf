#pragma once
// What remains of brush faces after everything that lies inside other solid brushes is cut away: the surface of their
// union. Where faces of two brushes coincide, the earlier brush keeps its own.

#include "pie/brushes/brush.h"

#include <cstdint>
#include <span>
#include <vector>

namespace pie::brushes {

struct Fragment {
    std::size_t brush = 0, side = 0;
    Polygon polygon;
};

/// Cuts a polygon in `plane` at the border of a convex solid: what is in it, and the rest added to `outside`. False,
/// and nothing changed, if nothing is inside. A face of the solid that looks the same way from the same place is inside
/// where `coincidentIsInside`; one that looks against it always is.
bool carve(const Polygon& polygon, std::uint32_t plane, const Brush& solid, const PlaneSet& planes,
           bool coincidentIsInside, Polygon& inside, std::vector<Polygon>& outside);

/// All sides of the structural brushes, without what lies in other structural ones; in the order of brushes and sides.
[[nodiscard]] std::vector<Fragment> structuralFragments(std::span<const Brush> brushes, const PlaneSet& planes);

/// The sides whose shader is wanted, without what lies in any brush that hides. `structural`: what structuralFragments
/// gave for the same brushes, so that it is not cut again.
[[nodiscard]] std::vector<Fragment> visibleFragments(std::span<const Brush> brushes, const PlaneSet& planes,
                                                     const std::vector<std::uint8_t>& wantedShaders,
                                                     std::vector<Fragment> structural);
/// Both in one.
[[nodiscard]] std::vector<Fragment> visibleFragments(std::span<const Brush> brushes, const PlaneSet& planes,
                                                     const std::vector<std::uint8_t>& wantedShaders);

} // namespace pie::brushes
