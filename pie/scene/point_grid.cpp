#include "pie/scene/point_grid.h"

#include "pie/scene/flat_index.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pie::scene {
namespace {

/// Cells along one axis; more would not fit the bits of a key, nor be of use.
constexpr double mostCells = 1 << 20;
constexpr double sizeStep = 16;

} // namespace

PointGrid::PointGrid(std::span<const Vec3> points, const Box& bounds, double cell) : cell_(cell) {
    if (!bounds.empty()) lower_ = glm::dvec3(bounds.lower);
    perCell_ = 1.0 / cell_;
    mask_ = std::bit_ceil(points.size() + 1) - 1;
    begin_.assign(mask_ + 2, 0);
    std::vector<std::uint32_t> bucketOf(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) {
        const glm::dvec3 at = glm::dvec3(points[p]) - lower_;
        bucketOf[p] = static_cast<std::uint32_t>(bucket(cellOf(at.x), cellOf(at.y), cellOf(at.z)));
        ++begin_[bucketOf[p] + 1];
    }
    for (std::size_t b = 1; b < begin_.size(); ++b) begin_[b] += begin_[b - 1];
    entries_.resize(points.size());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t p = 0; p < points.size(); ++p)
        entries_[next[bucketOf[p]]++] = {points[p], static_cast<std::uint32_t>(p)};
}

std::int64_t PointGrid::cellOf(double coordinate) const {
    return static_cast<std::int64_t>(std::floor(std::clamp(coordinate * perCell_, -4.0, mostCells + 4.0)));
}

std::size_t PointGrid::bucket(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const std::uint64_t key = static_cast<std::uint64_t>(x + 8) | static_cast<std::uint64_t>(y + 8) << 21U |
                              static_cast<std::uint64_t>(z + 8) << 42U;
    return mixBits(key) & mask_;
}

PointGrids::PointGrids(std::span<const Vec3> points, double typicalLength) : points_(points) {
    for (const Vec3& p : points) bounds_.extend(p);
    const glm::dvec3 size = bounds_.empty() ? glm::dvec3(0.0) : glm::dvec3(bounds_.upper) - glm::dvec3(bounds_.lower);
    const double extent = std::max({size.x, size.y, size.z});
    smallest_ = std::max(typicalLength, extent / mostCells);
    if (!(smallest_ > 0) || !std::isfinite(smallest_)) smallest_ = 1;
}

const PointGrid& PointGrids::forLength(double length) const {
    std::size_t level = 0;
    double cell = smallest_;
    for (; cell * sizeStep < length; cell *= sizeStep) ++level;
    const std::lock_guard lock(mutex_);
    if (grids_.size() <= level) grids_.resize(level + 1);
    if (!grids_[level]) grids_[level] = std::make_unique<PointGrid>(points_, bounds_, cell);
    return *grids_[level];
}

} // namespace pie::scene
