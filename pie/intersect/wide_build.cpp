// Building the tree: Embree's builder, and what it makes is copied into nodes depth first.
//
// Triangles are not split between boxes (Stich, Friedrich, Dietrich 2009): that saves a sixth of the visits and costs
// as much again by the room that copies take in the cache, and building takes five times as long.

#include "pie/intersect/wide_tree.h"

#include "pie/core/parallel.h"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

namespace pie::intersect {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr unsigned maxDepth = 64;

/// What the builder makes, in memory that it owns.
struct Made {
    std::uint32_t count = 0;
    bool leaf = false;
    std::array<Made*, WideTree::width> children;              ///< of a node
    std::array<RTCBounds, WideTree::width> bounds;            ///< of these
    std::array<std::uint32_t, WideTree::leafWidth> triangles; ///< of a leaf
};

Made* make(RTCThreadLocalAllocator allocator) { return new (rtcThreadLocalAlloc(allocator, sizeof(Made), 16)) Made(); }

void* createNode(RTCThreadLocalAllocator allocator, unsigned count, void* /*user*/) {
    Made* made = make(allocator);
    made->count = count;
    return made;
}
void setChildren(void* node, void** children, unsigned count, void* /*user*/) {
    for (unsigned i = 0; i < count; ++i) static_cast<Made*>(node)->children[i] = static_cast<Made*>(children[i]);
}
void setBounds(void* node, const RTCBounds** bounds, unsigned count, void* /*user*/) {
    for (unsigned i = 0; i < count; ++i) static_cast<Made*>(node)->bounds[i] = *bounds[i];
}
void* createLeaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, std::size_t count,
                 void* /*user*/) {
    Made* made = make(allocator);
    made->leaf = true;
    made->count = static_cast<std::uint32_t>(count);
    for (std::size_t i = 0; i < count; ++i) made->triangles[i] = primitives[i].primID;
    std::sort(made->triangles.begin(), made->triangles.begin() + count);
    return made;
}

} // namespace

/// Copies what the builder made, depth first.
class WideTree::Builder {
public:
    Builder(WideTree& tree, const scene::Scene& scene) : tree_(tree), scene_(scene) {
        // Triangles meet rays a little beyond their edges, by rounding.
        const Vec3 reach = glm::max(glm::abs(scene.bounds.lower), glm::abs(scene.bounds.upper));
        slack_ = 0x1p-19F * maxChannel(reach);
    }

    std::uint32_t copy(const Made& made, std::size_t depth) { // NOLINT(misc-no-recursion)
        tree_.depth_ = std::max(tree_.depth_, depth);
        return made.leaf ? copyLeaf(made) : copyNode(made, depth);
    }

private:
    std::uint32_t copyLeaf(const Made& made) {
        constexpr float nowhere = std::numeric_limits<float>::quiet_NaN();
        Leaf leaf;
        for (std::size_t i = 0; i < leafWidth; ++i) {
            const bool there = i < made.count;
            leaf.triangle[i] = there ? made.triangles[i] : nothing;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 corner = there ? scene_.corner(made.triangles[i], static_cast<int>(k)) : Vec3(nowhere);
                for (std::size_t axis = 0; axis < 3; ++axis) leaf.corners[k][axis][i] = corner[static_cast<int>(axis)];
            }
        }
        tree_.leaves_.push_back(leaf);
        return leafBit | static_cast<std::uint32_t>(tree_.leaves_.size() - 1);
    }

    std::uint32_t copyNode(const Made& made, std::size_t depth) { // NOLINT(misc-no-recursion)
        const std::size_t number = tree_.nodes_.size();
        tree_.nodes_.emplace_back();
        Node node;
        for (std::size_t i = 0; i < width; ++i) {
            const bool there = i < made.count;
            const RTCBounds b = there ? made.bounds[i] : RTCBounds{infinity,  infinity,  infinity,  0, //
                                                                   -infinity, -infinity, -infinity, 0};
            const std::array<float, 6> bounds{b.lower_x - slack_, b.lower_y - slack_, b.lower_z - slack_,
                                              b.upper_x + slack_, b.upper_y + slack_, b.upper_z + slack_};
            for (std::size_t side = 0; side < 6; ++side) node.bounds[side][i] = bounds[side];
            node.child[i] = there ? copy(*made.children[i], depth + 1) : nothing;
        }
        for (unsigned octant = 0; octant < node.order.size(); ++octant) node.order[octant] = order(node, octant);
        tree_.nodes_[number] = node;
        return static_cast<std::uint32_t>(number);
    }

    static std::array<std::uint8_t, width> order(const Node& node, unsigned octant) {
        std::array<float, width> along{};
        for (std::size_t i = 0; i < width; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const float twice = node.bounds[axis][i] + node.bounds[axis + 3][i];
                along[i] += (octant >> axis & 1U) != 0 ? -twice : twice;
            }
        std::array<std::uint8_t, width> result{};
        std::iota(result.begin(), result.end(), std::uint8_t{0});
        const auto end = std::stable_partition(result.begin(), result.end(),
                                               [&](std::uint8_t i) { return node.child[i] != nothing; });
        std::stable_sort(result.begin(), end, [&](std::uint8_t a, std::uint8_t b) { return along[a] < along[b]; });
        return result;
    }

    WideTree& tree_;
    const scene::Scene& scene_;
    float slack_ = 0;
};

WideTree::WideTree(const scene::Scene& scene, std::span<const std::uint32_t> triangles) {
    if (triangles.empty()) return;
    std::vector<RTCBuildPrimitive> primitives;
    primitives.reserve(triangles.size());
    for (const std::uint32_t t : triangles) {
        Box box;
        for (int k = 0; k < 3; ++k) box.extend(scene.corner(t, k));
        primitives.push_back({box.lower.x, box.lower.y, box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z, t});
    }
    const std::unique_ptr<RTCDeviceTy, void (*)(RTCDevice)> device(rtcNewDevice(nullptr), &rtcReleaseDevice);
    const std::unique_ptr<RTCBVHTy, void (*)(RTCBVH)> bvh(rtcNewBVH(device.get()), &rtcReleaseBVH);
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.byteSize = sizeof(arguments);
    arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = width;
    arguments.maxDepth = maxDepth;
    arguments.sahBlockSize = leafWidth;
    // Full leaves: every one that is not costs room in the cache.
    arguments.minLeafSize = leafWidth;
    arguments.maxLeafSize = leafWidth;
    arguments.traversalCost = 1.0F;
    arguments.intersectionCost = 1.0F;
    arguments.bvh = bvh.get();
    arguments.primitives = primitives.data();
    arguments.primitiveCount = primitives.size();
    arguments.primitiveArrayCapacity = primitives.capacity();
    arguments.createNode = &createNode;
    arguments.setNodeChildren = &setChildren;
    arguments.setNodeBounds = &setBounds;
    arguments.createLeaf = &createLeaf;
    const Made* made = nullptr;
    // Answers do not depend on the tree, so that any number of threads may build it.
    tbb::task_arena(static_cast<int>(threads())).execute([&] {
        made = static_cast<const Made*>(rtcBuildBVH(&arguments));
    });
    if (made == nullptr) return;
    root_ = Builder(*this, scene).copy(*made, 1);
    nodes_.shrink_to_fit();
    leaves_.shrink_to_fit();
}

std::size_t WideTree::bytes() const { return nodes_.capacity() * sizeof(Node) + leaves_.capacity() * sizeof(Leaf); }

} // namespace pie::intersect
