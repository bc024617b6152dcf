// Rays in streams through the tree of boxes. Internal functions are compiled for AVX2, whatever the rest is compiled
// for; no fused multiply-add, so that answers are the same on every processor.

#include "pie/intersect/triangle_test.h"
#include "pie/intersect/wide_tree.h"

#include <bit>
#include <cmath>

#ifdef __x86_64__
#include <immintrin.h>

#define PIE_AVX2 __attribute__((target("avx2,bmi")))

namespace pie::intersect {
namespace {

/// Rays that travel together. More are better for the tree and worse for the cache, which holds what is known of them.
constexpr std::size_t streamSize = 8192;
constexpr float smallestDirection = 1e-18F; ///< its inverse squared is still finite
/// What rounding of distances to boxes and of the test of triangles may be, relative to the distance.
constexpr float slack = 1.0F + 0x1p-20F;

using Number = std::uint16_t; ///< of a ray in its stream

/// A ray under way, in one cache line.
struct alignas(64) Travelling {
    // What a node asks:
    std::array<float, 3> origin;
    float tMin;
    std::array<float, 3> inverse; ///< of the direction
    float limit;                  ///< nearest hit so far
    // What a leaf asks: the shear of PreparedRay.
    float shearX, shearY;
    std::array<std::uint8_t, 4> axis; ///< that x, y and z stand for
    std::uint32_t triangle;           ///< hit so far
    Vec3 direction;
    float tMax;
};

} // namespace

/// Memory that a thread keeps.
struct WideTree::Scratch {
    std::vector<Travelling> travelling;
    std::vector<Number> lists;
};

struct WideTree::Traversal {
    const WideTree& tree;
    std::span<Hit> hits;
    Travelling* travelling;

    /// Rays `ids` through what `child` is; `free` is memory for more lists.
    template <unsigned octant>
    PIE_AVX2 void visit(std::uint32_t child, const Number* ids, std::size_t count, Number* free) const;
    template <unsigned octant>
    PIE_AVX2 void visitNode(const Node& node, const Number* ids, std::size_t count, Number* free) const;
    PIE_AVX2 void visitLeaf(const Leaf& leaf, const Number* ids, std::size_t count) const;
    /// What will be visited soon: every ray of the stream saves the wait.
    void prefetch(std::uint32_t child) const;
    PIE_AVX2 void meet(const Leaf& leaf, std::size_t i, Number id, const Vec3& weights) const;
};

void WideTree::Traversal::prefetch(std::uint32_t child) const {
    constexpr std::size_t line = 64;
    const bool isLeaf = (child & leafBit) != 0;
    const auto* begin = isLeaf ? reinterpret_cast<const char*>(&tree.leaves_[child & ~leafBit])
                               : reinterpret_cast<const char*>(&tree.nodes_[child]);
    for (std::size_t at = 0; at < sizeof(Leaf); at += line) __builtin_prefetch(begin + at);
    if (!isLeaf) __builtin_prefetch(begin + sizeof(Node) - 1);
}

template <unsigned octant>
void WideTree::Traversal::visit(std::uint32_t child, const Number* ids, std::size_t count, Number* free) const {
    if ((child & leafBit) != 0)
        visitLeaf(tree.leaves_[child & ~leafBit], ids, count);
    else
        visitNode<octant>(tree.nodes_[child], ids, count, free);
}

template <unsigned octant>
void WideTree::Traversal::visitNode(const Node& node, const Number* ids, std::size_t count, Number* free) const {
    const auto plane = [&](std::size_t axis, bool far) __attribute__((target("avx2,bmi"), always_inline)) {
        return _mm256_load_ps(node.bounds[axis + (((octant >> axis & 1U) != 0) != far ? 3 : 0)].data());
    };
    const __m256 nearX = plane(0, false);
    const __m256 nearY = plane(1, false);
    const __m256 nearZ = plane(2, false);
    const __m256 farX = plane(0, true);
    const __m256 farY = plane(1, true);
    const __m256 farZ = plane(2, true);
    const __m256 more = _mm256_set1_ps(slack);
    std::array<Number*, width> end;
    for (std::size_t c = 0; c < width; ++c) end[c] = free + c * count;
    unsigned reached = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Number id = ids[i];
        const Travelling& ray = travelling[id];
        const __m256 x = _mm256_broadcast_ss(ray.origin.data());
        const __m256 y = _mm256_broadcast_ss(&ray.origin[1]);
        const __m256 z = _mm256_broadcast_ss(&ray.origin[2]);
        const __m256 perX = _mm256_broadcast_ss(ray.inverse.data());
        const __m256 perY = _mm256_broadcast_ss(&ray.inverse[1]);
        const __m256 perZ = _mm256_broadcast_ss(&ray.inverse[2]);
        const __m256 enter = _mm256_max_ps(
            _mm256_max_ps(_mm256_mul_ps(_mm256_sub_ps(nearX, x), perX), _mm256_mul_ps(_mm256_sub_ps(nearY, y), perY)),
            _mm256_max_ps(_mm256_mul_ps(_mm256_sub_ps(nearZ, z), perZ), _mm256_broadcast_ss(&ray.tMin)));
        const __m256 leave = _mm256_min_ps(
            _mm256_min_ps(_mm256_mul_ps(_mm256_sub_ps(farX, x), perX), _mm256_mul_ps(_mm256_sub_ps(farY, y), perY)),
            _mm256_min_ps(_mm256_mul_ps(_mm256_sub_ps(farZ, z), perZ), _mm256_broadcast_ss(&ray.limit)));
        const auto met =
            static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(enter, _mm256_mul_ps(leave, more), _CMP_LE_OQ)));
        reached |= met;
        // On every list, and counted on those of the children met.
        for (std::size_t c = 0; c < width; ++c) {
            *end[c] = id;
            end[c] += met >> c & 1U;
        }
    }
    constexpr bool backwards = (octant & 4U) != 0;
    const auto& order = node.order[backwards ? ~octant & 3U : octant & 3U];
    std::array<std::uint8_t, width> next;
    std::size_t children = 0;
    for (std::size_t k = 0; k < width; ++k) {
        const std::uint8_t c = order[backwards ? width - 1 - k : k];
        next[children] = c;
        children += reached >> c & 1U;
    }
    for (std::size_t k = 0; k < children; ++k) prefetch(node.child[next[k]]);
    for (std::size_t k = 0; k < children; ++k) {
        const std::size_t c = next[k];
        const Number* list = free + c * count;
        visit<octant>(node.child[c], list, static_cast<std::size_t>(end[c] - list), free + width * count);
    }
}

void WideTree::Traversal::visitLeaf(const Leaf& leaf, const Number* ids, std::size_t count) const {
    constexpr std::size_t corner = 3 * leafWidth;
    const float* corners = leaf.corners[0][0].data();
    const __m256 zero = _mm256_setzero_ps();
    const __m256 more = _mm256_set1_ps(slack);
    for (std::size_t i = 0; i < count; ++i) {
        const Number id = ids[i];
        const Travelling& ray = travelling[id];
        const __m256 originX = _mm256_broadcast_ss(&ray.origin[ray.axis[0]]);
        const __m256 originY = _mm256_broadcast_ss(&ray.origin[ray.axis[1]]);
        const __m256 originZ = _mm256_broadcast_ss(&ray.origin[ray.axis[2]]);
        const __m256 shearX = _mm256_broadcast_ss(&ray.shearX);
        const __m256 shearY = _mm256_broadcast_ss(&ray.shearY);
        const __m256 inverseZ = _mm256_broadcast_ss(&ray.inverse[ray.axis[2]]);
        const __m256 limit = _mm256_broadcast_ss(&ray.limit);
        const float* alongX = corners + leafWidth * ray.axis[0];
        const float* alongY = corners + leafWidth * ray.axis[1];
        const float* alongZ = corners + leafWidth * ray.axis[2];
        __m256 x[3];
        __m256 y[3];
        __m256 away[3];
        for (std::size_t k = 0; k < 3; ++k) {
            const __m256 z = _mm256_sub_ps(_mm256_load_ps(alongZ + k * corner), originZ);
            away[k] = _mm256_mul_ps(z, inverseZ);
            x[k] = _mm256_sub_ps(_mm256_sub_ps(_mm256_load_ps(alongX + k * corner), originX), _mm256_mul_ps(shearX, z));
            y[k] = _mm256_sub_ps(_mm256_sub_ps(_mm256_load_ps(alongY + k * corner), originY), _mm256_mul_ps(shearY, z));
        }
        const __m256 wa = _mm256_sub_ps(_mm256_mul_ps(x[2], y[1]), _mm256_mul_ps(y[2], x[1]));
        const __m256 wb = _mm256_sub_ps(_mm256_mul_ps(x[0], y[2]), _mm256_mul_ps(y[0], x[2]));
        const __m256 wc = _mm256_sub_ps(_mm256_mul_ps(x[1], y[0]), _mm256_mul_ps(y[1], x[0]));
        const __m256 least = _mm256_min_ps(_mm256_min_ps(wa, wb), wc);
        const __m256 greatest = _mm256_max_ps(_mm256_max_ps(wa, wb), wc);
        // No point of a triangle is nearer than its nearest corner, along the main axis.
        const __m256 nearest = _mm256_min_ps(_mm256_min_ps(away[0], away[1]), away[2]);
        auto met = static_cast<unsigned>(_mm256_movemask_ps(_mm256_and_ps(
            _mm256_or_ps(_mm256_cmp_ps(least, zero, _CMP_GE_OQ), _mm256_cmp_ps(greatest, zero, _CMP_LE_OQ)),
            _mm256_cmp_ps(nearest, _mm256_mul_ps(limit, more), _CMP_LE_OQ))));
        if (met == 0) continue;
        alignas(32) std::array<float, leafWidth> a;
        alignas(32) std::array<float, leafWidth> b;
        alignas(32) std::array<float, leafWidth> c;
        _mm256_store_ps(a.data(), wa);
        _mm256_store_ps(b.data(), wb);
        _mm256_store_ps(c.data(), wc);
        for (; met != 0; met &= met - 1) {
            const auto k = static_cast<std::size_t>(std::countr_zero(met));
            meet(leaf, k, id, {a[k], b[k], c[k]});
        }
    }
}

void WideTree::Traversal::meet(const Leaf& leaf, std::size_t i, Number id, const Vec3& weights) const {
    Travelling& ray = travelling[id];
    const auto corner = [&](std::size_t k) {
        return Vec3(leaf.corners[k][0][i], leaf.corners[k][1][i], leaf.corners[k][2][i]);
    };
    const std::array<Vec3, 3> corners{corner(0), corner(1), corner(2)};
    const Vec3 origin(ray.origin[0], ray.origin[1], ray.origin[2]);
    PreparedRay::Meeting meeting;
    const bool met =
        weights.x == 0.0F || weights.y == 0.0F || weights.z == 0.0F
            ? PreparedRay({origin, ray.tMin, ray.direction, ray.tMax}).meets(corners, ray.tMin, ray.tMax, meeting)
            : PreparedRay::meetsPlane(origin, ray.direction, corners, weights, meeting);
    if (!met || !(meeting.t >= ray.tMin && meeting.t < ray.tMax)) return;
    const std::uint32_t triangle = leaf.triangle[i];
    if (meeting.t > ray.limit || (meeting.t == ray.limit && triangle >= ray.triangle)) return;
    ray.limit = meeting.t;
    ray.triangle = triangle;
    hits[id] = {triangle, meeting.t, meeting.u, meeting.v};
}

namespace {

Travelling travel(const Ray& ray) {
    const PreparedRay prepared(ray);
    Travelling out;
    for (int k = 0; k < 3; ++k) {
        float along = ray.direction[k];
        if (std::abs(along) < smallestDirection) along = std::copysign(smallestDirection, along);
        out.origin[static_cast<std::size_t>(k)] = ray.origin[k];
        out.inverse[static_cast<std::size_t>(k)] = 1.0F / along;
        out.axis[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(prepared.axes()[static_cast<std::size_t>(k)]);
    }
    out.axis[3] = 0;
    out.tMin = std::max(ray.tMin, 0.0F);
    out.limit = out.tMax = ray.tMax;
    out.shearX = prepared.shearX();
    out.shearY = prepared.shearY();
    out.triangle = WideTree::nothing;
    out.direction = ray.direction;
    return out;
}

unsigned octantOf(const Travelling& ray) {
    const auto negative = [&](std::size_t k) { return std::bit_cast<std::uint32_t>(ray.inverse[k]) >> 31U; };
    return negative(0) | negative(1) << 1U | negative(2) << 2U;
}

} // namespace

bool WideTree::supported() { return __builtin_cpu_supports("avx2") != 0; }

void WideTree::closest(std::span<const Ray> rays, std::span<Hit> hits) const {
    static thread_local Scratch scratch;
    // Every level of the tree keeps eight lists for each ray at most, and the stream itself is one.
    const std::size_t most = std::min(rays.size(), streamSize);
    const std::size_t listed = most * (1 + width * depth_);
    if (scratch.lists.size() < listed) scratch.lists.resize(listed);
    if (scratch.travelling.size() < most) scratch.travelling.resize(most);
    for (std::size_t first = 0; first < rays.size(); first += streamSize) {
        const std::size_t count = std::min(streamSize, rays.size() - first);
        traceStream(rays.subspan(first, count), hits.subspan(first, count), scratch);
    }
}

void WideTree::traceStream(std::span<const Ray> rays, std::span<Hit> hits, Scratch& scratch) const {
    constexpr unsigned octants = 8;
    std::array<std::uint8_t, streamSize> octant;
    std::array<std::size_t, octants + 2> begin{}; // of each octant's rays, one place further on
    for (std::size_t i = 0; i < rays.size(); ++i) {
        hits[i] = Hit{};
        octant[i] = octants;
        if (!usable(rays[i])) continue;
        scratch.travelling[i] = travel(rays[i]);
        octant[i] = static_cast<std::uint8_t>(octantOf(scratch.travelling[i]));
        ++begin[octant[i] + 2U];
    }
    if (root_ == nothing) return;
    for (unsigned o = 0; o < octants; ++o) begin[o + 2U] += begin[o + 1U];
    Number* ids = scratch.lists.data();
    for (std::size_t i = 0; i < rays.size(); ++i)
        if (octant[i] != octants) ids[begin[octant[i] + 1U]++] = static_cast<Number>(i);
    const Traversal traversal{*this, hits, scratch.travelling.data()};
    Number* free = ids + rays.size();
    const auto send = [&]<unsigned... o>(std::integer_sequence<unsigned, o...>) {
        const auto one = [&]<unsigned which>() {
            if (begin[which + 1] > begin[which])
                traversal.visit<which>(root_, ids + begin[which], begin[which + 1] - begin[which], free);
        };
        (one.template operator()<o>(), ...);
    };
    send(std::make_integer_sequence<unsigned, octants>());
}

} // namespace pie::intersect

#else

namespace pie::intersect {

bool WideTree::supported() { return false; }
void WideTree::closest(std::span<const Ray> /*rays*/, std::span<Hit> hits) const {
    std::fill(hits.begin(), hits.end(), Hit{});
}

} // namespace pie::intersect

#endif
