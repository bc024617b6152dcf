#pragma once
// Lights of a Quake 3 level: light entities (of the BSP, or of the .map beside it), emissive shaders, suns and sky
// light of sky shaders. Formulas: doc/algorithms/lights.md.
//
// A level without any light gets a stated fallback: one soft point light 64 units above every player start, or one in
// the middle of the level if there is none, together 64 watts for every square unit of the scene's surfaces, so that
// textures appear about as they are drawn.

#include "pie/level/level.h"
#include "pie/lights/light.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pie::lights {

struct ImportOptions {
    bool entities = true, scripts = true;
    bool backsplash = true;
    float pointScale = 1, areaScale = 1, skyScale = 1; ///< multiply what was found
    bool linear = false;                               ///< linearise light colours (color_space = srgb)
};

struct ImportedLights {
    std::vector<Light> lights;
    /// Of the light entities, which are the first of `lights`: their place in Level::lightEntities.
    std::vector<std::uint32_t> entities;
    std::size_t points = 0, spheres = 0, spots = 0, areas = 0, suns = 0, skies = 0; ///< by kind, backsplash not counted
    std::string sources;               ///< "entities of oa_dm1.map and scripts", "scripts", "fallback"
    std::vector<std::string> warnings; ///< what is not emulated, once each
    bool fallback = false;
    Rgb ambient{0.0F};  ///< worldspawn _color × ambient: the level compiler adds this irradiance (U) everywhere
    Rgb minLight{0.0F}; ///< worldspawn _color × _minlight: floor of the irradiance (U) at output
    /// "60 point, 14 area, 1 sun; from entities and scripts"
    [[nodiscard]] std::string summary() const;
};

[[nodiscard]] ImportedLights importLights(const level::Level& level, const scene::Scene& scene,
                                          const ImportOptions& options = {});

/// The light that a light entity gives in the level, which may differ from all that are in it: for entities that are
/// being edited. Nothing if it is none that lights the level.
[[nodiscard]] std::optional<Light> lightOf(const level::Level& level, const level::Entity& entity,
                                           const ImportOptions& options = {});

} // namespace pie::lights
