#pragma once
// A second, slow renderer: rays against all triangles of a level, picture × lightmap where they meet. Shares nothing
// with the OpenSceneGraph side but the level that was loaded.

#include "pie/level/level.h"
#include "tests/osg/offscreen.h"

#include <cstdint>
#include <vector>

namespace pie::test {

struct RayPicture {
    Picture picture;
    std::vector<std::uint8_t> known; ///< per pixel: 1 where all of its rays met a lightmapped picture without script
};
/// The baked view of the level, light cut at 1 as the game in a window cuts it.
[[nodiscard]] RayPicture castPicture(const level::Level& level, const Shot& shot);

} // namespace pie::test
