#pragma once
// Photons placed by hand, receivers among them, and an estimate.

#include "pie/gather/nearest_photons.h"
#include "tests/gather/scenes.h"

namespace pie::gather::test {

inline photons::Photon photonOn(const scene::Scene& scene, std::uint32_t triangle, const Vec3& position, float watts) {
    photons::Photon photon;
    photon.position = position;
    photon.triangle = triangle;
    photon.direction = -scene.normals[triangle];
    photon.flux = Rgb(watts, 2.0F * watts, 0.0F);
    photon.bounce = 1;
    return photon;
}

/// Photons thrown evenly on every triangle: `irradiance` watts per square unit.
inline std::vector<photons::Photon> even(const scene::Scene& scene, std::size_t count, float irradiance,
                                         std::uint32_t seed) {
    const SurfaceSampler sampler(scene);
    const float watts = irradiance * static_cast<float>(sampler.area()) / static_cast<float>(count);
    std::mt19937 random(seed);
    std::vector<photons::Photon> photons;
    for (std::size_t i = 0; i < count; ++i) {
        const auto [position, triangle] = sampler(random);
        photons.push_back(photonOn(scene, triangle, position, watts));
    }
    return photons;
}

inline std::shared_ptr<const scene::Scene> room() {
    SceneBuilder builder;
    builder.room(Vec3(0.0F), Vec3(100.0F));
    return builder.make();
}

} // namespace pie::gather::test
