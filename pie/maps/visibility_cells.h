#pragma once
// Space cut into cells along a level's tree, and which of them can be seen from where. The leaves of a level are far
// too many for a map each, so they are joined: the subtree with the most leaves is halved at its plane until there are
// as many cells as wanted.
//
// Cell 0 is what no cluster lies in: rock, and the outside. It is seen from everywhere, and everything is seen from it,
// so that what lies on the wrong side of a plane by rounding is not lost. A tree without clusters, without visibility
// or with damage has this cell alone.

#include "pie/core/vec.h"
#include "pie/level/level.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace pie::maps {

class VisibilityCells {
public:
    static constexpr std::size_t most = 64; ///< with cell 0
    using Set = std::uint64_t;              ///< bit c: cell c

    /// Keeps a reference to `tree`. `wanted`: cells beside cell 0, at most 63.
    explicit VisibilityCells(const level::Tree& tree, std::size_t wanted = most - 1);

    [[nodiscard]] std::size_t size() const { return size_; } ///< with cell 0
    [[nodiscard]] std::uint32_t cellAt(const Vec3& point) const;
    /// What may be seen from a point: by the cluster it lies in, which is finer than its cell.
    [[nodiscard]] Set seenFrom(const Vec3& point) const;

    struct Piece {
        std::uint32_t cell = 0;
        std::vector<glm::dvec3> corners;
    };
    /// Cuts a convex polygon into the pieces whose points, moved by `offset`, lie in one cell each.
    [[nodiscard]] std::vector<Piece> cut(std::vector<glm::dvec3> corners, const glm::dvec3& offset) const;

    [[nodiscard]] std::size_t bytes() const;

private:
    struct Node {
        level::Plane plane;
        std::array<std::int32_t, 2> children{}; ///< child < 0: cell -(child + 1); front child first
    };
    void makeCells(std::size_t wanted);
    void lookAround(const std::vector<Set>& cellsOfCluster);

    const level::Tree& tree_;
    std::vector<Node> nodes_; ///< the root first; empty: cell 0 is everywhere
    std::vector<Set> seen_;   ///< by cluster
    std::size_t size_ = 1;
};

} // namespace pie::maps
