#pragma once
// Which triangles of a scene lie in one plane on top of each other: where a ray has no single nearest triangle. Not for
// use outside pie/intersect.

#include "pie/scene/scene.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace pie::intersect {

/// For each triangle the others that cover part of it. Triangles that touch along an edge or at a corner do not count.
struct Overlaps {
    static constexpr std::size_t most = 64; ///< kept for each triangle; heaps of more are no level

    std::vector<std::uint32_t> begin; ///< triangle → others; one more than there are triangles
    std::vector<std::uint32_t> others;

    [[nodiscard]] std::span<const std::uint32_t> of(std::size_t triangle) const {
        return std::span(others).subspan(begin[triangle], begin[triangle + 1] - begin[triangle]);
    }
};

/// Near-linear in the number of triangles, unless most lie on top of each other.
[[nodiscard]] Overlaps findOverlaps(const scene::Scene& scene);

} // namespace pie::intersect
