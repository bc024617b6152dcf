#include "pie/scene/point_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pie::scene {

PointGrid::PointGrid(std::span<const Vec3> points, const Box& bounds, double cell) : perCell_(1.0 / cell) {
    // Levels are drawn on a lattice of round numbers. Off that lattice, edges and vertices lie within cells, not
    // between them.
    const glm::dvec3 offLattice(2.371, 2.417, 2.293);
    if (!bounds.empty()) lower_ = glm::dvec3(bounds.lower) - offLattice * cell;
    blockMask_ = std::bit_ceil(points.size() / 4 + 1) - 1;
    begin_.assign(8 * (blockMask_ + 1) + 1, 0);
    std::vector<std::uint32_t> bucketOf(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) {
        const glm::dvec3 at = (glm::dvec3(points[p]) - lower_) * perCell_;
        bucketOf[p] = static_cast<std::uint32_t>(bucket(cellOf(at.x), cellOf(at.y), cellOf(at.z)));
        ++begin_[bucketOf[p] + 1];
    }
    for (std::size_t b = 1; b < begin_.size(); ++b) begin_[b] += begin_[b - 1];
    entries_.resize(points.size());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t p = 0; p < points.size(); ++p)
        entries_[next[bucketOf[p]]++] = {points[p], static_cast<std::uint32_t>(p)};
}

PointGrids::PointGrids(std::span<const Vec3> points, double typicalLength) : points_(points) {
    for (const Vec3& p : points) bounds_.extend(p);
    const glm::dvec3 size = bounds_.empty() ? glm::dvec3(0.0) : glm::dvec3(bounds_.upper) - glm::dvec3(bounds_.lower);
    const double extent = std::max({size.x, size.y, size.z});
    smallest_ = std::max(typicalLength, extent / (PointGrid::mostCells - 4));
    if (!(smallest_ > 0) || !std::isfinite(smallest_)) smallest_ = 1;
    finest_ = std::make_unique<PointGrid>(points_, bounds_, smallest_);
}

const PointGrid& PointGrids::coarser(double length) const {
    std::size_t level = 0;
    double cell = smallest_ * sizeStep;
    for (; cell * sizeStep < length; cell *= sizeStep) ++level;
    const std::lock_guard lock(mutex_);
    if (coarser_.size() <= level) coarser_.resize(level + 1);
    if (!coarser_[level]) coarser_[level] = std::make_unique<PointGrid>(points_, bounds_, cell);
    return *coarser_[level];
}

} // namespace pie::scene
