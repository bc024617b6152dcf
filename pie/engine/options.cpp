#include "pie/engine/options.h"

namespace pie::engine {

scene::SceneOptions sceneOptions(const Settings& settings) {
    scene::SceneOptions options;
    options.reflectance = settings.reflectance;
    options.maxReflectance = settings.maxReflectance;
    options.linear = settings.colorSpace == ColorSpace::Srgb;
    return options;
}

lights::ImportOptions importOptions(const Settings& settings) {
    lights::ImportOptions options;
    options.entities = settings.lightEntities;
    options.scripts = settings.lightScripts;
    options.backsplash = settings.backsplash;
    options.pointScale = settings.pointScale * settings.lightScale;
    options.areaScale = settings.areaScale * settings.lightScale;
    options.skyScale = settings.skyScale * settings.lightScale;
    options.linear = settings.colorSpace == ColorSpace::Srgb;
    return options;
}

} // namespace pie::engine
