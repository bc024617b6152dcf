#include "pie/brushes/brush_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pie::brushes {
namespace {

constexpr double cellSide = 256;        // units
constexpr std::int64_t mostCells = 512; // a brush in more than these is large

std::int64_t numberOf(std::int64_t x, std::int64_t y, std::int64_t z) { return (z * 4099 + y) * 4099 + x; }

std::int64_t cellOf(const glm::dvec3& p) {
    const auto cell = [](double x) { return static_cast<std::int64_t>(std::floor(x / cellSide)); };
    return numberOf(cell(p.x), cell(p.y), cell(p.z));
}

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
                for (std::int64_t x = first[0]; x <= last[0]; ++x) visit(numberOf(x, y, z));
    }
};

} // namespace

BrushGrid::BrushGrid(std::span<const Brush> brushes, const std::function<bool(const Brush&)>& wanted)
    : brushes_(brushes) {
    for (std::uint32_t i = 0; i < brushes.size(); ++i) {
        if (!wanted(brushes[i])) continue;
        numbers_.push_back(i);
        const Cells cells(brushes[i].bounds);
        if (cells.count() > mostCells)
            large_.push_back(i);
        else
            cells.each([&](std::int64_t cell) { cells_[cell].push_back(i); });
    }
}

void BrushGrid::near(const Bounds& bounds, std::vector<std::uint32_t>& found) const {
    const auto before = static_cast<std::ptrdiff_t>(found.size());
    const auto add = [&](const std::vector<std::uint32_t>& numbers) {
        for (const std::uint32_t i : numbers)
            if (bounds.overlaps(brushes_[i].bounds, -onPlane)) found.push_back(i);
    };
    const Cells cells(bounds);
    if (cells.count() > mostCells) {
        add(numbers_);
        return;
    }
    add(large_);
    cells.each([&](std::int64_t cell) {
        if (const auto at = cells_.find(cell); at != cells_.end()) add(at->second);
    });
    std::sort(found.begin() + before, found.end());
    found.erase(std::unique(found.begin() + before, found.end()), found.end());
}

/// A point on the common face of two brushes is inside their union, though inside of neither.
bool BrushGrid::solidAt(const glm::dvec3& point, const PlaneSet& planes) const {
    const auto holds = [&](std::uint32_t number) {
        const Brush& brush = brushes_[number];
        Bounds bounds;
        bounds.extend(point);
        return bounds.overlaps(brush.bounds, -onPlane) &&
               std::all_of(brush.sides.begin(), brush.sides.end(),
                           [&](const Side& side) { return planes[side.plane].above(point) < onPlane; });
    };
    if (std::any_of(large_.begin(), large_.end(), holds)) return true;
    // Cells list what reaches up to a unit into them.
    const auto at = cells_.find(cellOf(point));
    return at != cells_.end() && std::any_of(at->second.begin(), at->second.end(), holds);
}

} // namespace pie::brushes
