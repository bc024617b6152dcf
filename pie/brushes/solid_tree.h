#pragma once
// The level's binary space partition: planes of structural solid surfaces cut the world until every leaf is either all
// solid or all open. Openings between leaves (portals) tell which leaves an entity can reach; what cannot be reached is
// the void around the level, and faces towards it are left out.

#include "pie/brushes/brush_grid.h"
#include "pie/brushes/visible.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace pie::brushes {

/// A way from an entity to the void around the level.
struct Leak {
    std::size_t point = 0;        ///< of those that were given
    std::vector<glm::dvec3> path; ///< from there through openings to the world's end
};

class SolidTree {
public:
    struct Node {
        std::uint32_t plane = 0;
        std::array<std::int32_t, 2> children{}; ///< >= 0 a node, < 0 the leaf -(child + 1); front first
        Bounds bounds;
    };
    struct Leaf {
        bool solid = true, reached = false;
        Bounds bounds;
        std::uint32_t firstDoor = 0, doorCount = 0; ///< its openings to others
    };

    /// `surfaces`: structuralFragments of the brushes. `world` is what the tree has to cover.
    SolidTree(std::span<const Fragment> surfaces, std::span<const Brush> brushes, PlaneSet& planes,
              const Bounds& world);

    /// Marks what can be reached from the points; those in solid leaves say nothing. Where the world's end is reached,
    /// or no point stands in the open, everything counts as reached.
    [[nodiscard]] std::optional<Leak> flood(std::span<const glm::dvec3> points);
    [[nodiscard]] std::size_t leafAt(const glm::dvec3& point) const;
    /// Leaves that the polygon touches from in front of its plane, each once.
    void leavesInFront(const Polygon& polygon, std::uint32_t plane, std::vector<std::uint32_t>& leaves) const;
    /// Leaves that the bounds touch.
    void leavesNear(const Bounds& bounds, std::vector<std::uint32_t>& leaves) const;

    [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
    [[nodiscard]] const std::vector<Leaf>& leaves() const { return leaves_; }

private:
    /// A way out of a leaf.
    struct Door {
        std::int32_t to = 0; ///< leaf -(to + 1), or Portal::worldEnd
        glm::dvec3 middle{0};
    };
    void openDoors(const PlaneSet& planes, const BrushGrid& structural, const Bounds& world);

    const PlaneSet& planes_;
    std::vector<Node> nodes_;
    std::vector<Leaf> leaves_;
    std::vector<Door> doors_; ///< leaf after leaf
};

} // namespace pie::brushes
