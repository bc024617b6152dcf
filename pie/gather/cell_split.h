#pragma once
// Cuts triangles into the pieces that lie in the cells of a cubic grid. Internal to this folder.

#include "pie/core/vec.h"

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cmath>
#include <cstddef>

namespace pie::gather {

/// A convex polygon of few corners: a triangle cut by the six planes of a cell has nine at most.
struct CellPolygon {
    std::array<glm::dvec3, 12> corners{};
    std::size_t count = 0;
    void add(const glm::dvec3& corner) {
        if (count < corners.size()) corners[count++] = corner;
    }
};

/// The part of the polygon with lower <= p[axis] <= upper.
inline CellPolygon cutSlab(const CellPolygon& polygon, int axis, double lower, double upper) {
    CellPolygon result = polygon;
    for (const double side : {1.0, -1.0}) {
        const double bound = side > 0 ? lower : -upper;
        CellPolygon cut;
        for (std::size_t i = 0; i < result.count; ++i) {
            const glm::dvec3& a = result.corners[i];
            const glm::dvec3& b = result.corners[(i + 1) % result.count];
            const double da = side * a[axis] - bound;
            const double db = side * b[axis] - bound;
            if (da >= 0) cut.add(a);
            if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
                glm::dvec3 point = a + (b - a) * (da / (da - db));
                point[axis] = side > 0 ? lower : upper;
                cut.add(point);
            }
        }
        result = cut;
        if (result.count < 3) return {};
    }
    return result;
}

/// visit(cell, polygon) for every cell of edge 1 that the polygon has area in. Coordinates are in cells.
template <class Visit>
void forEachCell(const CellPolygon& polygon, const Visit& visit, int axis = 0, glm::ivec3 cell = glm::ivec3(0)) {
    if (polygon.count < 3) return;
    if (axis == 3) {
        visit(cell, polygon);
        return;
    }
    double lower = polygon.corners[0][axis];
    double upper = lower;
    for (std::size_t i = 1; i < polygon.count; ++i) {
        lower = std::min(lower, polygon.corners[i][axis]);
        upper = std::max(upper, polygon.corners[i][axis]);
    }
    const auto first = static_cast<int>(std::floor(lower));
    const auto last = static_cast<int>(std::floor(upper));
    for (int c = first; c <= last; ++c) {
        cell[axis] = c;
        forEachCell(first == last ? polygon : cutSlab(polygon, axis, c, c + 1), visit, axis + 1, cell);
    }
}

/// Twice the area, as a vector.
inline glm::dvec3 areaVector(const CellPolygon& polygon) {
    glm::dvec3 sum(0);
    for (std::size_t i = 2; i < polygon.count; ++i)
        sum += glm::cross(polygon.corners[i - 1] - polygon.corners[0], polygon.corners[i] - polygon.corners[0]);
    return sum;
}

} // namespace pie::gather
