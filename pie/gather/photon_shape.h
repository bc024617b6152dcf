#pragma once
// The surface that photons lie on, guessed from the photons: a shape fitted around those that a search found (pi-engine
// 3.5.2, fig 3.10). Needs no geometry; with few photons it knows little.
//
// `fit`, then divide by the integral of the kernel over `corners`, and leave out the photons that carry the border
// (`onBorder`): given the border, what lies inside is as dense as everywhere, but the photons that hold it are there by
// construction. Counting them makes the density k / (k - 1) times too large when a circle is drawn through the k-th
// photon, and far larger with a hull of many corners.

#include "pie/core/vec.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace pie::gather {

/// What flux is divided by.
enum class AreaEstimate : std::uint8_t {
    Disc,        ///< pi r² (eq 3.1)
    Box,         ///< two longest sides of the box along the axes of the world: right on surfaces along them only
    OrientedBox, ///< in the plane of the receiver, along the principal components
    Ellipse,     ///< in the plane of the receiver, of the same second moments
    Hull,        ///< convex hull in the plane of the receiver
    True,        ///< the surface of the scene inside the search volume (TrueArea)
};

class PhotonShape {
public:
    /// With fewer points there is no shape.
    static constexpr std::size_t fewestPoints = 8;

    /// Fits Box, OrientedBox, Ellipse or Hull to points given by their offsets from the receiver. False when they are
    /// too few or on one line; then there is nothing to ask.
    bool fit(AreaEstimate kind, std::span<const Vec3> offsets, const Frame& frame);
    /// Convex, turning left, about the receiver: in its plane, for Box in the plane of the two longest sides.
    [[nodiscard]] std::span<const glm::dvec2> corners() const { return corners_; }
    /// Of the polygon, square units.
    [[nodiscard]] double area() const;
    /// Never for an Ellipse.
    [[nodiscard]] bool onBorder(std::size_t point) const { return onBorder_[point] != 0; }

private:
    void ellipse();
    void hull();
    void rectangle(const glm::dvec2& u);

    std::vector<glm::dvec2> points_;
    std::vector<std::uint32_t> order_;
    std::vector<std::uint32_t> chain_;
    std::vector<glm::dvec2> corners_;
    std::vector<std::uint8_t> onBorder_;
};

} // namespace pie::gather
