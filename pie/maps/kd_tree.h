#pragma once
// The kd-tree: photons halved at the median along the longest axis until a leaf holds stopRecursionSize (pi-engine
// 5.3.2), searched without recursion and without allocating (5.3.3).
//
// `build`, then ask from as many threads as you like. Answers are those of ExactMap, bit for bit: halves are cut in the
// total order of (coordinate, number), distances are computed in one order of operations, and a half is skipped only
// where rounding, too, puts every photon of it past the reach of the search. Photons with a position that is not
// finite are kept but never found.
//
// Positions lie in tree order in blocks of stopRecursionSize per axis, so that a leaf is compared in a few vector
// instructions; the photon itself is only read when it is near enough.

#include "pie/maps/nearest.h"

#include <array>
#include <bit>
#include <cstddef>
#include <limits>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace pie::maps {

class KdTree {
public:
    static constexpr std::size_t stopRecursionSize = 16; ///< photons in a leaf at most

    /// At most 2^32 - 1 photons. The tree depends on the photons only, not on the number of threads.
    void build(std::vector<photons::Photon> photons);
    /// Hands the photons back and leaves the map empty, so that their memory can be filled again.
    [[nodiscard]] std::vector<photons::Photon> release();
    [[nodiscard]] std::span<const photons::Photon> photons() const { return photons_; }
    [[nodiscard]] const Box& bounds() const { return bounds_; } ///< of the photons with finite positions
    [[nodiscard]] std::size_t bytes() const;

    /// The k nearest photons within maxRadius (its surface included) for which accept(photon) is true. It is asked
    /// while searching, not afterwards: else k photons of a neighbouring surface would crowd out the right ones
    /// (pi-engine 3.5.1).
    template <class Accept>
    void nearest(const Vec3& point, std::size_t k, float maxRadius, Accept&& accept, NearestQueue& queue) const;

    /// visitor(photon, distanceSquared) for every photon within `radius` (its surface included), in an order that
    /// depends on the photons and the point only.
    template <class Visitor> void forEachWithin(const Vec3& point, float radius, Visitor&& visitor) const;

private:
    /// Along `axis`, the lower half ends at `low` and the upper begins at `high`.
    struct Node {
        float low = 0, high = 0;
        std::uint32_t axis = 0;
    };
    struct alignas(64) Leaf {
        std::array<std::array<float, stopRecursionSize>, 3> position; ///< by axis; unused slots are NaN: never near
        std::array<std::uint32_t, stopRecursionSize> number;          ///< in photons()
    };
    /// A half that waits to be searched, with the squared distances to it along the three axes.
    struct Waiting {
        std::uint32_t node;
        std::array<float, 3> offset;
    };
    /// 2^32 photons in leaves that are at least half full.
    static constexpr std::size_t maxDepth = 32;

    template <class Reach, class Candidate>
    void search(const Vec3& point, const Reach& reach, const Candidate& candidate) const;
    static std::uint32_t near(const Leaf& leaf, const Vec3& point, float reach,
                              std::array<float, stopRecursionSize>& distance);

    struct Item;
    struct Builder;

    std::vector<photons::Photon> photons_;
    std::vector<Node> nodes_; ///< node 1 is the root, children of i are 2i and 2i + 1; from firstLeaf_ on: leaves
    std::vector<Leaf> leaves_;
    std::uint32_t firstLeaf_ = 1;
    Box bounds_;
};

/// Bit i is set when slot i lies within reach; `distance` gets the squared distances.
inline std::uint32_t KdTree::near(const Leaf& leaf, const Vec3& point, float reach,
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

/// Walks the leaves that can hold something within reach(), nearest halves first. candidate(number, distanceSquared)
/// may shrink the reach.
template <class Reach, class Candidate>
void KdTree::search(const Vec3& point, const Reach& reach, const Candidate& candidate) const {
    if (leaves_.empty() || !isFinite(point)) return;
    std::array<Waiting, maxDepth> stack; // NOLINT(cppcoreguidelines-pro-type-member-init): filled as it grows
    std::size_t waiting = 0;
    alignas(64) std::array<float, stopRecursionSize> distance;
    Waiting here{1, {0.0F, 0.0F, 0.0F}};
    for (;;) {
        while (here.node < firstLeaf_) {
            const Node& node = nodes_[here.node];
            const float p = point[static_cast<int>(node.axis)];
            const float pastLow = p - node.low;
            const float beforeHigh = node.high - p;
            const bool lower = pastLow < beforeHigh;
            const float gap = lower ? beforeHigh : pastLow;
            Waiting far = here;
            far.node = 2 * here.node + (lower ? 1U : 0U);
            // Rounded like distanceSquared, which only grows with each coordinate: never more than the true answer.
            far.offset[node.axis] = gap * gap;
            here.node = 2 * here.node + (lower ? 0U : 1U);
            if ((far.offset[0] + far.offset[1]) + far.offset[2] <= reach()) stack[waiting++] = far;
        }
        const Leaf& leaf = leaves_[here.node - firstLeaf_];
        for (std::uint32_t mask = near(leaf, point, reach(), distance); mask != 0; mask &= mask - 1) {
            const auto slot = static_cast<std::size_t>(std::countr_zero(mask));
            if (distance[slot] <= reach()) candidate(leaf.number[slot], distance[slot]);
        }
        do {
            if (waiting == 0) return;
            here = stack[--waiting];
        } while (!((here.offset[0] + here.offset[1]) + here.offset[2] <= reach()));
    }
}

template <class Accept>
void KdTree::nearest(const Vec3& point, std::size_t k, float maxRadius, Accept&& accept, NearestQueue& queue) const {
    queue.reset(k, reachOfRadius(maxRadius));
    search(
        point, [&] { return queue.reach(); },
        [&](std::uint32_t number, float d) {
            if (accept(photons_[number])) queue.offer({d, number});
        });
}

template <class Visitor> void KdTree::forEachWithin(const Vec3& point, float radius, Visitor&& visitor) const {
    const float reach = reachOfRadius(radius);
    search(
        point, [&] { return reach; }, [&](std::uint32_t number, float d) { visitor(photons_[number], d); });
}

} // namespace pie::maps
