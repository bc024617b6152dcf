#pragma once
// Cuts the world along structural faces until none is left in any cell. The world is first cut into blocks, so that
// cuts stay local and blocks can be built at the same time.

#include "pie/brushes/solid_tree.h"

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

namespace pie::brushes {

class TreeBuilder {
public:
    struct Face {
        std::uint32_t plane = 0; ///< the even one of the pair: both directions cut alike
        Polygon polygon;
        Bounds bounds;
    };

    explicit TreeBuilder(PlaneSet& planes) : planes_(planes) {}
    /// The first node is the root; without a node there is one leaf.
    void build(std::vector<Face> faces, const Bounds& world);

    std::vector<SolidTree::Node> nodes;
    std::size_t leafCount = 0;

private:
    /// A block's own tree, and the place in the blocks' tree where it hangs.
    struct Block {
        std::vector<Face> faces;
        Bounds bounds;
        std::int32_t parent = -1;
        std::size_t side = 0;
        std::vector<SolidTree::Node> nodes;
        std::int32_t leaves = 0;
    };

    using Numbers = std::vector<std::uint32_t>; ///< of faces

    void cutIntoBlocks(const Numbers& mine, const Bounds& bounds, std::int32_t parent, std::size_t side);
    std::int32_t cutBlock(Block& block, const Numbers& mine, const Bounds& bounds, int depth) const;
    [[nodiscard]] std::array<Numbers, 2> divide(std::vector<Face>& faces, const Numbers& mine,
                                                std::uint32_t plane) const;
    [[nodiscard]] std::uint32_t choose(const Block& block, const Numbers& mine, int depth) const;

    PlaneSet& planes_;
    std::vector<Face> faces_; ///< while blocks are cut
    std::deque<Block> blocks_;
};

} // namespace pie::brushes
