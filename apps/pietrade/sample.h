#pragma once
// Where light is compared with the truth: vertices that are drawn, and points of the surfaces between them, where a
// picture shows what the corners of a triangle have.

#include "apps/pietrade/view.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace pietrade {

struct SurfacePoint {
    pie::scene::Receiver receiver; ///< with the normal that shading has there
    std::uint32_t surface = 0;     ///< Level::surfaces
};

struct Sample {
    std::vector<std::uint32_t> vertices; ///< Receivers::points of the mesh it was drawn from
    std::vector<SurfacePoint> points;    ///< evenly over the area
};
/// `count` of both, fewer vertices where there are fewer. Of what is in view and lit; empty where nothing is.
[[nodiscard]] Sample draw(const pie::scene::Mesh& mesh, const pie::scene::Receivers& receivers, const View& view,
                          std::size_t count, std::uint64_t seed);

/// A point of a triangle: the receivers at its corners and their weights.
struct Place {
    std::array<std::uint32_t, 3> receivers{};
    pie::Vec3 weights{0.0F};
};
/// The same points on any mesh of the same level, however refined. None where a mesh has no lit triangle there.
[[nodiscard]] std::vector<std::optional<Place>>
locate(const pie::scene::Mesh& mesh, const pie::scene::Receivers& receivers, const std::vector<SurfacePoint>& points);

} // namespace pietrade
