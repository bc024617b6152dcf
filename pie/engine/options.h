#pragma once
// What the settings say to the folders below, for whoever makes a scene and its lights without an Engine.

#include "pie/engine/settings.h"
#include "pie/lights/import.h"
#include "pie/scene/scene.h"

namespace pie::engine {

[[nodiscard]] scene::SceneOptions sceneOptions(const Settings& settings);
[[nodiscard]] lights::ImportOptions importOptions(const Settings& settings);

} // namespace pie::engine
