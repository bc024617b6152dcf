#include "pie/brushes/brush_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pie::brushes {
namespace {

constexpr double cellSide = 256;        // units
constexpr std::int64_t mostCells = 512; // a brush in more than these is large

/// The cells that bounds touch.
struct Cells {
    std::array<std::int64_t, 3> first{}, last{};

    explicit Cells(const Bounds& bounds) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int a = static_cast<int>(axis);
            first.at(axis) = static_cast<std::int64_t>(std::floor((bounds.lower[a] - 1) / cellSide));
            last.at(axis) = static_cast<std::int64_t>(std::floor((bounds.upper[a] + 1) / cellSide));
        }
    }
    [[nodiscard]] std::int64_t count() const {
        return (last[0] - first[0] + 1) * (last[1] - first[1] + 1) * (last[2] - first[2] + 1);
    }
    template <class Visit> void each(const Visit& visit) const {
        for (std::int64_t z = first[2]; z <= last[2]; ++z)
            for (std::int64_t y = first[1]; y <= last[1]; ++y)
                for (std::int64_t x = first[0]; x <= last[0]; ++x) visit((z * 4099 + y) * 4099 + x);
    }
};

} // namespace

BrushGrid::BrushGrid(std::span<const Brush> brushes) : brushes_(brushes) {
    for (std::uint32_t i = 0; i < brushes.size(); ++i) {
        if (!brushes[i].hides) continue;
        const Cells cells(brushes[i].bounds);
        if (cells.count() > mostCells)
            large_.push_back(i);
        else
            cells.each([&](std::int64_t cell) { cells_[cell].push_back(i); });
    }
}

std::vector<std::uint32_t> BrushGrid::near(const Bounds& bounds) const {
    std::vector<std::uint32_t> found = large_;
    const Cells cells(bounds);
    if (cells.count() > mostCells) {
        for (std::uint32_t i = 0; i < brushes_.size(); ++i)
            if (brushes_[i].hides && bounds.overlaps(brushes_[i].bounds, -1)) found.push_back(i);
    } else {
        cells.each([&](std::int64_t cell) {
            if (const auto at = cells_.find(cell); at != cells_.end())
                found.insert(found.end(), at->second.begin(), at->second.end());
        });
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

/// A point on the common face of two brushes is inside their union, though inside of neither.
bool BrushGrid::solidAt(const glm::dvec3& point, const PlaneSet& planes) const {
    Bounds bounds;
    bounds.extend(point);
    const auto holds = [&](std::uint32_t number) {
        const Brush& brush = brushes_[number];
        return brush.structural && std::all_of(brush.sides.begin(), brush.sides.end(), [&](const Side& side) {
                   return planes[side.plane].above(point) < onPlane;
               });
    };
    const std::vector<std::uint32_t> candidates = near(bounds);
    return std::any_of(candidates.begin(), candidates.end(), holds);
}

} // namespace pie::brushes
