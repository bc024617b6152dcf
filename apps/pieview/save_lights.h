#pragma once
// Edited lights in the level's text. An edit of a light entity is an edit of its keys, and the light that is shown is
// imported from the edited entity: what is seen while a light is dragged is what the level has once it is saved.

#include "apps/pieview/light_edits.h"
#include "pie/level/entity_text.h"
#include "pie/level/level.h"
#include "pie/lights/import.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace pieview {

/// What lights are made from.
struct LightSource {
    const pie::level::Level& level;
    const pie::lights::ImportedLights& imported;
    pie::lights::ImportOptions options;
};

/// The light entity as it is and as the edit wants it: places to 1/100 unit, strengths to 1/100, colours to 1/1000. Off
/// is no key of the game, so a switched-off light is written as it is. Nothing for lights that are no entities.
[[nodiscard]] std::optional<pie::level::EntityEdit> entityEdit(const LightSource& source, const LightEdits& lights,
                                                               std::size_t number);
/// The light as the edited level would have it; nullopt: off.
[[nodiscard]] std::optional<Light> shownLight(const LightSource& source, const LightEdits& lights, std::size_t number);

struct LightsToSave {
    std::vector<pie::level::EntityEdit> edits; ///< those that change anything
    std::size_t ofShaders = 0;                 ///< edited, but no entities: their light is in shader scripts
    std::size_t switchedOff = 0;
};
[[nodiscard]] LightsToSave lightsToSave(const LightSource& source, const LightEdits& lights);

} // namespace pieview
