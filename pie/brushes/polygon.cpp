#include "pie/brushes/polygon.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pie::brushes {
namespace {

glm::dvec3 areaVector(const Polygon& polygon) {
    glm::dvec3 sum(0);
    for (std::size_t i = 2; i < polygon.size(); ++i)
        sum += glm::cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
    return 0.5 * sum;
}

/// Where the edge from `a` to `b` meets the plane. The same from either end, and exact on axial planes: two brushes
/// that share an edge get the same corner.
glm::dvec3 meeting(const glm::dvec3& a, const glm::dvec3& b, double da, double db, const Plane& plane) {
    if (da < db) return meeting(b, a, db, da, plane);
    glm::dvec3 point = a + (da / (da - db)) * (b - a);
    for (int axis = 0; axis < 3; ++axis)
        if (plane.normal[axis] == 1)
            point[axis] = plane.distance;
        else if (plane.normal[axis] == -1)
            point[axis] = -plane.distance;
    return point;
}

bool turnsLeft(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& normal, double& sine) {
    const glm::dvec3 in = b - a;
    const glm::dvec3 out = c - b;
    const double lengths = glm::length(in) * glm::length(out);
    sine = lengths > 0 ? glm::dot(glm::cross(in, out), normal) / lengths : 0;
    constexpr double straight = 1e-7;
    return sine > -straight;
}

/// `a` and `b` joined along an edge that both have, or nothing if that is not convex.
bool joined(const Polygon& a, const Polygon& b, const glm::dvec3& normal, Polygon& result) {
    const auto same = [](const glm::dvec3& p, const glm::dvec3& q) {
        return std::abs(p.x - q.x) < onPlane && std::abs(p.y - q.y) < onPlane && std::abs(p.z - q.z) < onPlane;
    };
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t k = 0; k < b.size(); ++k) {
            if (!same(a[i], b[(k + 1) % b.size()]) || !same(a[(i + 1) % a.size()], b[k])) continue;
            result.clear();
            for (std::size_t j = 1; j <= a.size(); ++j) result.add(a[(i + j) % a.size()]);
            for (std::size_t j = 2; j < b.size(); ++j) result.add(b[(k + j) % b.size()]);
            Polygon kept;
            for (std::size_t j = 0; j < result.size(); ++j) {
                double sine = 0;
                const glm::dvec3& before = result[(j + result.size() - 1) % result.size()];
                if (!turnsLeft(before, result[j], result[(j + 1) % result.size()], normal, sine)) return false;
                constexpr double bend = 1e-7;
                if (sine > bend) kept.add(result[j]);
            }
            result = std::move(kept);
            return result.size() >= 3;
        }
    return false;
}

} // namespace

Polygon wholePlane(const Plane& plane) {
    // The axis farthest from the normal gives the direction of "up".
    const glm::dvec3 size = glm::abs(plane.normal);
    const bool steep = size.z >= size.x && size.z >= size.y;
    glm::dvec3 up = steep ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
    up = glm::normalize(up - glm::dot(up, plane.normal) * plane.normal) * (2 * worldHalf);
    const glm::dvec3 right = glm::cross(up, plane.normal);
    const glm::dvec3 origin = plane.normal * plane.distance;
    return {origin - right - up, origin + right - up, origin + right + up, origin - right + up};
}

Place placeOf(const Polygon& polygon, const Plane& plane, double epsilon) {
    double highest = 0;
    double lowest = 0;
    for (const glm::dvec3& p : polygon) {
        const double above = plane.above(p);
        highest = std::max(highest, above);
        lowest = std::min(lowest, above);
    }
    if (lowest >= -epsilon) return highest > epsilon ? Place::Front : Place::On;
    return highest > epsilon ? Place::Both : Place::Back;
}

Place split(const Polygon& polygon, const Plane& plane, Polygon& front, Polygon& back, double epsilon) {
    const Place place = placeOf(polygon, plane, epsilon);
    if (place != Place::Both) return place;
    front.clear();
    back.clear();
    double here = plane.above(polygon.front());
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3& next = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        const double there = plane.above(next);
        if (here >= -epsilon) front.add(polygon[i]);
        if (here <= epsilon) back.add(polygon[i]);
        if ((here > epsilon && there < -epsilon) || (here < -epsilon && there > epsilon)) {
            const glm::dvec3 point = meeting(polygon[i], next, here, there, plane);
            front.add(point);
            back.add(point);
        }
        here = there;
    }
    return place;
}

void keepBehind(Polygon& polygon, const Plane& plane, double epsilon) {
    Polygon front;
    Polygon back;
    switch (split(polygon, plane, front, back, epsilon)) {
    case Place::Back: return;
    case Place::Both: polygon = std::move(back); return;
    case Place::On:
    case Place::Front: polygon.clear(); return;
    }
}

double area(const Polygon& polygon) { return glm::length(areaVector(polygon)); }

bool hasArea(const Polygon& polygon) {
    if (polygon.size() < 3) return false;
    double around = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i)
        around += glm::length(polygon[(i + 1) % polygon.size()] - polygon[i]);
    // Twice the area over half the circumference is about the width.
    return area(polygon) > 0.5 * onPlane * around;
}

void joinConvex(std::vector<Polygon>& polygons, const glm::dvec3& normal) {
    constexpr std::size_t mostPieces = 64; // beyond, trying every pair costs more than it saves
    if (polygons.size() > mostPieces) return;
    Polygon result;
    for (bool again = polygons.size() > 1; again;) {
        again = false;
        for (std::size_t i = 0; i < polygons.size() && !again; ++i)
            for (std::size_t k = i + 1; k < polygons.size() && !again; ++k)
                if (joined(polygons[i], polygons[k], normal, result)) {
                    polygons[i] = result;
                    polygons.erase(polygons.begin() + static_cast<std::ptrdiff_t>(k));
                    again = polygons.size() > 1;
                }
    }
}

void Bounds::extend(const glm::dvec3& p) {
    lower = glm::min(lower, p);
    upper = glm::max(upper, p);
}

bool Bounds::overlaps(const Bounds& other, double margin) const {
    for (int axis = 0; axis < 3; ++axis)
        if (lower[axis] > other.upper[axis] - margin || upper[axis] < other.lower[axis] + margin) return false;
    return true;
}

} // namespace pie::brushes
