#pragma once
// Diffuse reflectance from the picture of a surface: the "bleeding colour" of the paper (pi-engine 4.3), with alpha and
// script surfaces minded. Not for use outside pie/scene.

#include "pie/scene/scene.h"

namespace pie::scene {

/// Which texels count in a mean, and how much.
enum class TexelWeight : std::uint8_t {
    All,     ///< alpha means something else (gloss, glow) or nothing
    Alpha,   ///< as much as the surface covers there
    Visible, ///< texels that an alpha test keeps
};

/// Mean texel, 0 to 1. Where no texel has weight, the mean of all. `linear`: texels are taken as sRGB and linearised
/// first.
[[nodiscard]] Rgb meanTexel(const level::Image& image, TexelWeight weight, level::AlphaTest test, bool linear);

/// Reflectance of a shader whose light image is `texture` (null or without picture: 0.5, or the colour of a constant
/// stage), clamped to [0, options.maxReflectance].
[[nodiscard]] Rgb reflectanceOf(const level::Shader& shader, const level::Texture* texture, Interaction interaction,
                                const SceneOptions& options);

} // namespace pie::scene
