#pragma once
// A map becomes the records of a BSP file: the same ones whether they are written to disk or shown at once, so that a
// level looks the same either way. No light is computed: surfaces are marked as lit by their vertices, white ones.

#include "pie/brushes/map_text.h"
#include "pie/level/bsp.h"
#include "pie/level/level.h"

#include <string>
#include <vector>

namespace pie::brushes {

struct CompiledMap {
    level::Bsp bsp;
    std::vector<std::string> warnings; ///< what was left out and why, one line each
    std::vector<level::StageTime> times;
    std::size_t brushes = 0, patches = 0, models = 0;
    /// From an entity through openings into the void, where the level leaks; then faces towards the void are kept.
    std::vector<glm::dvec3> leakPath;
};

/// `files` and `shaders` say what brushes are made of and how large their pictures are; both may be empty. An Error
/// only if the map has no worldspawn with a brush or patch.
[[nodiscard]] Result<CompiledMap> compileMap(const MapText& map, const std::string& fileName, const level::Vfs& files,
                                             const level::ShaderLibrary& shaders);

} // namespace pie::brushes
