#pragma once
// Openings between the leaves of a tree (portals): the part of each cutting plane that is in its cell, cut on by all
// cells on either side of it.

#include "pie/brushes/solid_tree.h"

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace pie::brushes {

struct Portal {
    static constexpr std::int32_t worldEnd = std::numeric_limits<std::int32_t>::min();

    std::array<std::int32_t, 2> cells{}; ///< leaf -(cell + 1), or the world's end
    glm::dvec3 middle{0};
    std::uint32_t corners = 0;
    Bounds bounds;
};

/// `world`: what the tree's root covers. Their order depends on the tree only.
[[nodiscard]] std::vector<Portal> makePortals(std::span<const SolidTree::Node> nodes, const PlaneSet& planes,
                                              const Bounds& world);

} // namespace pie::brushes
