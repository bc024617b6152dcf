#pragma once
// Curved surfaces: grids of biquadratic Bézier patches (3×3 control points each) become triangles.
//
// Neighbouring patches must meet in bit-equal edges. So an edge is cut by what its own control points say (never by the
// interior), with a subdivision that depends on those points alone and is the same read from either end, and each
// edge's vertices are evaluated in one canonical direction.

#include "pie/core/vec.h"

#include <cstdint>
#include <span>
#include <vector>

namespace pie::level {

struct PatchVertex {
    Vec3 position, normal;
    Vec2 texture, lightmap;
    Vec4 colour;
};

struct PatchMesh {
    std::vector<PatchVertex> vertices;
    std::vector<std::uint32_t> indices; ///< triangles; counter-clockwise seen from the front
};

/// `controls`: width × height points, row by row, both odd and >= 3. `tolerance`: largest distance in units between
/// curve and chord. At most `maxSegments` pieces per Bézier segment.
[[nodiscard]] PatchMesh tessellate(std::span<const PatchVertex> controls, int width, int height, float tolerance = 1.0F,
                                   int maxSegments = 32);

} // namespace pie::level
