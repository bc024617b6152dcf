#pragma once
// A small level made by the test itself: a closed box with one colour per wall, seen from inside.

#include "pie/level/bsp.h"
#include "tests/support/files.h"

#include <array>
#include <string>

namespace pie::test {

/// Walls in the order -x +x -y +y -z +z. The box is centred at the origin.
struct Room {
    float side = 512;
    std::array<std::string, 6> shaders{"textures/room/plain", "textures/room/plain", "textures/room/plain",
                                       "textures/room/plain", "textures/room/plain", "textures/room/plain"};
    /// Entity lump behind worldspawn; as it stands, a player start and one light of intensity 300.
    std::string entities = "{\n\"classname\" \"info_player_start\"\n\"origin\" \"0 -128 -64\"\n\"angle\" \"90\"\n}\n"
                           "{\n\"classname\" \"light\"\n\"origin\" \"0 0 128\"\n\"light\" \"300\"\n}\n";
};

/// As a compiler would write it: six quads with meshverts and one lightmap, all texels `lightmapByte`; a tree of one
/// node.
[[nodiscard]] level::Bsp makeRoom(const Room& room = {}, std::uint8_t lightmapByte = 64);

/// A game directory with maps/NAME.bsp and a 16×16 PNG of one colour for every texture.
void writeGame(const TemporaryFolder& folder, const std::string& name, const level::Bsp& bsp,
               const std::vector<std::pair<std::string, Rgba8>>& textures = {
                   {"textures/room/plain", {200, 200, 200, 255}}});

} // namespace pie::test
