#pragma once
// Points in a hash grid, asked for what lies near a line segment. Not for use outside pie/scene.
//
// Grids of several cell sizes are made as the segments ask for them: a segment is walked in a grid whose cells are
// neither much shorter than itself nor, as far as the smallest grid allows, longer. So the work stays near-linear for
// levels whose walls are thousands of times longer than their details.

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
    [[nodiscard]] std::int64_t cellOf(double coordinate) const;
    [[nodiscard]] std::size_t bucket(std::int64_t x, std::int64_t y, std::int64_t z) const;

    glm::dvec3 lower_{0.0};
    double cell_ = 1, perCell_ = 1;
    std::size_t mask_ = 0;
    std::vector<std::uint32_t> begin_; ///< bucket → entries_
    std::vector<Entry> entries_;
};

class PointGrids {
public:
    /// `typicalLength` of the segments to come. The points must outlive the grids.
    PointGrids(std::span<const Vec3> points, double typicalLength);

    /// The grid for segments of this length. Safe to call from several threads.
    [[nodiscard]] const PointGrid& forLength(double length) const;

private:
    std::span<const Vec3> points_;
    Box bounds_;
    double smallest_ = 1;
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<const PointGrid>> grids_; ///< cell sizes smallest_ × 16^i
};

template <class Visit>
void PointGrid::nearSegment(const Vec3& a, const Vec3& b, double radius, const Visit& visit) const {
    const glm::dvec3 from = glm::dvec3(a) - lower_;
    const glm::dvec3 along = glm::dvec3(b) - glm::dvec3(a);
    const glm::dvec3 size = glm::abs(along);
    const int k = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    const double low = std::min(from[k], from[k] + along[k]) - radius;
    const double high = std::max(from[k], from[k] + along[k]) + radius;
    const std::int64_t last = cellOf(high);
    for (std::int64_t slab = cellOf(low); slab <= last; ++slab) {
        // The part of the segment that can be near this slab, and the cells its box touches.
        double t0 = 0;
        double t1 = 1;
        if (size[k] > 0) {
            t0 = (static_cast<double>(slab) * cell_ - radius - from[k]) / along[k];
            t1 = (static_cast<double>(slab + 1) * cell_ + radius - from[k]) / along[k];
            if (t0 > t1) std::swap(t0, t1);
            t0 = std::clamp(t0, 0.0, 1.0);
            t1 = std::clamp(t1, 0.0, 1.0);
        }
        const double i0 = from[i] + t0 * along[i];
        const double i1 = from[i] + t1 * along[i];
        const double j0 = from[j] + t0 * along[j];
        const double j1 = from[j] + t1 * along[j];
        const std::int64_t lastI = cellOf(std::max(i0, i1) + radius);
        const std::int64_t lastJ = cellOf(std::max(j0, j1) + radius);
        for (std::int64_t ci = cellOf(std::min(i0, i1) - radius); ci <= lastI; ++ci)
            for (std::int64_t cj = cellOf(std::min(j0, j1) - radius); cj <= lastJ; ++cj) {
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
