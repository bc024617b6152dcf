#pragma once
// Models that levels place (misc_model): triangles with a shader each, out of .md3 (Quake 3), .ase (3D Studio's text)
// and .obj (Wavefront) files.

#include "pie/core/result.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pie::brushes {

struct ModelVertex {
    glm::dvec3 position{0};
    glm::dvec3 normal{0}; ///< of any length; 0: none
    glm::dvec2 texture{0};
};
struct ModelSurface {
    std::string name;   ///< what skins call it; may be empty
    std::string shader; ///< without extension, with '/'
    std::vector<ModelVertex> vertices;
    std::vector<std::uint32_t> indices; ///< three a triangle, counter-clockwise from the front
};
using Model = std::vector<ModelSurface>;

/// The kind is told by the content, else by the name's extension. `frame`: of .md3 files that move; the last one if
/// there are fewer. Corners are all there and finite; an Error says what is wrong and where.
[[nodiscard]] Result<Model> readModel(std::span<const std::byte> bytes, const std::string& fileName, int frame = 0);

} // namespace pie::brushes
