#pragma once
// What an author changes about a light entity, written as importLights() and the level compiler read it back:
// lightOf() of the changed entity is what the level will have after it is saved and loaded.

#include "pie/core/vec.h"
#include "pie/level/entities.h"

namespace pie::lights {

/// Units; 0 0 0 where the entity names none. A spot light keeps looking at its target from wherever it is moved to.
[[nodiscard]] Vec3 positionOf(const level::Entity& entity);
void setPosition(level::Entity& entity, const Vec3& position);

/// The level compiler's intensity I ("light" 300), `scale` multiplied in; never 0, which stands for 300 there.
[[nodiscard]] float intensityOf(const level::Entity& entity);
/// Finite; 0 becomes the smallest intensity that lights nothing visible (0.001). Written to the key that is read,
/// `_light` before `light`.
void setIntensity(level::Entity& entity, float intensity);

/// As the author gave it: from 0 to 1, or above for unnormalised lights. White where the entity names none.
[[nodiscard]] Rgb colourOf(const level::Entity& entity);
/// Negative and non-finite components become 0. Only the hue counts, as the compiler makes the largest component 1
/// (all but for spawnflag 32); black is white there.
void setColour(level::Entity& entity, const Rgb& colour);

} // namespace pie::lights
