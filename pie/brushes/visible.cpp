#include "pie/brushes/visible.h"

#include "pie/brushes/brush_grid.h"
#include "pie/core/parallel.h"

#include <algorithm>
#include <functional>
#include <iterator>

namespace pie::brushes {
namespace {

constexpr std::size_t grain = 16; // brushes a chunk

bool isStructural(const Brush& brush) { return brush.structural; }
bool isDetail(const Brush& brush) { return brush.hides && !brush.structural; }

/// Cuts one side after the other; keeps its lists, so that a side costs no memory.
class Cutter {
public:
    Cutter(std::span<const Brush> brushes, const PlaneSet& planes) : brushes_(brushes), planes_(planes) {}

    /// Adds what remains of `polygon`, which is the side or a part of it, outside the brushes in `solid`.
    void cut(std::size_t brush, std::size_t side, Polygon polygon, std::span<const std::uint32_t> solid,
             std::vector<Fragment>& result) {
        const std::uint32_t plane = brushes_[brush].sides[side].plane;
        Bounds bounds;
        bounds.extend(polygon);
        pieces_.clear();
        pieces_.push_back(std::move(polygon));
        bool changed = false;
        for (const std::uint32_t other : solid) {
            if (other == brush) continue;
            // Touching brushes count: their common face is hidden in both.
            if (!bounds.overlaps(brushes_[other].bounds, -onPlane)) continue;
            rest_.clear();
            // Faces that look the same way from the same place: one is enough.
            for (Polygon& piece : pieces_)
                if (carve(piece, plane, brushes_[other], planes_, other < brush, inside_, rest_))
                    changed = true;
                else
                    rest_.push_back(std::move(piece));
            pieces_.swap(rest_);
            if (pieces_.empty()) return;
        }
        if (changed) joinConvex(pieces_, planes_[plane].normal);
        for (Polygon& piece : pieces_) result.push_back({brush, side, std::move(piece)});
    }

private:
    std::span<const Brush> brushes_;
    const PlaneSet& planes_;
    std::vector<Polygon> pieces_, rest_;
    Polygon inside_;
};

/// Calls work(brush, cutter, its fragments) for all brushes, and joins the fragments in their order.
std::vector<Fragment> collect(std::span<const Brush> brushes, const PlaneSet& planes,
                              const std::function<void(std::size_t, Cutter&, std::vector<Fragment>&)>& work) {
    std::vector<std::vector<Fragment>> chunks((brushes.size() + grain - 1) / grain);
    parallelChunks(brushes.size(), grain, [&](std::size_t begin, std::size_t end) {
        Cutter cutter(brushes, planes);
        for (std::size_t b = begin; b < end; ++b) work(b, cutter, chunks[begin / grain]);
    });
    std::size_t count = 0;
    for (const auto& fragments : chunks) count += fragments.size();
    std::vector<Fragment> all;
    all.reserve(count);
    for (auto& fragments : chunks) std::move(fragments.begin(), fragments.end(), std::back_inserter(all));
    return all;
}

} // namespace

bool carve(const Polygon& polygon, std::uint32_t plane, const Brush& solid, const PlaneSet& planes,
           bool coincidentIsInside, Polygon& inside, std::vector<Polygon>& outside) {
    const auto coplanar = [&](const Side& side) { return (side.plane & ~1U) == (plane & ~1U); };
    // Most are outside one of the faces: nothing is cut before that is known.
    for (const Side& side : solid.sides) {
        if (side.plane == plane && !coincidentIsInside) return false;
        if (coplanar(side)) continue;
        const Place place = placeOf(polygon, planes[side.plane]);
        if (place == Place::Front || place == Place::On) return false;
    }
    inside = polygon;
    const std::size_t before = outside.size();
    Polygon front;
    Polygon back;
    for (const Side& side : solid.sides) {
        if (coplanar(side)) continue;
        const Place place = split(inside, planes[side.plane], front, back);
        if (place == Place::Both) {
            if (hasArea(front)) outside.push_back(std::move(front));
            inside = std::move(back);
        } else if (place != Place::Back) {
            inside.clear();
            break;
        }
    }
    if (hasArea(inside)) return true;
    outside.erase(outside.begin() + static_cast<std::ptrdiff_t>(before), outside.end());
    return false;
}

std::vector<Fragment> structuralFragments(std::span<const Brush> brushes, const PlaneSet& planes) {
    const BrushGrid grid(brushes, isStructural);
    return collect(brushes, planes, [&](std::size_t b, Cutter& cutter, std::vector<Fragment>& result) {
        if (!brushes[b].structural) return;
        std::vector<std::uint32_t> solid;
        grid.near(brushes[b].bounds, solid);
        for (std::size_t s = 0; s < brushes[b].sides.size(); ++s)
            cutter.cut(b, s, brushes[b].sides[s].polygon, solid, result);
    });
}

std::vector<Fragment> visibleFragments(std::span<const Brush> brushes, const PlaneSet& planes,
                                       const std::vector<std::uint8_t>& wantedShaders,
                                       std::vector<Fragment> structural) {
    const BrushGrid solids(brushes, isStructural);
    const BrushGrid details(brushes, isDetail);
    const auto wanted = [&](std::size_t b, std::size_t s) { return wantedShaders[brushes[b].sides[s].shader] != 0; };
    if (details.empty() && std::all_of(brushes.begin(), brushes.end(), isStructural)) {
        std::erase_if(structural, [&](const Fragment& f) { return !wanted(f.brush, f.side); });
        return structural;
    }
    return collect(brushes, planes, [&](std::size_t b, Cutter& cutter, std::vector<Fragment>& result) {
        std::vector<std::uint32_t> solid;
        details.near(brushes[b].bounds, solid);
        if (brushes[b].structural) {
            const auto [first, last] =
                std::equal_range(structural.begin(), structural.end(), Fragment{b, 0, {}},
                                 [](const Fragment& x, const Fragment& y) { return x.brush < y.brush; });
            for (auto at = first; at != last; ++at)
                if (wanted(b, at->side)) cutter.cut(b, at->side, std::move(at->polygon), solid, result);
            return;
        }
        solids.near(brushes[b].bounds, solid);
        std::sort(solid.begin(), solid.end());
        for (std::size_t s = 0; s < brushes[b].sides.size(); ++s)
            if (wanted(b, s)) cutter.cut(b, s, brushes[b].sides[s].polygon, solid, result);
    });
}

std::vector<Fragment> visibleFragments(std::span<const Brush> brushes, const PlaneSet& planes,
                                       const std::vector<std::uint8_t>& wantedShaders) {
    return visibleFragments(brushes, planes, wantedShaders, structuralFragments(brushes, planes));
}

} // namespace pie::brushes
