#pragma once
// The mesh that is drawn, and its refinement by splitting the longest edge (pi-engine 5.4.1, fig 5.9).
//
// Splitting an edge splits every triangle that has it, on whatever surface, so neighbours stay matched and no
// T-junction arises. T-junctions that the level brings along, or that arise where two edges overlap in part, are closed
// before and after.

#include "pie/core/vec.h"
#include "pie/level/level.h"

#include <array>
#include <cstdint>
#include <limits>
#include <stop_token>
#include <vector>

namespace pie::scene {

struct MeshTriangle {
    std::array<std::uint32_t, 3> vertices{}; ///< Mesh::vertices, counter-clockwise from the front
    std::uint32_t surface = 0;               ///< Level::surfaces: shader, lightmap, model, fog
};

struct Mesh {
    std::vector<level::Vertex> vertices; ///< one per corner attribute set; triangles of a surface share them
    std::vector<MeshTriangle> triangles;
};

/// The drawn surfaces of a level, not refined. Skies with a sky box are not among them: those are drawn as a box.
[[nodiscard]] Mesh makeMesh(const level::Level& level);

struct RefineOptions {
    std::size_t maxSplits =
        std::numeric_limits<std::size_t>::max();            ///< triangles split, the paper's mesh_refinement; 0: none
    float maxEdge = std::numeric_limits<float>::infinity(); ///< go on until no edge is longer than this, in units;
                                                            ///< edges of a closed T-junction: than this and tolerance
    float tolerance = 0.01F;              ///< vertices so near to an edge, in units, end it; 0: T-junctions stay
    std::size_t maxTriangles = 4'000'000; ///< hard bound on memory
    std::stop_token stop;                 ///< asked for now and then; the mesh is then refined as far as it came
};
struct RefineStatistics {
    std::size_t splits = 0, tJunctions = 0;
    float longestEdge = 0;
};

/// Closes T-junctions, and splits until maxSplits or maxEdge is reached, whichever comes first. Positions of midpoints
/// are computed in one canonical order, so that they are bit-equal on all surfaces that share the edge. Deterministic.
RefineStatistics refine(Mesh& mesh, const RefineOptions& options);
/// T-junctions alone. Returns how many were closed.
std::size_t closeTJunctions(Mesh& mesh, float tolerance = 0.01F);

} // namespace pie::scene
