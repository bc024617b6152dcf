#pragma once
// Solid brushes by the cells of a coarse grid, so that whoever asks meets only those that are near.

#include "pie/brushes/brush.h"

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace pie::brushes {

class BrushGrid {
public:
    /// Of the brushes that `Brush::hides`; they must outlive it.
    explicit BrushGrid(std::span<const Brush> brushes);
    /// Numbers, rising, of brushes that may touch the bounds.
    [[nodiscard]] std::vector<std::uint32_t> near(const Bounds& bounds) const;
    /// Whether the point lies inside one of them that is structural.
    [[nodiscard]] bool solidAt(const glm::dvec3& point, const PlaneSet& planes) const;

private:
    std::span<const Brush> brushes_;
    std::unordered_map<std::int64_t, std::vector<std::uint32_t>> cells_;
    std::vector<std::uint32_t> large_; ///< in too many cells to be listed in each
};

} // namespace pie::brushes
