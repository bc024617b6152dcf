#include "tests/support/game_data.h"

#include <algorithm>
#include <cstdlib>

namespace pie::test {
namespace {

GameData open() {
    GameData data;
    const char* const wanted = std::getenv("PIE_GAME_DATA");
    const std::filesystem::path folder =
        wanted != nullptr && *wanted != '\0' ? wanted : "/usr/share/games/openarena/baseoa";
    std::error_code absent;
    if (!std::filesystem::is_directory(folder, absent) || !data.files.mountGame(folder)) return data;
    data.folder = folder;
    data.levels = data.files.list("maps", ".bsp");
    return data;
}

} // namespace

const GameData& GameData::instance() {
    static const GameData data = open();
    return data;
}

bool GameData::has(const std::string& level) const {
    return std::binary_search(levels.begin(), levels.end(), "maps/" + level + ".bsp");
}

} // namespace pie::test
