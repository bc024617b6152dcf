#include "pie/lights/light_entity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pie::lights {
namespace {

constexpr float defaultIntensity = 300.0F;
constexpr float darkest = 0.001F; // 0 would be taken for the default

/// The shortest that reads back as it is, without an exponent, which editors do not know.
std::string written(float number) {
    const std::string shortest = fmt::format("{}", number == 0.0F ? 0.0F : number);
    return shortest.find('e') == std::string::npos ? shortest : fmt::format("{:f}", number);
}

std::string written(const Vec3& v) { return fmt::format("{} {} {}", written(v.x), written(v.y), written(v.z)); }

/// The factor that an entity's intensity is multiplied by.
float scaleOf(const level::Entity& entity) {
    const float scale = entity.number("scale").value_or(1.0F);
    return scale != 0.0F ? scale : 1.0F;
}

} // namespace

Vec3 positionOf(const level::Entity& entity) { return entity.vector("origin").value_or(Vec3(0.0F)); }

void setPosition(level::Entity& entity, const Vec3& position) { entity.set("origin", written(position)); }

float intensityOf(const level::Entity& entity) {
    const float intensity = entity.number("_light").value_or(entity.number("light").value_or(defaultIntensity));
    return (intensity != 0.0F ? intensity : defaultIntensity) * scaleOf(entity);
}

void setIntensity(level::Entity& entity, float intensity) {
    float value = intensity / scaleOf(entity);
    if (!(std::abs(value) >= darkest)) value = darkest;
    entity.set(entity.number("_light") ? "_light" : "light", written(value));
}

Rgb colourOf(const level::Entity& entity) { return entity.vector("_color").value_or(Vec3(1.0F)); }

void setColour(level::Entity& entity, const Rgb& colour) {
    Rgb clean(0.0F);
    for (int i = 0; i < 3; ++i)
        if (std::isfinite(colour[i])) clean[i] = std::max(0.0F, colour[i]);
    entity.set("_color", written(clean));
}

} // namespace pie::lights
