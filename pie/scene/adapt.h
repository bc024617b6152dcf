#pragma once
// Refinement that follows a value on the surfaces, such as light: edges are split where the value in their middle is
// not the mean of the values at their ends, most of all first.
//
// The mesh is first split by length alone down to `coarseEdge`: a change that both ends and the middle of an edge miss
// is not seen, so nothing finer than about half of that is sure to be found. Then every edge is probed, in rounds. What
// is off by more than `tolerance` is split, largest difference times length first, until nothing is, the vertices are
// used up, or the edges are as short as `smallestEdge`.
//
// An edge is split only where it is the longest of its triangles; longer ones are split before it (longest-edge
// bisection, Rivara 1984), so triangles do not get thinner and thinner. As in refine(), a split goes through all
// triangles of the edge, and T-junctions are closed before and after. The result depends on mesh, options and values.

#include "pie/scene/mesh.h"

#include <functional>
#include <span>

namespace pie::scene {

/// A place of the mesh where the value is asked for.
struct SurfacePoint {
    Vec3 position{0.0F};
    Vec3 normal{0.0F, 0.0F, 1.0F}; ///< unit
    Vec3 inset{0.0F};              ///< up to one unit into a triangle that has the point
    std::uint32_t surface = 0;     ///< Level::surfaces
};

/// Puts the value at points[i] in values[i]. The same points give the same values, whatever else is asked.
using ValueAt = std::function<void(std::span<const SurfacePoint> points, std::span<float> values)>;

struct AdaptOptions {
    float coarseEdge = 256;                                            ///< units
    float smallestEdge = 8;                                            ///< units; no edge is split into shorter ones
    float tolerance = 8;                                               ///< in values
    std::size_t maxVertices = std::numeric_limits<std::size_t>::max(); ///< Mesh::vertices; those that closing makes
                                                                       ///< come on top
    std::size_t maxTriangles = 4'000'000;                              ///< hard bound on memory
    float junctionTolerance = 0.01F;                                   ///< RefineOptions::tolerance
    std::stop_token stop;
};
struct AdaptStatistics {
    std::size_t splits = 0, tJunctions = 0;
    std::size_t probes = 0; ///< points whose value was asked for
};

AdaptStatistics adapt(Mesh& mesh, const AdaptOptions& options, const ValueAt& valueAt);

} // namespace pie::scene
