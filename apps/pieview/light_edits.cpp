#include "apps/pieview/light_edits.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace pieview {
namespace {

using namespace pie::lights;

constexpr float wattsOfIntensity = 4.0F * std::numbers::pi_v<float> * 7500.0F; // see lights::Light

/// The channels that say how bright a light is, and the unit of its strength in theirs.
template <class L> auto& channels(L& light) {
    if constexpr (std::is_same_v<std::remove_const_t<L>, AreaLight>)
        return light.radiosity;
    else if constexpr (std::is_same_v<std::remove_const_t<L>, SunLight> ||
                       std::is_same_v<std::remove_const_t<L>, SkyLight>)
        return light.irradiance;
    else
        return light.power;
}
template <class L> constexpr float unit() {
    using Kind = std::remove_const_t<L>;
    constexpr bool entity =
        std::is_same_v<Kind, PointLight> || std::is_same_v<Kind, SphereLight> || std::is_same_v<Kind, SpotLight>;
    return entity ? wattsOfIntensity : 1.0F;
}

/// Linear falloff has an intensity of its own beside the power.
void scaleLinear(Light& light, float factor) {
    std::visit(
        [factor](auto& l) {
            if constexpr (requires { l.falloff; }) l.falloff.linearIntensity *= factor;
        },
        light);
}

bool same(const Falloff& a, const Falloff& b) {
    return a.extraDistance == b.extraDistance && a.minDistance == b.minDistance && a.angleScale == b.angleScale &&
           a.noCosine == b.noCosine && a.linear == b.linear && a.linearIntensity == b.linearIntensity &&
           a.fade == b.fade;
}
bool same(const PointLight& a, const PointLight& b) {
    return a.position == b.position && a.power == b.power && same(a.falloff, b.falloff);
}
bool same(const SphereLight& a, const SphereLight& b) {
    return a.position == b.position && a.power == b.power && a.radius == b.radius && same(a.falloff, b.falloff);
}
bool same(const SpotLight& a, const SpotLight& b) {
    return a.position == b.position && a.direction == b.direction && a.power == b.power && a.slope == b.slope &&
           a.rim == b.rim && same(a.falloff, b.falloff);
}
bool same(const SunLight& a, const SunLight& b) {
    return a.towards == b.towards && a.irradiance == b.irradiance && a.devianceRadians == b.devianceRadians;
}
bool same(const AreaLight& a, const AreaLight& b) {
    return a.corners == b.corners && a.radiosity == b.radiosity && a.twoSided == b.twoSided;
}
bool same(const SkyLight& a, const SkyLight& b) { return a.towards == b.towards && a.irradiance == b.irradiance; }

} // namespace

std::optional<Vec3> positionOf(const Light& light) {
    return std::visit(
        [](const auto& l) -> std::optional<Vec3> {
            if constexpr (requires { l.position; }) {
                return l.position;
            } else if constexpr (requires { l.corners; }) {
                if (l.corners.empty()) return std::nullopt;
                Vec3 sum(0.0F);
                for (const Vec3& corner : l.corners) sum += corner;
                return sum / static_cast<float>(l.corners.size());
            } else {
                return std::nullopt;
            }
        },
        light);
}

Light movedTo(Light light, const Vec3& position) {
    const auto from = positionOf(light);
    if (!from) return light;
    std::visit(
        [&](auto& l) {
            if constexpr (requires { l.position; }) l.position = position;
            if constexpr (requires { l.corners; })
                for (Vec3& corner : l.corners) corner += position - *from;
        },
        light);
    return light;
}

float strengthOf(const Light& light) {
    return std::visit(
        [](const auto& l) { return pie::maxChannel(channels(l)) / unit<std::remove_reference_t<decltype(l)>>(); },
        light);
}

Light withStrength(Light light, float strength) {
    if (!std::isfinite(strength) || strength < 0.0F) strength = 0;
    const float before = strengthOf(light);
    const Rgb colour = colourOf(light);
    std::visit([&](auto& l) { channels(l) = colour * (strength * unit<std::remove_reference_t<decltype(l)>>()); },
               light);
    if (before > 0.0F) scaleLinear(light, strength / before);
    return light;
}

Rgb colourOf(const Light& light) {
    const Rgb c = std::visit([](const auto& l) { return channels(l); }, light);
    const float largest = pie::maxChannel(c);
    return largest > 0.0F ? c / largest : Rgb(1.0F);
}

Light withColour(Light light, Rgb colour) {
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(colour[i]) || colour[i] < 0.0F) colour[i] = 0;
    const float largest = pie::maxChannel(colour);
    colour = largest > 0.0F ? colour / largest : Rgb(1.0F);
    std::visit([&](auto& l) { channels(l) = colour * pie::maxChannel(channels(l)); }, light);
    return light;
}

bool sameLight(const Light& a, const Light& b) {
    return std::visit(
        [](const auto& x, const auto& y) {
            if constexpr (std::is_same_v<decltype(x), decltype(y)>)
                return same(x, y);
            else
                return false;
        },
        a, b);
}

const Light& LightEdits::light(std::size_t number) const {
    const auto found = edits_.find(number);
    return found == edits_.end() ? level_.at(number) : found->second.light;
}

bool LightEdits::isOn(std::size_t number) const {
    const auto found = edits_.find(number);
    return found == edits_.end() || found->second.on;
}

void LightEdits::put(std::size_t number, const LightEdit& edit) {
    if (number >= level_.size()) return;
    if (edit.on && sameLight(edit.light, level_[number]))
        edits_.erase(number);
    else
        edits_.insert_or_assign(number, edit);
    changed_.insert(number);
}

void LightEdits::set(std::size_t number, const Light& light) { put(number, {light, isOn(number)}); }

void LightEdits::setOn(std::size_t number, bool on) {
    if (isOn(number) != on) put(number, {light(number), on});
}

void LightEdits::undo(std::size_t number) {
    if (edits_.erase(number) > 0) changed_.insert(number);
}

void LightEdits::undoAll() {
    for (const auto& edit : edits_) changed_.insert(edit.first);
    edits_.clear();
}

std::vector<std::size_t> LightEdits::takeChanged() {
    std::vector<std::size_t> numbers(changed_.begin(), changed_.end());
    changed_.clear();
    return numbers;
}

void LightEdits::carryOver(std::vector<Light> level) {
    std::map<std::size_t, LightEdit> kept;
    for (const auto& [number, edit] : edits_) {
        const Light& before = level_[number];
        const auto isIt = [&](const Light& light) { return sameLight(light, before); };
        if (number < level.size() && isIt(level[number]) && !kept.contains(number)) {
            kept.emplace(number, edit);
            continue;
        }
        for (std::size_t i = 0; i < level.size(); ++i)
            if (isIt(level[i]) && !kept.contains(i)) {
                kept.emplace(i, edit);
                break;
            }
    }
    level_ = std::move(level);
    edits_ = std::move(kept);
    changed_.clear();
    for (const auto& edit : edits_) changed_.insert(edit.first);
}

} // namespace pieview
