// Light entities, and what stands in for them where a level has no light at all.

#include "pie/lights/import_parts.h"
#include "pie/lights/kinds.h"
#include "pie/lights/light_entity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

namespace pie::lights::detail {
namespace {

using level::Entity;

constexpr double pointScale = 7500.0; // of the level compiler: E = 7500 I / d²
constexpr double fullSphere = 4.0 * std::numbers::pi;
constexpr float spotMargin = 16.0F; // units added to `radius`

enum Spawnflags : unsigned { Linear = 1, NoAngle = 2, Unnormalised = 32 };

bool sameLetter(char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}
bool startsWith(std::string_view text, std::string_view prefix) {
    return text.size() >= prefix.size() && std::equal(prefix.begin(), prefix.end(), text.begin(), sameLetter);
}
bool same(std::string_view a, std::string_view b) { return a.size() == b.size() && startsWith(a, b); }

float positive(const Entity& entity, std::string_view key, float otherwise) {
    const float value = entity.number(key).value_or(otherwise);
    return value > 0.0F ? value : otherwise;
}

Rgb colourOf(const Entity& entity, unsigned flags, bool linear) {
    Rgb colour = lights::colourOf(entity);
    colour = (flags & Unnormalised) != 0 ? glm::max(colour, Rgb(0.0F)) : normalised(colour);
    return linear ? linearised(colour) : colour;
}

Falloff falloffOf(const Entity& entity, unsigned flags, float intensity) {
    Falloff falloff;
    falloff.extraDistance = positive(entity, "_extradist", 0.0F);
    falloff.angleScale = positive(entity, "_anglescale", 1.0F);
    falloff.noCosine = (flags & NoAngle) != 0;
    falloff.linear = (flags & Linear) != 0;
    falloff.linearIntensity = std::abs(intensity);
    falloff.fade = positive(entity, "fade", 1.0F);
    return falloff;
}

/// Power that makes a light of this falloff give the compiler's irradiance.
double wattsOf(const Falloff& falloff, float intensity) {
    if (!falloff.linear) return fullSphere * pointScale * intensity;
    return std::copysign(linearFlux(falloff), intensity);
}

const Entity* findTarget(const level::Level& level, std::string_view name) {
    for (const auto* entities : {&level.lightEntities, &level.entities})
        for (const auto& entity : *entities)
            if (entity.has("targetname") && same(entity.value("targetname"), name)) return &entity;
    return nullptr;
}

class EntityImport {
public:
    EntityImport(const level::Level& level, const ImportOptions& options, ImportedLights& result)
        : level_(level), options_(options), result_(result) {}

    void add(const Entity& entity) {
        const auto flags = static_cast<unsigned>(std::clamp(entity.number("spawnflags").value_or(0.0F), 0.0F, 1e9F));
        const Vec3 origin = positionOf(entity);
        const float intensity = intensityOf(entity) * options_.pointScale;
        const Rgb colour = colourOf(entity, flags, options_.linear);
        const float deviance =
            positive(entity, "_deviance", positive(entity, "_deviation", positive(entity, "_jitter", 0.0F)));
        // `_samples N` makes the compiler place N copies of 1/N each: the sum stays, and one soft light stands for it.
        const Falloff falloff = falloffOf(entity, flags, intensity);
        if (falloff.noCosine) warnOnce(result_, "lights without cosine (spawnflag 2) give photons of unequal power");
        if (falloff.linear)
            warnOnce(
                result_,
                "lights with linear falloff (spawnflag 1) have no physical flux; photons are weighted by distance");
        const Rgb power = scaled(colour, wattsOf(falloff, intensity));

        if (entity.has("target")) {
            if (const auto target = targetOf(entity, origin)) {
                const Vec3 way = *target - origin;
                const float distance = glm::length(way);
                if (entity.number("_sun").value_or(0.0F) != 0.0F)
                    return addSun(-way / distance, colour * intensity, deviance);
                return addSpot(entity, origin, way / distance, distance, power, falloff);
            }
        }
        if (deviance > 0.0F) {
            // Copies jittered within a cube of ±deviance are as far from the centre, in the mean square, as this
            // sphere.
            result_.lights.emplace_back(SphereLight{origin, power, deviance, falloff});
            ++result_.spheres;
        } else {
            result_.lights.emplace_back(PointLight{origin, power, falloff});
            ++result_.points;
        }
    }

private:
    std::optional<Vec3> targetOf(const Entity& entity, const Vec3& origin) {
        const std::string_view name = entity.value("target");
        const Entity* target = findTarget(level_, name);
        auto position = target != nullptr ? target->vector("origin") : std::nullopt;
        if (position && glm::length(*position - origin) > 0.0F) return position;
        warnOnce(result_, fmt::format("a light at {:g} {:g} {:g} has no target named '{}': it shines in all directions",
                                      origin.x, origin.y, origin.z, name));
        return std::nullopt;
    }
    void addSun(const Vec3& towards, const Rgb& irradiance, float devianceDegrees) {
        result_.lights.emplace_back(
            SunLight{towards, irradiance, devianceDegrees * std::numbers::pi_v<float> / 180.0F});
        ++result_.suns;
    }
    void addSpot(const Entity& entity, const Vec3& origin, const Vec3& direction, float distance, const Rgb& power,
                 const Falloff& falloff) {
        SpotLight spot;
        spot.position = origin;
        spot.direction = direction;
        spot.power = power;
        spot.slope = (positive(entity, "radius", 64.0F) + spotMargin) / distance;
        spot.falloff = falloff;
        result_.lights.emplace_back(spot);
        ++result_.spots;
    }

    const level::Level& level_;
    const ImportOptions& options_;
    ImportedLights& result_;
};

} // namespace

bool isLight(const Entity& entity) {
    const std::string_view name = entity.className();
    // lightJunior lights the grid for moving models only.
    return startsWith(name, "light") && !same(name, "lightjunior");
}

void importEntity(const level::Level& level, const Entity& entity, const ImportOptions& options,
                  ImportedLights& result) {
    EntityImport(level, options, result).add(entity);
}

void importEntities(const level::Level& level, const ImportOptions& options, ImportedLights& result) {
    for (std::uint32_t i = 0; i < level.lightEntities.size(); ++i) {
        if (!isLight(level.lightEntities[i])) continue;
        importEntity(level, level.lightEntities[i], options, result);
        result.entities.push_back(i);
    }
}

void importFallback(const level::Level& level, const scene::Scene& scene, ImportedLights& result) {
    constexpr float above = 64.0F;      // units over a player start
    constexpr float softness = 16.0F;   // radius, units
    constexpr double irradiance = 64.0; // U: a texture appears as it is drawn
    std::vector<Vec3> places;
    for (const auto& entity : level.entities)
        if (startsWith(entity.className(), "info_player") || startsWith(entity.className(), "team_ctf_"))
            if (const auto origin = entity.vector("origin")) places.push_back(*origin + Vec3(0.0F, 0.0F, above));
    const bool starts = !places.empty();
    if (!starts) places.push_back(scene.bounds.empty() ? Vec3(0.0F) : scene.bounds.centre());
    const double watts = irradiance * (scene.area > 0.0 ? scene.area : fullSphere * 512.0 * 512.0);
    for (const Vec3& place : places) {
        result.lights.emplace_back(
            SphereLight{place, Rgb(static_cast<float>(watts / static_cast<double>(places.size()))), softness, {}});
        ++result.spheres;
    }
    result.fallback = true;
    result.sources = "fallback";
    result.warnings.push_back(fmt::format("the level has no light: {} soft point light{} {} stand{} in for it",
                                          places.size(), places.size() == 1 ? "" : "s",
                                          starts ? "above the player starts" : "in the middle of the level",
                                          places.size() == 1 ? "s" : ""));
}

} // namespace pie::lights::detail
