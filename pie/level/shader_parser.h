#pragma once
// One definition of a shader script, from behind its '{'.

#include "pie/level/shader.h"

#include <string>
#include <string_view>

namespace pie::level {

inline constexpr float sortPortal = 1, sortSky = 2, sortOpaque = 3, sortDecal = 4, sortSeeThrough = 5, sortBanner = 6,
                       sortFog = 7, sortUnderwater = 8, sortBlend = 9, sortAdditive = 10, sortNearest = 16;

/// `text` starts behind the '{', in line `line` of `fileName`. What the game would refuse is kept as far as it was
/// understood and told in `Shader::defects`. The origin is left to the caller.
[[nodiscard]] Shader parseShader(std::string name, std::string_view text, const std::string& fileName, int line);

} // namespace pie::level
