#pragma once
// A tree of boxes, eight to a node, for many rays without order: photons after a bounce, rays of a gather. Internal to
// this folder.
//
// A ray alone spends most of its time on wrong guesses of what comes next and on nodes that are not in the cache. So
// rays of one octant of directions travel together (dynamic ray streams: Barringer and Akenine-Möller 2014): a node is
// loaded once for all rays that reach it, and each is put on the lists of the children it meets, without a branch.
// Children are taken front to back for the octant, and fetched before they are needed. Triangles are met by the test of
// all intersectors (triangle_test.h), and of several at one distance the lowest number wins: answers are those of brute
// force to the bit, whatever the shape of the tree and the company of a ray.

#include "pie/intersect/intersector.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pie::intersect {

class WideTree {
public:
    /// Whether this processor has what `closest` needs (AVX2).
    [[nodiscard]] static bool supported();

    /// Of these triangles of the scene, whose corners it copies.
    WideTree(const scene::Scene& scene, std::span<const std::uint32_t> triangles);
    /// As Intersector::closest. Safe to call from several threads at once.
    void closest(std::span<const Ray> rays, std::span<Hit> hits) const;
    [[nodiscard]] std::size_t bytes() const;

    static constexpr std::uint32_t nothing = 0xffffffffU;
    static constexpr std::uint32_t leafBit = 0x80000000U;
    static constexpr std::size_t width = 8;     ///< children of a node
    static constexpr std::size_t leafWidth = 8; ///< triangles of a leaf

    struct alignas(64) Node {
        /// Of the children: lower x, y, z, upper x, y, z. Inside out where there is no child.
        std::array<std::array<float, width>, 6> bounds;
        std::array<std::uint32_t, width> child; ///< number of a node, or of a leaf and leafBit
        /// Children from front to back for directions that are positive along z and negative along x (1), y (2).
        std::array<std::array<std::uint8_t, width>, 4> order;
    };
    struct alignas(32) Leaf {
        std::array<std::array<std::array<float, leafWidth>, 3>, 3> corners; ///< [corner][axis]; not numbers where empty
        std::array<std::uint32_t, leafWidth> triangle;
    };

private:
    class Builder;
    struct Traversal;
    struct Scratch;

    void traceStream(std::span<const Ray> rays, std::span<Hit> hits, Scratch& scratch) const;

    std::vector<Node> nodes_;
    std::vector<Leaf> leaves_;
    std::uint32_t root_ = nothing;
    std::size_t depth_ = 0; ///< nodes above one another
};

} // namespace pie::intersect
