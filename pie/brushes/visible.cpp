#include "pie/brushes/visible.h"

#include "pie/brushes/brush_grid.h"
#include "pie/core/parallel.h"

#include <algorithm>
#include <iterator>

namespace pie::brushes {
namespace {

/// Cuts away what lies inside `other`; false if nothing was inside and the pieces are as before.
bool subtract(const Polygon& polygon, std::uint32_t plane, bool otherFirst, const Brush& other, const PlaneSet& planes,
              std::vector<Polygon>& outside) {
    Polygon inside = polygon;
    const std::size_t before = outside.size();
    for (const Side& side : other.sides) {
        // Faces that look the same way from the same place: one is enough.
        if (side.plane == plane && !otherFirst) break;
        if (side.plane == plane || side.plane == (plane ^ 1U)) continue;
        Split parts = split(inside, planes[side.plane]);
        if (hasArea(parts.front)) outside.push_back(std::move(parts.front));
        inside = std::move(parts.back);
        if (inside.empty()) break;
    }
    const bool sameFace = !otherFirst && std::any_of(other.sides.begin(), other.sides.end(),
                                                     [&](const Side& s) { return s.plane == plane; });
    if (sameFace || !hasArea(inside)) {
        outside.resize(before);
        outside.push_back(polygon);
        return false;
    }
    return true;
}

} // namespace

std::vector<Fragment> visibleFragments(std::span<const Brush> brushes, const PlaneSet& planes,
                                       const std::vector<std::uint8_t>& wantedShaders) {
    const BrushGrid grid(brushes);
    std::vector<std::vector<Fragment>> ofBrush(brushes.size());
    constexpr std::size_t grain = 16;
    parallelChunks(brushes.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            const Brush& brush = brushes[b];
            const std::vector<std::uint32_t> solid = grid.near(brush.bounds);
            for (std::size_t s = 0; s < brush.sides.size(); ++s) {
                const Side& side = brush.sides[s];
                if (wantedShaders[side.shader] == 0) continue;
                Bounds bounds;
                bounds.extend(side.polygon);
                std::vector<Polygon> pieces{side.polygon};
                bool cut = false;
                for (const std::uint32_t other : solid) {
                    if (other == b || pieces.empty()) continue;
                    // Touching brushes count: their common face is hidden in both.
                    if (!bounds.overlaps(brushes[other].bounds, -onPlane)) continue;
                    std::vector<Polygon> rest;
                    for (const Polygon& piece : pieces)
                        cut = subtract(piece, side.plane, other < b, brushes[other], planes, rest) || cut;
                    pieces = std::move(rest);
                }
                if (cut) joinConvex(pieces, planes[side.plane].normal);
                for (Polygon& piece : pieces) ofBrush[b].push_back({b, s, std::move(piece)});
            }
        }
    });
    std::vector<Fragment> all;
    for (auto& fragments : ofBrush) std::move(fragments.begin(), fragments.end(), std::back_inserter(all));
    return all;
}

} // namespace pie::brushes
