#pragma once
// All planes of a map, each once: faces lie on one plane exactly when their numbers are equal, whatever rounding their
// three points carry. Pairs face opposite ways: plane n and plane n ^ 1.

#include "pie/brushes/chained_index.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace pie::brushes {

struct Plane {
    glm::dvec3 normal{0};
    double distance = 0; ///< dot(normal, p) on the plane, above it in front

    [[nodiscard]] double above(const glm::dvec3& p) const {
        return normal.x * p.x + normal.y * p.y + normal.z * p.z - distance;
    }
    [[nodiscard]] bool axial() const {
        return normal.x == 1 || normal.y == 1 || normal.z == 1 || normal.x == -1 || normal.y == -1 || normal.z == -1;
    }
};

/// The plane through three points, facing the side from which they run clockwise. Nothing if they are on a line.
/// Normals within 1e-5 of an axis are that axis, distances within 0.001 of an integer that integer: what editors round
/// is put back.
[[nodiscard]] std::optional<Plane> planeThrough(const std::array<glm::dvec3, 3>& points);

class PlaneSet {
public:
    /// Number of the plane; one that differs by less than 1e-5 in the normal and 0.01 in the distance is the same.
    [[nodiscard]] std::uint32_t find(const Plane& plane);
    [[nodiscard]] const Plane& operator[](std::uint32_t number) const { return planes_[number]; }
    [[nodiscard]] std::size_t size() const { return planes_.size(); }

private:
    std::vector<Plane> planes_;
    ChainedIndex buckets_; ///< by distance
};

} // namespace pie::brushes
