#pragma once
// The surface of a scene cut at the cells of a cubic grid: what texels are made of. Internal to this folder.

#include "pie/core/vec.h"
#include "pie/scene/scene.h"

#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace pie::gather {

/// Cell, 20 bits a coordinate, and direction, as facing().
[[nodiscard]] std::uint64_t texelKey(const glm::ivec3& cell, unsigned direction);
[[nodiscard]] glm::ivec3 texelCell(std::uint64_t key);
/// Axis (0 to 2) and sign of what a surface faces along: 2 · axis, plus one when negative.
[[nodiscard]] unsigned facing(const glm::dvec3& normal);
/// Not the sky, nor a triangle without a normal.
[[nodiscard]] bool keepsLight(const scene::Scene& scene, std::size_t triangle);

/// A triangle of surface within one cell.
struct TexelPiece {
    std::uint64_t key = 0;
    std::uint32_t triangle = 0, texel = 0;
    Vec3 corner{0.0F}, side1{0.0F}, side2{0.0F};
    float area = 0;
    bool back = false;
};

/// Pieces in the order of the triangles, those of a two-sided one twice; false when there would be more than 8 · most.
/// `scale`: cells a unit. `direction`: of each triangle, 255 to leave it out.
[[nodiscard]] bool cutAll(const scene::Scene& scene, const glm::dvec3& origin, double scale,
                          std::span<const std::uint8_t> direction, std::size_t most, std::vector<TexelPiece>& pieces);
/// How many cells they lie in.
[[nodiscard]] std::size_t cellsOf(std::span<const TexelPiece> pieces);

} // namespace pie::gather
