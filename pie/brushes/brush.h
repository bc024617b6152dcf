#pragma once
// Brushes as solids: the part of space behind all their planes, with one polygon per face.

#include "pie/brushes/map_text.h"
#include "pie/brushes/plane_set.h"
#include "pie/brushes/polygon.h"
#include "pie/brushes/texture_axes.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pie::brushes {

struct Side {
    std::uint32_t plane = 0;  ///< PlaneSet; faces out of the brush
    std::uint32_t shader = 0; ///< MapShaders
    std::size_t face = 0;     ///< BrushText::faces
    Polygon polygon;          ///< corners bit-equal to those of the neighbouring sides
};
struct Brush {
    std::vector<Side> sides; ///< those with an area
    Bounds bounds;
    const BrushText* text = nullptr;
    bool hides = false;      ///< solid and opaque: removes the faces of others that lie inside
    bool structural = false; ///< splits the level's tree
    bool origin = false;     ///< marks the centre of its entity
};

/// Cuts each face to the part that bounds the brush. Nothing, with a reason, if no volume is left. Only sides and
/// bounds are filled; Side::shader is left 0.
[[nodiscard]] std::optional<Brush> makeBrush(const BrushText& text, PlaneSet& planes, std::string& reason);

/// Volume between the sides.
[[nodiscard]] double volume(const Brush& brush, const PlaneSet& planes);

} // namespace pie::brushes
