#pragma once
// What the user has done to the lights of a level: which are changed and how, which are switched off. Numbers are those
// of pie::engine::Engine::lights(). Made from the level's lights; each change is told to the engine by whoever asks
// takeChanged().

#include "pie/core/vec.h"
#include "pie/lights/light.h"

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace pieview {

using pie::Rgb;
using pie::Vec3;
using pie::lights::Light;

/// Where a light is; suns and skies are nowhere. An area light is in its middle.
[[nodiscard]] std::optional<Vec3> positionOf(const Light& light);
[[nodiscard]] Light movedTo(Light light, const Vec3& position);
/// Largest channel: of point, sphere and spot lights the intensity of a light entity (its `light` key), of area lights
/// radiosity, of suns and skies irradiance, both in lightmap units U.
[[nodiscard]] float strengthOf(const Light& light);
[[nodiscard]] Light withStrength(Light light, float strength);
/// Largest channel 1; white for a light without power.
[[nodiscard]] Rgb colourOf(const Light& light);
/// Keeps the strength. Negative and not finite channels count as 0; a colour without any is white.
[[nodiscard]] Light withColour(Light light, Rgb colour);
/// Bit for bit the same.
[[nodiscard]] bool sameLight(const Light& a, const Light& b);

struct LightEdit {
    Light light;
    bool on = true;
};

class LightEdits {
public:
    LightEdits() = default;
    explicit LightEdits(std::vector<Light> level) : level_(std::move(level)) {}

    [[nodiscard]] std::size_t size() const { return level_.size(); }
    /// As in the level.
    [[nodiscard]] const Light& original(std::size_t number) const { return level_.at(number); }
    /// As it is to be, on or off.
    [[nodiscard]] const Light& light(std::size_t number) const;
    [[nodiscard]] bool isOn(std::size_t number) const;
    [[nodiscard]] bool isEdited(std::size_t number) const { return edits_.contains(number); }
    /// All that differs from the level, by number.
    [[nodiscard]] const std::map<std::size_t, LightEdit>& edits() const { return edits_; }

    void set(std::size_t number, const Light& light);
    void setOn(std::size_t number, bool on);
    void undo(std::size_t number);
    void undoAll();
    /// Numbers whose light is another since the last call, in order.
    [[nodiscard]] std::vector<std::size_t> takeChanged();

    /// The level was read again. An edit stays with the light that is as it was before, whatever its number now; where
    /// there is none the level wins, and the edit is gone. All that is left counts as changed.
    void carryOver(std::vector<Light> level);

private:
    void put(std::size_t number, const LightEdit& edit);
    std::vector<Light> level_;
    std::map<std::size_t, LightEdit> edits_;
    std::set<std::size_t> changed_;
};

} // namespace pieview
