#include "apps/pieview/save_lights.h"

#include "pie/lights/light_entity.h"

#include <algorithm>
#include <cmath>

namespace pieview {
namespace {

float rounded(float value, float steps) {
    const float result = std::round(value * steps) / steps;
    return std::isfinite(result) ? result : value;
}
Vec3 rounded(const Vec3& value, float steps) {
    return {rounded(value.x, steps), rounded(value.y, steps), rounded(value.z, steps)};
}

/// Linear to sRGB, per channel: the way back from ImportOptions::linear.
Rgb encoded(const Rgb& colour) {
    Rgb result(0.0F);
    for (int i = 0; i < 3; ++i)
        result[i] = colour[i] <= 0.0031308F ? 12.92F * colour[i] : 1.055F * std::pow(colour[i], 1.0F / 2.4F) - 0.055F;
    return result;
}

} // namespace

std::optional<pie::level::EntityEdit> entityEdit(const LightSource& source, const LightEdits& lights,
                                                 std::size_t number) {
    if (number >= source.imported.entities.size()) return std::nullopt;
    const pie::level::Entity& before = source.level.lightEntities[source.imported.entities[number]];
    pie::level::EntityEdit edit{before, before};
    const Light& original = lights.original(number);
    const Light& wanted = lights.light(number);
    if (const auto place = positionOf(wanted); place && place != positionOf(original))
        pie::lights::setPosition(edit.after, rounded(*place, 100));
    const float strength = strengthOf(wanted);
    const float strengthBefore = strengthOf(original);
    if (strength != strengthBefore) {
        // By ratio, so that factors of the settings stay out of the level.
        const float intensity =
            strengthBefore > 0.0F ? pie::lights::intensityOf(before) * (strength / strengthBefore) : strength;
        pie::lights::setIntensity(edit.after, rounded(intensity, 100));
    }
    if (const Rgb colour = colourOf(wanted); colour != colourOf(original)) {
        const float largest = pie::maxChannel(pie::lights::colourOf(before));
        const Rgb written = source.options.linear ? encoded(colour) : colour;
        pie::lights::setColour(edit.after, rounded(written * (largest > 0.0F ? largest : 1.0F), 1000));
    }
    return edit;
}

std::optional<Light> shownLight(const LightSource& source, const LightEdits& lights, std::size_t number) {
    if (!lights.isOn(number)) return std::nullopt;
    if (lights.isEdited(number))
        if (const auto edit = entityEdit(source, lights, number))
            if (auto light = pie::lights::lightOf(source.level, edit->after, source.options)) return light;
    return lights.light(number);
}

LightsToSave lightsToSave(const LightSource& source, const LightEdits& lights) {
    LightsToSave result;
    for (const auto& [number, edit] : lights.edits()) {
        if (!edit.on) ++result.switchedOff;
        auto change = entityEdit(source, lights, number);
        if (!change) {
            if (!sameLight(edit.light, lights.original(number))) ++result.ofShaders;
        } else if (change->before.pairs != change->after.pairs) {
            result.edits.push_back(std::move(*change));
        }
    }
    return result;
}

} // namespace pieview
