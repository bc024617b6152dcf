#include "pie/lights/import.h"
#include "pie/lights/import_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pie::lights {
namespace detail {

Rgb normalised(const Rgb& colour) {
    Rgb clean(0.0F);
    for (int i = 0; i < 3; ++i)
        if (std::isfinite(colour[i])) clean[i] = std::max(0.0F, colour[i]);
    const float largest = maxChannel(clean);
    return largest > 0.0F ? clean / largest : Rgb(1.0F);
}

Rgb linearised(const Rgb& colour) {
    Rgb result(0.0F);
    for (int i = 0; i < 3; ++i)
        result[i] = colour[i] <= 0.04045F ? colour[i] / 12.92F : std::pow((colour[i] + 0.055F) / 1.055F, 2.4F);
    return result;
}

void warnOnce(ImportedLights& result, const std::string& text) {
    if (std::find(result.warnings.begin(), result.warnings.end(), text) == result.warnings.end())
        result.warnings.push_back(text);
}

} // namespace detail

namespace {

void importAmbient(const level::Level& level, const ImportOptions& options, ImportedLights& result) {
    for (const auto* entities : {&level.entities, &level.lightEntities})
        for (const auto& entity : *entities) {
            if (entity.className() != "worldspawn") continue;
            Rgb colour = detail::normalised(entity.vector("_color").value_or(Vec3(1.0F)));
            if (options.linear) colour = detail::linearised(colour);
            result.ambient =
                colour * std::max(0.0F, entity.number("ambient").value_or(entity.number("_ambient").value_or(0.0F)));
            result.minLight = colour * std::max(0.0F, entity.number("_minlight").value_or(0.0F));
            return;
        }
}

} // namespace

std::string ImportedLights::summary() const {
    std::string text;
    const auto count = [&](std::size_t number, const char* kind) {
        if (number != 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", number, kind);
    };
    count(points, "point");
    count(spheres, "sphere");
    count(spots, "spot");
    count(areas, "area");
    count(suns, "sun");
    count(skies, "sky");
    return fmt::format("{}; from {}", text.empty() ? "no lights" : text, sources.empty() ? "nothing" : sources);
}

ImportedLights importLights(const level::Level& level, const scene::Scene& scene, const ImportOptions& options) {
    ImportedLights result;
    importAmbient(level, options, result);
    const auto join = [&](std::size_t before, const std::string& source) {
        if (result.lights.size() == before) return;
        result.sources += (result.sources.empty() ? "" : " and ") + source;
    };
    if (options.entities) {
        detail::importEntities(level, options, result);
        join(0, level.lightEntitySource.empty() ? "entities" : "entities of " + level.lightEntitySource);
    }
    if (options.scripts) {
        const std::size_t before = result.lights.size();
        detail::importShaders(level, options, result);
        join(before, "scripts");
    }
    if ((result.suns != 0 || result.skies != 0) && !scene.has(scene::Interaction::Sky))
        detail::warnOnce(result, "the level has a sun or sky light but no sky surface for it to come through");
    // A sun that no sky lets in lights nothing: such a level counts as one without light.
    const SkyPortals portals = skyPortals(scene);
    const bool anyPower = std::any_of(result.lights.begin(), result.lights.end(), [&](const Light& light) {
        return maxChannel(power(light, scene, portals)) > 0.0F;
    });
    if (!anyPower) detail::importFallback(level, scene, result);
    return result;
}

std::optional<Light> lightOf(const level::Level& level, const level::Entity& entity, const ImportOptions& options) {
    if (!detail::isLight(entity)) return std::nullopt;
    ImportedLights result;
    detail::importEntity(level, entity, options, result);
    return result.lights.front();
}

} // namespace pie::lights
