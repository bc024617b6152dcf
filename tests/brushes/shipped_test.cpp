// Maps that Debian's source package openarena-088-data holds, where $PIE_MAP_SOURCES names the folder with them:
// apt-get source --download-only openarena-088-data, unpacked.

#include "tests/brushes/make_map.h"
#include "tests/support/game_data.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace {

using namespace pie;
namespace fs = std::filesystem;

std::vector<fs::path> mapSources() {
    std::vector<fs::path> maps;
    const char* folder = std::getenv("PIE_MAP_SOURCES");
    if (folder == nullptr) return maps;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.path().extension() == ".map") maps.push_back(entry.path());
    std::sort(maps.begin(), maps.end());
    return maps;
}

std::string textOf(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

Result<level::Level> loadWithGame(const std::string& text) {
    level::Location location = test::mapInMemory(text);
    level::Vfs files = test::GameData::instance().files;
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    files.mountMemory("memory", {{"maps/made.map", level::Bytes(first, first + text.size())}});
    location.files = std::move(files);
    level::LoadOptions options;
    options.images = false;
    return brushes::loadLevel(std::move(location), options);
}

#define PIE_NEED_MAPS()                                                                                                \
    PIE_NEED_GAME_DATA();                                                                                              \
    const std::vector<fs::path> maps = mapSources();                                                                   \
    if (maps.empty()) GTEST_SKIP() << "needs $PIE_MAP_SOURCES: .map files of the source package openarena-088-data"

/// A reading of its own: entity blocks at depth one, class names that start with "light".
std::size_t lightsByPlainReading(const std::string& text) {
    std::istringstream lines(text);
    std::size_t lights = 0;
    for (std::string line; std::getline(lines, line);)
        if (line.find("\"classname\"") != std::string::npos && line.find("\"light") != std::string::npos) ++lights;
    return lights;
}

TEST(MapSources, EveryOneLoadsWithTheLightsOfItsText) {
    PIE_NEED_MAPS();
    for (const fs::path& file : maps) {
        SCOPED_TRACE(file.filename().string());
        const std::string text = textOf(file);
        const auto level = loadWithGame(text);
        ASSERT_TRUE(level) << level.error().message();
        std::size_t lights = 0;
        for (const level::Entity& entity : level->lightEntities)
            lights += entity.className().starts_with("light") ? 1 : 0;
        EXPECT_EQ(lights, lightsByPlainReading(text));
    }
}

TEST(MapSources, NoPhotonLeavesOaDm1) {
    PIE_NEED_MAPS();
    for (const fs::path& file : maps) {
        if (file.filename() != "oa_dm1.map") continue;
        const auto level = loadWithGame(textOf(file));
        ASSERT_TRUE(level);
        const photons::TraceCounts counts = test::traceLevel(*level, 1'000'000);
        EXPECT_EQ(counts.escaped, 0U) << "of " << counts.rays << " rays";
        return;
    }
    GTEST_SKIP() << "no oa_dm1.map among the sources";
}

} // namespace
