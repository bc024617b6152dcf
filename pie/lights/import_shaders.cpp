// Emissive surfaces, suns and sky light: what shader scripts say.

#include "pie/lights/import_parts.h"
#include "pie/lights/kinds.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pie::lights::detail {
namespace {

constexpr float radiosityScale = 0.75F; // of q3map_surfacelight
constexpr float backsplashScale = 7.0F; // times the percentage of q3map_backsplash: 5 % make 0.35
constexpr int maxSkyIterations = 64;    // 4 (n-1)² + 1 directions: 15,877

float radians(float degrees) { return degrees * std::numbers::pi_v<float> / 180.0F; }

/// Mean colour of a picture, over linearised texels if wanted.
Rgb meanColour(const level::Image& image, bool linear) {
    if (!linear) {
        const Vec4 mean = image.mean();
        return {mean.x, mean.y, mean.z};
    }
    glm::dvec3 sum(0.0);
    for (const Rgba8& texel : image.pixels) sum += glm::dvec3(linearised(Rgb(texel.x, texel.y, texel.z) / 255.0F));
    return image.pixels.empty() ? Rgb(0.0F) : Rgb(sum / static_cast<double>(image.pixels.size()));
}

Rgb colourOf(const level::Level& level, const level::Shader& shader, bool linear) {
    if (shader.light.colour) {
        const Rgb colour = normalised(*shader.light.colour);
        return linear ? linearised(colour) : colour;
    }
    const level::Texture* texture = level.lightImage(shader);
    return texture != nullptr && texture->image ? normalised(meanColour(*texture->image, linear)) : Rgb(1.0F);
}

Rgb skyColour(const level::Level& level, const level::Shader& shader, bool linear) {
    if (!shader.skyBox.empty() && shader.skyBox != "-")
        if (const level::Texture* up = level.texture(level::skyBoxImages(shader.skyBox)[4]); up != nullptr && up->image)
            return normalised(meanColour(*up->image, linear));
    return colourOf(level, shader, linear);
}

SunLight sunOf(const level::SunKey& key, const ImportOptions& options) {
    const float degrees = radians(key.degrees);
    const float elevation = radians(key.elevation);
    Rgb colour = normalised(key.colour);
    if (options.linear) colour = linearised(colour);
    SunLight sun;
    sun.towards = glm::normalize(
        Vec3(std::cos(degrees) * std::cos(elevation), std::sin(degrees) * std::cos(elevation), std::sin(elevation)));
    sun.irradiance = colour * (key.intensity * options.skyScale);
    sun.devianceRadians = radians(std::max(0.0F, key.deviance));
    return sun;
}

/// Rings of suns at elevations (k + ½) · 90°/n, each turned against the one below as the level compiler does, and one
/// in the zenith.
SkyLight skyOf(const level::SkyLightKey& key, const Rgb& colour) {
    const int rings = std::clamp(key.iterations, 2, maxSkyIterations) - 1;
    const int perRing = 4 * rings;
    SkyLight sky;
    for (int ring = 0; ring < rings; ++ring)
        for (int i = 0; i < perRing; ++i) {
            const float elevation = radians((static_cast<float>(ring) + 0.5F) * 90.0F / static_cast<float>(rings + 1));
            const float turn = static_cast<float>(i) + static_cast<float>(ring) / static_cast<float>(rings);
            const float azimuth = radians(360.0F * turn / static_cast<float>(perRing));
            sky.towards.push_back(glm::normalize(Vec3(std::cos(azimuth) * std::cos(elevation),
                                                      std::sin(azimuth) * std::cos(elevation), std::sin(elevation))));
        }
    sky.towards.emplace_back(0.0F, 0.0F, 1.0F);
    sky.irradiance = colour * (key.value / static_cast<float>(sky.towards.size()));
    return sky;
}

class ShaderImport {
public:
    ShaderImport(const level::Level& level, const ImportOptions& options, ImportedLights& result)
        : level_(level), options_(options), result_(result), met_(level.shaders.size(), 0) {}

    void add(std::uint32_t number) {
        const level::Surface& surface = level_.surfaces[number];
        if (surface.shader >= level_.shaders.size()) return;
        if (surface.model < level_.models.size() && !level_.models[surface.model].drawn) return;
        const level::Shader& shader = level_.shaders[surface.shader];
        if (met_[surface.shader] == 0) {
            met_[surface.shader] = 1;
            addSky(shader);
        }
        if (std::isfinite(shader.light.surfaceLight) && shader.light.surfaceLight > 0.0F &&
            (shader.drawn() || shader.parms.sky))
            addSurface(surface, number, shader);
    }

private:
    void addSky(const level::Shader& shader) {
        for (const auto& key : shader.light.suns) {
            if (!(key.intensity > 0.0F) || !std::isfinite(key.degrees + key.elevation)) continue;
            result_.lights.emplace_back(sunOf(key, options_));
            ++result_.suns;
        }
        for (const auto& key : shader.light.skyLights) {
            if (!(key.value > 0.0F)) continue;
            if (key.iterations > maxSkyIterations)
                warnOnce(result_, "a q3map_skyLight of more than 64 iterations is taken as one of 64");
            result_.lights.emplace_back(skyOf(key, skyColour(level_, shader, options_.linear) * options_.skyScale));
            ++result_.skies;
        }
    }

    void addSurface(const level::Surface& surface, std::uint32_t number, const level::Shader& shader) {
        const Rgb colour = colourOf(level_, shader, options_.linear);
        const Rgb radiosity = colour * (radiosityScale * shader.light.surfaceLight * options_.areaScale);
        const float splash = backsplashScale * shader.light.backsplashPercent / 100.0F;
        for (auto& corners : convexPolygons(level_, surface)) {
            AreaLight light = makeAreaLight(std::move(corners), radiosity, shader.twoSided(), number);
            if (!(light.area > 0.0)) continue;
            if (options_.backsplash && !shader.parms.sky && splash > 0.0F) {
                std::vector<Vec3> behind(light.corners.rbegin(), light.corners.rend());
                for (Vec3& corner : behind) corner += shader.light.backsplashDistance * light.normal;
                result_.lights.emplace_back(makeAreaLight(std::move(behind), splash * radiosity, false, number));
            }
            result_.lights.emplace_back(std::move(light));
            ++result_.areas;
        }
    }

    const level::Level& level_;
    const ImportOptions& options_;
    ImportedLights& result_;
    std::vector<char> met_;
};

} // namespace

void importShaders(const level::Level& level, const ImportOptions& options, ImportedLights& result) {
    ShaderImport import(level, options, result);
    for (std::uint32_t i = 0; i < level.surfaces.size(); ++i) import.add(i);
}

} // namespace pie::lights::detail
