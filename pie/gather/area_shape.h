#pragma once
// The integral of a radial kernel over a convex polygon cut with a disc about the origin: what TrueArea sums up.

#include "pie/gather/kernel.h"

#include <glm/vec2.hpp>

#include <span>

namespace pie::gather {

/// The kernel of radius `radius` as it appears in a plane at distance `height` from the receiver, about the foot of the
/// receiver.
struct PlaneKernel {
    Kernel kernel;
    double height;
    double radius;

    /// ∫ kernel · ρ dρ from 0 to `distance`: the integral over a sector per radian.
    [[nodiscard]] double sectorPerRadian(double distanceSquared) const;
    /// Over the triangle (origin, a, b), which lies within the disc. Signed: positive when a → b turns left.
    [[nodiscard]] double triangle(const glm::dvec2& a, const glm::dvec2& b) const;
};

/// The integral over polygon ∩ disc; signed by the polygon's turn.
[[nodiscard]] double integrate(const PlaneKernel& kernel, std::span<const glm::dvec2> polygon);

/// What is the same for all radii: for most radii a polygon lies wholly inside or outside the disc, and the answer is a
/// product.
class FlatPolygon {
public:
    /// Keeps a view of the corners, which turn left. Convex, at least three.
    explicit FlatPolygon(std::span<const glm::dvec2> corners);
    /// As `integrate`.
    [[nodiscard]] double integral(const PlaneKernel& kernel) const;

private:
    std::span<const glm::dvec2> corners_;
    double area_ = 0;
    double moment_ = 0;                               ///< second, about the origin
    double nearestSquared_ = 0, farthestSquared_ = 0; ///< from the origin
};

} // namespace pie::gather
