#pragma once
// What the settings say to the folders below, for whoever makes a scene and its lights without an Engine, or a frame
// without a Transport.

#include "pie/engine/settings.h"
#include "pie/gather/nearest_photons.h"
#include "pie/lights/import.h"
#include "pie/lights/light_set.h"
#include "pie/photons/tracer.h"
#include "pie/scene/mesh.h"
#include "pie/scene/scene.h"

namespace pie::engine {

[[nodiscard]] scene::SceneOptions sceneOptions(const Settings& settings);
/// By length, see RefineBy.
[[nodiscard]] scene::RefineOptions refineOptions(const Settings& settings);
[[nodiscard]] lights::ImportOptions importOptions(const Settings& settings);

/// What follows from budget_ms and target_error: values that nobody set are chosen by them.
[[nodiscard]] Settings chosen(Settings settings);
/// Whether light is gathered from surface texels, so that photons are kept in no map.
[[nodiscard]] bool gathers(const Settings& settings);
/// Whether texels have direct light from first hits: asked for, or because there are many lights.
[[nodiscard]] bool texelsByPhotons(const Settings& settings, const lights::LightSet& lights);
[[nodiscard]] photons::TracerOptions tracerOptions(const Settings& settings, const lights::LightSet& lights);
[[nodiscard]] gather::NearestOptions nearestOptions(const Settings& settings);

} // namespace pie::engine
