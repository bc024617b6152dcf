#pragma once
// The levels that Debian ships, for tests on real data.

#include "pie/level/vfs.h"

#include <filesystem>
#include <string>
#include <vector>

namespace pie::test {

/// OpenArena's game directory, where its packages are installed: $PIE_GAME_DATA or /usr/share/games/openarena/baseoa.
struct GameData {
    std::filesystem::path folder; ///< empty: not installed
    level::Vfs files;
    std::vector<std::string> levels; ///< "maps/aggressor.bsp", sorted; 85 with all packages

    /// Opened once for the whole program.
    [[nodiscard]] static const GameData& instance();
    [[nodiscard]] bool found() const { return !levels.empty(); }
    [[nodiscard]] bool has(const std::string& level) const; ///< "aggressor"
    /// What to say when a test is skipped.
    static constexpr const char* missing =
        "needs shipped levels: apt-get install openarena-081-maps openarena-081-textures openarena-data "
        "openarena-085-data openarena-088-data openarena-oacmp1";
};

} // namespace pie::test

/// First line of a test on shipped levels.
#define PIE_NEED_GAME_DATA()                                                                                           \
    if (!::pie::test::GameData::instance().found()) GTEST_SKIP() << ::pie::test::GameData::missing
