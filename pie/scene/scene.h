#pragma once
// The coarse scene that light travels in: triangles with a reflectance. Immutable; an edit makes a new one with a
// higher revision.
//
// Holds only what light can meet: surfaces that neither stop, filter nor receive light (nodraw, plain translucent,
// triggers) are left out.

#include "pie/core/vec.h"
#include "pie/level/level.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace pie::scene {

/// What happens to light at a surface.
enum class Interaction : std::uint8_t {
    Opaque, ///< stops it, reflects `reflectance`
    Filter, ///< lets `transmittance(uv)` of it through and treats the rest as opaque (alphaShadow, lightFilter)
    Sky,    ///< swallows it: light leaves the level here, and sun and sky light enter
};

struct Material {
    Rgb reflectance{0.5F}; ///< diffuse, 0 to 1, of the front; of both sides when two-sided
    Interaction interaction = Interaction::Opaque;
    bool twoSided = false; ///< one-sided surfaces still stop light from behind, but neither store nor reflect it
    bool alphaOnly = true; ///< Filter: true: grey 1 − alpha (alphaShadow); false: texel colour (lightFilter)
    std::shared_ptr<const level::Image> filter; ///< Filter: the picture that says how much passes
    std::uint32_t shader = 0;                   ///< Level::shaders it came from
};

struct Triangle {
    std::array<std::uint32_t, 3> vertices{}; ///< Scene::positions, counter-clockwise from the front
    std::uint32_t material = 0;
    std::uint32_t surface = 0; ///< Level::surfaces it came from
};

/// How reflectance is derived from the mean texel (LEVELS in doc/manual.md).
enum class ReflectanceModel : std::uint8_t {
    Texture,  ///< the texel as stored: true to energy
    Compiler, ///< 0.55147 × texel × q3map_bounce, as the level compiler
};

struct SceneOptions {
    ReflectanceModel reflectance = ReflectanceModel::Texture;
    float maxReflectance =
        0.95F; ///< per channel, so that energy in a closed level stays finite (1 is allowed, at your own risk)
    bool linear = false; ///< linearise texels as sRGB first (color_space = srgb)
};

class Scene {
public:
    std::vector<Vec3> positions; ///< welded: bit-equal positions share an index
    std::vector<Triangle> triangles;
    std::vector<Vec3> normals;            ///< geometric, unit, per triangle; (0,0,0) for triangles without area
    std::vector<Vec2> textureCoordinates; ///< three per triangle; empty when no material filters
    std::vector<Material> materials;
    Box bounds;
    double area = 0; ///< of all Opaque and Filter triangles, one side
    std::uint64_t revision = 1;

    [[nodiscard]] Vec3 corner(std::size_t triangle, int i) const {
        return positions[triangles[triangle].vertices[static_cast<std::size_t>(i)]];
    }
    [[nodiscard]] const Material& material(std::size_t triangle) const {
        return materials[triangles[triangle].material];
    }
    /// Share of light that passes the triangle at barycentric (u, v) (weights of corner 1 and 2). Zero for Opaque, one
    /// for Sky.
    [[nodiscard]] Rgb transmittance(std::size_t triangle, float u, float v) const;
    [[nodiscard]] bool has(Interaction kind) const;
};

/// Builds the scene of a level. Triangles without area are kept out; their number is in `dropped` when given.
[[nodiscard]] Scene makeScene(const level::Level& level, const SceneOptions& options = {},
                              std::size_t* dropped = nullptr);
/// From bare triangles, for tests and tools: three positions per triangle, one material index each.
[[nodiscard]] Scene makeScene(std::span<const Vec3> corners, std::span<const std::uint32_t> materialOfTriangle,
                              std::vector<Material> materials);

} // namespace pie::scene
