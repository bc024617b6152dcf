#pragma once
// The light kinds behind the variant: one pair of functions per kind, and what they share. Internal to this folder.

#include "pie/lights/light.h"

#include <array>
#include <cmath>

namespace pie::lights::detail {

/// `colour` × `factor` without overflow in between.
[[nodiscard]] Rgb scaled(const Rgb& colour, double factor);
/// Lights whose direction is not one give nothing.
[[nodiscard]] inline bool isUnit(const Vec3& direction) {
    return std::abs(glm::dot(direction, direction) - 1.0F) < 1e-3F;
}
/// Largest flux per unit of c that a linear light of E = c max(0, i − fade d) sends through a sphere around it: at two
/// thirds of its reach. Its photons are weighted against this.
[[nodiscard]] double linearFlux(const Falloff& falloff);

[[nodiscard]] Rgb areaPower(const AreaLight& light);
[[nodiscard]] Emission emitArea(const AreaLight& light, const Box& bounds, const std::array<float, 4>& u);
[[nodiscard]] Illumination illuminateArea(const AreaLight& light, const Vec3& point, const Vec3& normal, bool twoSided,
                                          const Vec2& u);

[[nodiscard]] Rgb sunPower(const SunLight& light, const SkyPortals& portals);
[[nodiscard]] Emission emitSun(const SunLight& light, const scene::Scene& scene, const SkyPortals& portals,
                               const std::array<float, 4>& u);
[[nodiscard]] Illumination illuminateSun(const SunLight& light, const Vec3& normal, bool twoSided, const Vec2& u);
[[nodiscard]] Emission emitParallel(const Vec3& towards, const Rgb& irradiance, const scene::Scene& scene,
                                    const SkyPortals& portals, const Vec2& u);

[[nodiscard]] Rgb skyPower(const SkyLight& light, const SkyPortals& portals);
[[nodiscard]] Emission emitSky(const SkyLight& light, const scene::Scene& scene, const SkyPortals& portals,
                               const std::array<float, 4>& u);
[[nodiscard]] Illumination illuminateSky(const SkyLight& light, const Vec3& normal, bool twoSided, const Vec2& u);

} // namespace pie::lights::detail
