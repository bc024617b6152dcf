#pragma once
// Light sources. Power is in watts per channel, where one watt per square unit of irradiance is one lightmap unit U of
// the game (255 U is a full lightmap byte before display): so an entity of intensity I has 4 pi · 7500 · I watts.
//
// Each kind offers the same two operations (free functions over the variant, below): `emit` makes a photon,
// `illuminate` gives the irradiance at a point before visibility. Both describe the same light: a test compares them
// for every kind. What the level compiler does beyond physics (a smallest distance, no cosine, linear falloff, the rim
// of a spot in units) depends on where the light arrives: `arrivalFactor` says by how much a photon's flux changes at
// its first surface.

#include "pie/core/vec.h"
#include "pie/scene/scene.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>
#include <variant>
#include <vector>

namespace pie::lights {

/// How the level compiler lets an entity fall off, beyond the physical inverse square.
struct Falloff {
    float extraDistance = 0; ///< _extradist: d'² = d² + extra²
    float minDistance = 16;  ///< d' >= 16 units in the compiler; 0 for physical lights
    float angleScale = 1;    ///< _anglescale K: min(1, cos / K)
    bool noCosine = false;   ///< spawnflag 2
    bool linear = false;     ///< spawnflag 1: E = c max(0, 0.9375 I − fade d'); no physical flux, see emit
    float linearIntensity = 0, fade = 1;
};

struct PointLight {
    Vec3 position{0.0F};
    Rgb power{0.0F};
    Falloff falloff;
};
/// A sphere whose points radiate alike in all directions: a soft point light. Being a shell of point sources it gives
/// exactly what a point light in its centre gives wherever all of it is above the horizon (Newton's shell theorem: the
/// irradiance is the normal component of an inverse-square field), and it still shines on what reaches into it.
struct SphereLight {
    Vec3 position{0.0F};
    Rgb power{0.0F};
    float radius = 1;
    Falloff falloff;
};
/// `power` is that of the full sphere (4 pi × intensity); the cone passes part of it. At axial depth h the cone has
/// radius h · slope: full inside, fading linearly over its outermost `rim` units.
struct SpotLight {
    Vec3 position{0.0F};
    Vec3 direction{0.0F}; ///< unit, else it gives nothing
    Rgb power{0.0F};
    float slope = 0.5F;
    float rim = 32;
    Falloff falloff;
};
/// Parallel light through the sky surfaces. `irradiance` on a surface that faces it.
struct SunLight {
    Vec3 towards{0.0F, 0.0F, 1.0F};
    Rgb irradiance{0.0F};
    float devianceRadians = 0;
};
/// Lambertian polygon (convex, planar), radiating to the side of its normal, or to both.
struct AreaLight {
    std::vector<Vec3> corners;
    Vec3 normal{0.0F};
    double area = 0;
    Rgb radiosity{0.0F};
    bool twoSided = false;
    std::uint32_t surface = 0xffffffffU; /*!< Level::surfaces */
};
/// The dome of the level compiler's q3map_skyLight: equal suns in the given directions, each giving `irradiance` face
/// on.
struct SkyLight {
    std::vector<Vec3> towards;
    Rgb irradiance{0.0F};
};

using Light = std::variant<PointLight, SphereLight, SpotLight, SunLight, AreaLight, SkyLight>;

/// Where the sun and the sky come in: sky triangles of the scene, for choosing points on them by projected area. Light
/// enters on the front side of a triangle, when the sun is behind it. Made by `skyPortals`.
struct SkyPortals {
    std::vector<std::uint32_t> triangles; ///< Scene::triangles with Interaction::Sky, those of a group together
    Box bounds;                           ///< of the scene
    /// Triangles of one orientation: within it the projected area is proportional to the area for every direction.
    struct Group {
        Vec3 normal{0.0F};
        double area = 0;
        std::uint32_t first = 0, count = 0; ///< of `triangles`
    };
    std::vector<Group> groups;
    std::vector<double> cumulative; ///< per triangle: area share up to and including it within its group; ends with 1
};
[[nodiscard]] SkyPortals skyPortals(const scene::Scene& scene);
/// Area that light from `towards` enters through, square units, seen along the light.
[[nodiscard]] double projectedArea(const SkyPortals& portals, const Vec3& towards);

/// A ray of light as it leaves the source.
struct Emission {
    Vec3 origin{0.0F};
    Vec3 direction{0.0F};
    Rgb flux{0.0F}; ///< watts; the mean over all u is the light's power (for suns and skies: what enters through the
                    ///< portals)
    const Falloff* falloff = nullptr;                       ///< of the light, while that lives; null: physical
    float rimRate = std::numeric_limits<float>::infinity(); ///< spots: share of full intensity gained per unit of way
};

/// What a receiver would get along one way, before visibility.
struct Illumination {
    Vec3 towards{0.0F}; ///< unit, from the receiver
    float distance = 0; ///< to the source; infinite for sun and sky
    Rgb irradiance{
        0.0F}; ///< watts per square unit, cosine and falloff applied; mean over u is the unoccluded irradiance
    bool needsSky = false; ///< counts only where the ray's first non-filter surface is sky
};

[[nodiscard]] std::string_view kindName(const Light& light); ///< "point", "sphere", "spot", "sun", "area", "sky"
/// An area light from its corners (convex, planar, counter-clockwise seen from the lit side). Fewer than three corners
/// or no area: an area of 0 and so no light.
[[nodiscard]] AreaLight makeAreaLight(std::vector<Vec3> corners, const Rgb& radiosity, bool twoSided = false,
                                      std::uint32_t surface = 0xffffffffU);
/// How far off its surface a point may lie by rounding, and so how far in front of it rays start: 64 units in the last
/// place of the largest coordinate involved (0.03 units at 4096, 7e-9 in a level 0.001 wide).
[[nodiscard]] inline float surfaceOffset(float largestCoordinate) { return 0x1p-17F * largestCoordinate; }
[[nodiscard]] float largestCoordinate(const Box& bounds, const Vec3& point);

/// Flux in watts per channel that enters the level. For what has no physical flux (linear falloff) the largest that
/// arrives at any distance; a spot counts as if its rim had no width.
[[nodiscard]] Rgb power(const Light& light, const scene::Scene& scene, const SkyPortals& portals);
/// `u`: four numbers in [0, 1): direction (0, 1) and place (2, 3).
[[nodiscard]] Emission emit(const Light& light, const scene::Scene& scene, const SkyPortals& portals,
                            const std::array<float, 4>& u);
/// What the photon's flux is multiplied by at the first surface it meets, `distance` from its origin, under `cosine`
/// (0 to 1) between its direction and the surface's normal. 1 for physical lights; infinite distance is allowed.
[[nodiscard]] float arrivalFactor(const Emission& emission, float distance, float cosine);
/// Sample points of soft sources are chosen by `u`. `twoSided`: light from behind counts as well.
[[nodiscard]] Illumination illuminate(const Light& light, const Vec3& point, const Vec3& normal, bool twoSided,
                                      const Vec2& u);
/// How many samples of `u` a soft source deserves; 1 for point, spot and sharp suns; the number of directions for
/// skies (a sky takes direction floor(u.x · n), so strata in u.x meet each once).
[[nodiscard]] unsigned sampleCount(const Light& light);

} // namespace pie::lights
