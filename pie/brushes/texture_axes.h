#pragma once
// From the texture text of a face to coordinates at its points.

#include "pie/brushes/map_text.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace pie::brushes {

/// s = dot(axes[0], p) + shift[0], t likewise; 1 is the width, or height, of the picture.
struct TextureMapping {
    std::array<glm::dvec3, 2> axes{};
    std::array<double, 2> shift{};

    [[nodiscard]] glm::dvec2 at(const glm::dvec3& p) const;
};

/// `normal` of the face; `width` and `height` of its picture in texels, which the first two forms count in.
[[nodiscard]] TextureMapping makeMapping(const TextureText& text, const glm::dvec3& normal, int width, int height);

} // namespace pie::brushes
