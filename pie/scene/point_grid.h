#pragma once
// Points in a hash grid, asked for what lies near a line segment. Not for use outside pie/scene.
//
// Grids of several cell sizes are made as the segments ask for them: a segment is walked in a grid whose cells are
// neither much shorter than itself nor, as far as the smallest grid allows, longer. So the work stays near-linear for
// levels whose walls are thousands of times longer than their details.

#include "pie/core/flat_index.h"
#include "pie/core/vec.h"

#include <glm/gtc/type_precision.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace pie::scene {

/// One cell size.
class PointGrid {
public:
    PointGrid(std::span<const Vec3> points, const Box& bounds, double cell);

    struct Entry {
        Vec3 position{0.0F};
        std::uint32_t point = 0;
    };
    /// Calls visit(entry) for every point within `radius` of the segment, and for some others; a point may come twice.
    template <class Visit> void nearSegment(const Vec3& a, const Vec3& b, double radius, const Visit& visit) const;

private:
    /// Cells along one axis; more would not fit the bits of a key, nor be of use.
    static constexpr double mostCells = 1 << 20;

    /// Of a coordinate in cells. Truncation rounds down, because cells count from below the lowest point.
    static std::int64_t cellOf(double coordinate) {
        return static_cast<std::int64_t>(std::clamp(coordinate, 0.0, mostCells + 4.0));
    }
    /// Cells of a block of 2 × 2 × 2 stand side by side, so that one look at memory serves most of a segment.
    [[nodiscard]] std::size_t bucket(std::int64_t x, std::int64_t y, std::int64_t z) const {
        const auto i = static_cast<std::uint64_t>(x);
        const auto j = static_cast<std::uint64_t>(y);
        const auto k = static_cast<std::uint64_t>(z);
        const std::uint64_t block = i >> 1U | (j >> 1U) << 21U | (k >> 1U) << 42U;
        return (mixBits(block) & blockMask_) << 3U | (i & 1U) | (j & 1U) << 1U | (k & 1U) << 2U;
    }

    friend class PointGrids;

    glm::dvec3 lower_{0.0};
    double perCell_ = 1;
    std::size_t blockMask_ = 0;
    std::vector<std::uint32_t> begin_; ///< bucket → entries_
    std::vector<Entry> entries_;
};

class PointGrids {
public:
    /// `typicalLength` of the segments to come. The points must outlive the grids.
    PointGrids(std::span<const Vec3> points, double typicalLength);

    /// The grid for segments of this length. Safe to call from several threads.
    [[nodiscard]] const PointGrid& forLength(double length) const {
        return length <= sizeStep * smallest_ ? *finest_ : coarser(length);
    }

private:
    static constexpr double sizeStep = 16;

    [[nodiscard]] const PointGrid& coarser(double length) const;

    std::span<const Vec3> points_;
    Box bounds_;
    double smallest_ = 1;
    std::unique_ptr<const PointGrid> finest_;
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<const PointGrid>> coarser_; ///< cell sizes smallest_ × 16^(i + 1)
};

template <class Visit>
void PointGrid::nearSegment(const Vec3& a, const Vec3& b, double radius, const Visit& visit) const {
    // In cells.
    const glm::dvec3 from = (glm::dvec3(a) - lower_) * perCell_;
    const glm::dvec3 along = (glm::dvec3(b) - glm::dvec3(a)) * perCell_;
    const double margin = radius * perCell_;
    const glm::dvec3 size = glm::abs(along);
    const int k = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    const double low = std::min(from[k], from[k] + along[k]) - margin;
    const double high = std::max(from[k], from[k] + along[k]) + margin;
    const double slopeI = size[k] > 0 ? along[i] / along[k] : 0;
    const double slopeJ = size[k] > 0 ? along[j] / along[k] : 0;
    const std::int64_t last = cellOf(high);
    for (std::int64_t slab = cellOf(low); slab <= last; ++slab) {
        // The part of the segment that can be near this slab, and the cells its box touches.
        const double begin = std::max(low + margin, static_cast<double>(slab) - margin) - from[k];
        const double end = std::min(high - margin, static_cast<double>(slab + 1) + margin) - from[k];
        const double i0 = from[i] + slopeI * begin;
        const double i1 = from[i] + slopeI * end;
        const double j0 = from[j] + slopeJ * begin;
        const double j1 = from[j] + slopeJ * end;
        const std::int64_t lastI = cellOf(std::max(i0, i1) + margin);
        const std::int64_t lastJ = cellOf(std::max(j0, j1) + margin);
        for (std::int64_t ci = cellOf(std::min(i0, i1) - margin); ci <= lastI; ++ci)
            for (std::int64_t cj = cellOf(std::min(j0, j1) - margin); cj <= lastJ; ++cj) {
                glm::i64vec3 cell;
                cell[k] = slab;
                cell[i] = ci;
                cell[j] = cj;
                const std::size_t at = bucket(cell.x, cell.y, cell.z);
                for (std::uint32_t e = begin_[at]; e < begin_[at + 1]; ++e) visit(entries_[e]);
            }
    }
}

} // namespace pie::scene
