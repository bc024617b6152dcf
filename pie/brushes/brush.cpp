#include "pie/brushes/brush.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace pie::brushes {
namespace {

/// Finer than between brushes: thin brushes and nearly parallel planes keep their shape.
constexpr double fine = 1e-5;
/// Corners this near to each other are one; such a distance is far below what editors write.
constexpr double sameCorner = 2e-3;
constexpr double nearInteger = 1e-3;

/// Corners of one brush: those of neighbouring faces are found by different cuts and differ in the last bits.
class Corners {
public:
    glm::dvec3 unify(glm::dvec3 p) {
        for (int axis = 0; axis < 3; ++axis)
            if (const double whole = std::round(p[axis]); std::abs(p[axis] - whole) < nearInteger) p[axis] = whole;
        for (const glm::dvec3& known : known_)
            if (std::abs(known.x - p.x) < sameCorner && std::abs(known.y - p.y) < sameCorner &&
                std::abs(known.z - p.z) < sameCorner)
                return known;
        known_.push_back(p);
        return p;
    }

private:
    std::vector<glm::dvec3> known_;
};

void unify(Polygon& polygon, Corners& corners) {
    for (glm::dvec3& p : polygon) p = corners.unify(p);
    polygon.shorten(static_cast<std::size_t>(std::unique(polygon.begin(), polygon.end()) - polygon.begin()));
    while (polygon.size() > 1 && polygon.front() == polygon.back()) polygon.shorten(polygon.size() - 1);
}

} // namespace

std::optional<Brush> makeBrush(const BrushText& text, PlaneSet& planes, std::string& reason) {
    Brush brush;
    brush.text = &text;
    for (std::size_t i = 0; i < text.faces.size(); ++i) {
        const std::optional<Plane> plane = planeThrough(text.faces[i].points);
        if (!plane) continue; // three points on a line bound nothing
        if (std::abs(plane->distance) > worldHalf) {
            reason = "reaches beyond the world, 131072 units from its middle";
            return std::nullopt;
        }
        const std::uint32_t number = planes.find(*plane);
        const auto known = [&](std::uint32_t n) {
            return std::any_of(brush.sides.begin(), brush.sides.end(), [&](const Side& s) { return s.plane == n; });
        };
        if (known(number ^ 1U)) {
            reason = "has no volume: two of its faces lie back to back";
            return std::nullopt;
        }
        if (!known(number)) brush.sides.push_back({number, 0, i, {}});
    }
    Corners corners;
    for (Side& side : brush.sides) {
        side.polygon = wholePlane(planes[side.plane]);
        for (const Side& other : brush.sides) {
            if (&other == &side) continue;
            keepBehind(side.polygon, planes[other.plane], fine);
            if (side.polygon.empty()) break;
        }
        for (const glm::dvec3& p : side.polygon)
            if (glm::length(p) > 1.7 * worldHalf || std::abs(p.x) > worldHalf || std::abs(p.y) > worldHalf ||
                std::abs(p.z) > worldHalf) {
                reason = "is open, or reaches beyond the world";
                return std::nullopt;
            }
        unify(side.polygon, corners);
    }
    std::erase_if(brush.sides, [](const Side& side) { return side.polygon.size() < 3 || !(area(side.polygon) > 0); });
    for (const Side& side : brush.sides) brush.bounds.extend(side.polygon);
    if (brush.sides.size() < 4) {
        reason = "has no volume";
        return std::nullopt;
    }
    return brush;
}

double volume(const Brush& brush, const PlaneSet& planes) {
    // Cones from one corner to every face: small numbers wherever the brush stands.
    const glm::dvec3 apex = brush.sides.front().polygon.front();
    double sum = 0;
    for (const Side& side : brush.sides) sum -= area(side.polygon) * planes[side.plane].above(apex);
    return sum / 3;
}

} // namespace pie::brushes
