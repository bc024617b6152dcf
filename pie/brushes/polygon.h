#pragma once
// Convex polygons in a plane, cut by planes: the one operation that brushes, hidden faces and the tree are made of.

#include "pie/brushes/plane_set.h"

#include <glm/vec3.hpp>

#include <span>
#include <vector>

namespace pie::brushes {

using Polygon = std::vector<glm::dvec3>; ///< convex; counter-clockwise seen from where its plane faces

/// Half the side of the square that stands for a whole plane; no brush may reach farther.
inline constexpr double worldHalf = 131072;
/// A point this near to a plane lies on it, units.
inline constexpr double onPlane = 1e-3;

/// A square of the plane that covers the world.
[[nodiscard]] Polygon wholePlane(const Plane& plane);
/// What lies in front of the plane and what behind; both empty where less than `epsilon` sticks out. A polygon in the
/// plane is neither.
struct Split {
    Polygon front, back;
};
[[nodiscard]] Split split(const Polygon& polygon, const Plane& plane, double epsilon = onPlane);
/// Keeps what lies behind the plane.
void keepBehind(Polygon& polygon, const Plane& plane, double epsilon = onPlane);
[[nodiscard]] double area(const Polygon& polygon);
/// Whether the polygon is worth keeping: it has an area and no side, however long, of no width.
[[nodiscard]] bool hasArea(const Polygon& polygon);
/// Joins polygons of one plane along common edges while the result stays convex.
void joinConvex(std::vector<Polygon>& polygons, const glm::dvec3& normal);

struct Bounds {
    glm::dvec3 lower{1e30}, upper{-1e30};
    void extend(const glm::dvec3& p);
    void extend(std::span<const glm::dvec3> points) {
        for (const glm::dvec3& p : points) extend(p);
    }
    [[nodiscard]] bool empty() const { return lower.x > upper.x; }
    /// Whether they have more in common than a border.
    [[nodiscard]] bool overlaps(const Bounds& other, double margin) const;
};

} // namespace pie::brushes
