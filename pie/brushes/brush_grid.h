#pragma once
// Brushes by the cells of a coarse grid, so that whoever asks meets only those that are near.

#include "pie/brushes/brush.h"

#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>
#include <vector>

namespace pie::brushes {

class BrushGrid {
public:
    /// Of the brushes that are wanted; all must outlive it.
    BrushGrid(std::span<const Brush> brushes, const std::function<bool(const Brush&)>& wanted);
    [[nodiscard]] bool empty() const { return numbers_.empty(); }
    /// Adds the numbers of brushes whose bounds touch these, rising, to `found`.
    void near(const Bounds& bounds, std::vector<std::uint32_t>& found) const;
    /// Whether the point lies inside one of them.
    [[nodiscard]] bool solidAt(const glm::dvec3& point, const PlaneSet& planes) const;

private:
    std::span<const Brush> brushes_;
    std::vector<std::uint32_t> numbers_; ///< all that are in the grid
    std::unordered_map<std::int64_t, std::vector<std::uint32_t>> cells_;
    std::vector<std::uint32_t> large_; ///< in too many cells to be listed in each
};

} // namespace pie::brushes
