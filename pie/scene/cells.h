#pragma once
// Cells: groups of drawn triangles that are culled together. The leaves of the level's tree, joined upwards until a
// cell is worth a draw call; a refined triangle belongs where its centre lies, so a split floor is culled piece by
// piece (pi-engine 5.4).

#include "pie/scene/mesh.h"

#include <cstdint>
#include <vector>

namespace pie::scene {

struct CellNode {
    std::vector<std::uint32_t> triangles; ///< Mesh::triangles; only in nodes without children
    std::vector<CellNode> children;       ///< none or two or more
};

/// Covers every triangle of the mesh exactly once. Submodels (doors …) become children of the root of their own, so
/// that they can move. Without a tree in the level, triangles are halved at the median of the longest axis. `wanted`:
/// triangles per cell to aim at.
[[nodiscard]] CellNode makeCells(const Mesh& mesh, const level::Level& level, std::size_t wanted = 1500);

} // namespace pie::scene
