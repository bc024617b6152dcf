#pragma once
// Which surfaces have light of their own to be drawn with.

#include "pie/level/level.h"

namespace pie::scene {

/// Whether light reaches a surface of this shader in the game: through its lightmap, its vertex colours or the light
/// grid. A flame that is only added on top gets none.
[[nodiscard]] bool takesLight(const level::Shader& shader);

} // namespace pie::scene
