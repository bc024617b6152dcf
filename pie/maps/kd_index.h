#pragma once
// The tree over positions that photon maps search: numbers of photons, halved at the median along the longest axis
// until a leaf holds stopRecursionSize (pi-engine 5.3.2), searched without recursion and without allocating (5.3.3). It
// knows no photons, so several can stand over parts of one list (SplitTree). For maps; ask a map rather than this.
//
// `build`, then search from as many threads as you like. Halves are cut in the total order of (coordinate, number),
// distances are computed in one order of operations, and a part is skipped only where rounding, too, puts every photon
// of it past the reach of the search.
//
// Three things make it fast. A node stands for two halvings: it holds the tight bounding boxes of its four quarters
// side by side, so that all four distances take a few vector instructions; tight boxes rather than cutting planes,
// because photons lie on surfaces and most of a half is empty. And positions lie in tree order in blocks of
// stopRecursionSize per axis; the photon itself is only read when it is near enough. And where only a slice of the ball
// can be accepted (Slab), boxes and positions outside it are skipped before anyone is asked.

#include "pie/maps/nearest.h"

#include <array>
#include <bit>
#include <cstddef>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace pie::maps {

class KdIndex {
public:
    static constexpr std::size_t stopRecursionSize = 16; ///< photons in a leaf at most
    static constexpr std::size_t width = 4;              ///< children of a node

    struct Item {
        std::array<float, 3> position; ///< finite
        std::uint32_t number;
    };
    /// Boxes by axis and place. Those of places that are not used are NaN: never near.
    struct alignas(32) Boxes {
        std::array<std::array<float, width>, 3> lower, upper;
    };

    /// At most 2^32 - 1 items, which are put into the order of the tree. It depends on them only, not on the number of
    /// threads.
    void build(std::span<Item> items);
    void clear();
    [[nodiscard]] bool empty() const { return leaves_.empty(); }
    [[nodiscard]] const Box& bounds() const { return bounds_; }
    [[nodiscard]] std::size_t bytes() const;

    /// Walks the leaves that can hold something within reach(), a squared distance, nearest parts first, and calls
    /// candidate(number, distanceSquared), which may shrink the reach. Null for no slab.
    template <class Reach, class Candidate>
    Visits search(const Vec3& point, const Slab* slab, const Reach& reach, const Candidate& candidate) const;

    /// Bit i is set when box i comes within reach; `distance` gets the squared distances.
    static std::uint32_t near(const Boxes& boxes, const Vec3& point, float reach, std::array<float, width>& distance);
    /// Bit i is set when box i may hold something in the slab.
    static std::uint32_t within(const Boxes& boxes, const Vec3& point, const Slab& slab);

private:
    struct Node {
        Boxes boxes; ///< of the children
        std::uint32_t
            firstChild; ///< nodes first, then leaves: from nodes_.size() on, leaf number child − nodes_.size()
    };
    struct alignas(64) Leaf {
        std::array<std::array<float, stopRecursionSize>, 3> position; ///< by axis; unused slots are NaN: never near
        std::array<std::uint32_t, stopRecursionSize> number;
    };
    /// A part of the tree that waits to be searched.
    struct Waiting {
        float distance;
        std::uint32_t part;
    };
    /// 2^32 photons in leaves that are at least half full make 29 halvings, so 15 nodes on the way down; each leaves
    /// three quarters waiting and one is under way.
    static constexpr std::size_t mostWaiting = 3 * 15 + 1;

    static std::uint32_t near(const Leaf& leaf, const Vec3& point, float reach,
                              std::array<float, stopRecursionSize>& distance);
    static std::uint32_t within(const Leaf& leaf, const Vec3& point, const Slab& slab);
    /// Rounding of a height over the plane, relative to the coordinates it is made of: a slab is never cut too thin.
    static constexpr float slack = 1e-6F;

    struct Builder;

    std::vector<Node> nodes_; ///< level by level, the root first; empty when one leaf holds all
    std::vector<Leaf> leaves_;
    Box bounds_;
};

/// Bit i is set when slot i lies within reach; `distance` gets the squared distances.
inline std::uint32_t KdIndex::near(const Leaf& leaf, const Vec3& point, float reach,
                                   std::array<float, stopRecursionSize>& distance) {
    std::uint32_t mask = 0;
#if defined(__SSE2__)
    const __m128 px = _mm_set1_ps(point.x);
    const __m128 py = _mm_set1_ps(point.y);
    const __m128 pz = _mm_set1_ps(point.z);
    const __m128 limit = _mm_set1_ps(reach);
    for (unsigned i = 0; i < stopRecursionSize; i += 4) {
        const __m128 x = _mm_sub_ps(_mm_load_ps(&leaf.position[0][i]), px);
        const __m128 y = _mm_sub_ps(_mm_load_ps(&leaf.position[1][i]), py);
        const __m128 z = _mm_sub_ps(_mm_load_ps(&leaf.position[2][i]), pz);
        const __m128 d = _mm_add_ps(_mm_add_ps(_mm_mul_ps(x, x), _mm_mul_ps(y, y)), _mm_mul_ps(z, z));
        _mm_store_ps(&distance[i], d);
        mask |= static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmple_ps(d, limit))) << i;
    }
#else
    for (unsigned i = 0; i < stopRecursionSize; ++i) {
        distance[i] = distanceSquared({leaf.position[0][i], leaf.position[1][i], leaf.position[2][i]}, point);
        mask |= static_cast<std::uint32_t>(distance[i] <= reach) << i;
    }
#endif
    return mask;
}

/// The same for the boxes of a node's children. Rounded like distanceSquared, which only grows with each coordinate:
/// never more than the distance of any photon in the box.
inline std::uint32_t KdIndex::near(const Boxes& boxes, const Vec3& point, float reach,
                                   std::array<float, width>& distance) {
#if defined(__SSE2__)
    __m128 sum = _mm_setzero_ps();
    for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        const __m128 p = _mm_set1_ps(point[axis]);
        const __m128 below = _mm_sub_ps(_mm_load_ps(boxes.lower[i].data()), p);
        const __m128 above = _mm_sub_ps(p, _mm_load_ps(boxes.upper[i].data()));
        // The second operand wins when one is NaN.
        const __m128 gap = _mm_max_ps(_mm_setzero_ps(), _mm_max_ps(below, above));
        sum = _mm_add_ps(sum, _mm_mul_ps(gap, gap));
    }
    _mm_store_ps(distance.data(), sum);
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmple_ps(sum, _mm_set1_ps(reach))));
#else
    std::uint32_t mask = 0;
    for (std::size_t child = 0; child < width; ++child) {
        float sum = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<std::size_t>(axis);
            const float below = boxes.lower[i][child] - point[axis];
            const float above = point[axis] - boxes.upper[i][child];
            const float outside = below > above ? below : above;
            const float gap = 0.0F > outside ? 0.0F : outside; // NaN stays NaN
            sum += gap * gap;
        }
        distance[child] = sum;
        mask |= static_cast<std::uint32_t>(sum <= reach) << child;
    }
    return mask;
#endif
}

/// Bit i is set when slot i may lie in the slab.
inline std::uint32_t KdIndex::within(const Leaf& leaf, const Vec3& point, const Slab& slab) {
    std::uint32_t mask = 0;
#if defined(__SSE2__)
    const __m128 sign = _mm_set1_ps(-0.0F);
    const __m128 limit = _mm_set1_ps(slab.halfThickness);
    for (unsigned i = 0; i < stopRecursionSize; i += 4) {
        __m128 height = _mm_setzero_ps();
        __m128 size = _mm_setzero_ps();
        for (int axis = 0; axis < 3; ++axis) {
            const __m128 p = _mm_load_ps(&leaf.position[static_cast<std::size_t>(axis)][i]);
            const __m128 part = _mm_mul_ps(_mm_sub_ps(p, _mm_set1_ps(point[axis])), _mm_set1_ps(slab.normal[axis]));
            height = _mm_add_ps(height, part);
            size = _mm_add_ps(size, _mm_andnot_ps(sign, part));
        }
        const __m128 least = _mm_sub_ps(_mm_andnot_ps(sign, height), _mm_mul_ps(size, _mm_set1_ps(slack)));
        mask |= static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmpngt_ps(least, limit))) << i;
    }
#else
    for (unsigned i = 0; i < stopRecursionSize; ++i) {
        float height = 0;
        float size = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float part = (leaf.position[static_cast<std::size_t>(axis)][i] - point[axis]) * slab.normal[axis];
            height += part;
            size += part < 0.0F ? -part : part;
        }
        mask |= static_cast<std::uint32_t>(!((height < 0.0F ? -height : height) - size * slack > slab.halfThickness))
                << i;
    }
#endif
    return mask;
}

/// The same for the boxes of a node's children.
inline std::uint32_t KdIndex::within(const Boxes& boxes, const Vec3& point, const Slab& slab) {
#if defined(__SSE2__)
    const __m128 sign = _mm_set1_ps(-0.0F);
    __m128 lowest = _mm_setzero_ps();
    __m128 highest = _mm_setzero_ps();
    __m128 size = _mm_setzero_ps();
    for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        const __m128 p = _mm_set1_ps(point[axis]);
        const __m128 n = _mm_set1_ps(slab.normal[axis]);
        const __m128 a = _mm_mul_ps(_mm_sub_ps(_mm_load_ps(boxes.lower[i].data()), p), n);
        const __m128 b = _mm_mul_ps(_mm_sub_ps(_mm_load_ps(boxes.upper[i].data()), p), n);
        lowest = _mm_add_ps(lowest, _mm_min_ps(a, b));
        highest = _mm_add_ps(highest, _mm_max_ps(a, b));
        size = _mm_add_ps(size, _mm_max_ps(_mm_andnot_ps(sign, a), _mm_andnot_ps(sign, b)));
    }
    const __m128 margin = _mm_add_ps(_mm_set1_ps(slab.halfThickness), _mm_mul_ps(size, _mm_set1_ps(slack)));
    const __m128 above = _mm_cmpngt_ps(lowest, margin);
    const __m128 below = _mm_cmpngt_ps(_mm_sub_ps(_mm_setzero_ps(), highest), margin);
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_and_ps(above, below)));
#else
    std::uint32_t mask = 0;
    for (std::size_t child = 0; child < width; ++child) {
        float lowest = 0;
        float highest = 0;
        float size = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<std::size_t>(axis);
            const float a = (boxes.lower[i][child] - point[axis]) * slab.normal[axis];
            const float b = (boxes.upper[i][child] - point[axis]) * slab.normal[axis];
            lowest += a < b ? a : b;
            highest += a < b ? b : a;
            size += (a < 0.0F ? -a : a) + (b < 0.0F ? -b : b);
        }
        const float margin = slab.halfThickness + size * slack;
        mask |= static_cast<std::uint32_t>(!(lowest > margin) && !(-highest > margin)) << child;
    }
    return mask;
#endif
}

template <class Reach, class Candidate>
Visits KdIndex::search(const Vec3& point, const Slab* slab, const Reach& reach, const Candidate& candidate) const {
    Visits visits;
    if (leaves_.empty() || !isFinite(point) || !(reach() >= 0.0F)) return visits;
    std::array<Waiting, mostWaiting> stack; // NOLINT(cppcoreguidelines-pro-type-member-init): filled as it grows
    std::size_t waiting = 0;
    alignas(64) std::array<float, stopRecursionSize> distance;
    alignas(16) std::array<float, width> gap;
    const auto nodeCount = static_cast<std::uint32_t>(nodes_.size());
    std::uint32_t part = 0;
    for (;;) {
        if (part < nodeCount) {
            const Node& node = nodes_[part];
            const std::size_t below = waiting;
            ++visits.nodes;
            std::uint32_t mask = near(node.boxes, point, reach(), gap);
            if (slab != nullptr && mask != 0) mask &= within(node.boxes, point, *slab);
            for (; mask != 0; mask &= mask - 1) {
                const auto child = static_cast<std::size_t>(std::countr_zero(mask));
                // Nearest on top; of equals the lower number.
                std::size_t at = waiting++;
                for (; at > below && stack[at - 1].distance <= gap[child]; --at) stack[at] = stack[at - 1];
                stack[at] = {gap[child], node.firstChild + static_cast<std::uint32_t>(child)};
            }
        } else {
            const Leaf& leaf = leaves_[part - nodeCount];
            ++visits.leaves;
            std::uint32_t mask = near(leaf, point, reach(), distance);
            if (slab != nullptr && mask != 0) mask &= within(leaf, point, *slab);
            for (; mask != 0; mask &= mask - 1) {
                const auto slot = static_cast<std::size_t>(std::countr_zero(mask));
                if (!(distance[slot] <= reach())) continue;
                ++visits.photons;
                candidate(leaf.number[slot], distance[slot]);
            }
        }
        do {
            if (waiting == 0) return visits;
            part = stack[--waiting].part;
        } while (!(stack[waiting].distance <= reach()));
    }
}

} // namespace pie::maps
