#pragma once
// Triangles sorted into a binary space partition: the level's own planes first, and where one of its leaves holds many
// triangles (models and patches never split a level's tree), or where there is no tree, planes along the axes. Not for
// use outside pie/intersect.

#include "pie/level/level.h"
#include "pie/scene/scene.h"

#include <array>
#include <cstdint>
#include <vector>

namespace pie::intersect {

struct BspNodes {
    struct Node {
        Vec3 normal{0.0F};
        float distance = 0;
        std::array<std::int32_t, 2> children{}; ///< front, back; negative: leaf -(child + 1)
    };
    struct Leaf {
        std::uint32_t begin = 0, opaqueEnd = 0, end = 0; ///< in `triangles`, Opaque ones first
    };
    /// Longest way from the root to a leaf, so that a ray can do with a stack of this size.
    static constexpr int deepest = 192;

    std::vector<Node> nodes;
    std::vector<Leaf> leaves;
    std::vector<std::uint32_t> triangles;
    std::int32_t root = -1;
    /// Largest coordinate of the scene: what distances to planes are rounded by.
    float extent = 0;
};

/// Every triangle is in each leaf that it reaches into. What lies within 1e-6 × extent of a plane counts as on it and
/// may be kept on one side only: a ray has to look at both sides that near to a plane.
[[nodiscard]] BspNodes buildBsp(const scene::Scene& scene, const level::Tree& tree);

} // namespace pie::intersect
