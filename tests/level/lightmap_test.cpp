#include "pie/level/level.h"
#include "tests/level/make_level.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

using namespace pie;
using namespace pie::level;
using namespace pie::test;

namespace {

const std::vector<Vec3> square = {{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}};

/// One face for each of these lightmap numbers.
LevelBuilder facesWith(const std::vector<int>& lightmaps, const Pairs& worldspawn = {}) {
    LevelBuilder builder(worldspawn);
    for (const int lightmap : lightmaps) builder.polygon(builder.shader("t/wall"), square, lightmap);
    return builder;
}

BspLightmap lightPage(std::uint8_t value) {
    BspLightmap page;
    page.fill(value);
    return page;
}

BspLightmap directionPage() {
    BspLightmap page{};
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    for (std::size_t i = 0; i + 2 < page.size(); i += 3) {
        const Vec3 v = glm::normalize(Vec3(normal(random), normal(random), normal(random)));
        for (int k = 0; k < 3; ++k)
            page[i + static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(v[k] * 127.5F + 127.5F);
    }
    return page;
}

Level load(const LevelBuilder& builder, std::vector<std::pair<std::string, Bytes>> files = {},
           const LoadOptions& options = {}) {
    Result<Level> level = loadLevel(inMemory(builder.build(), std::move(files)), options);
    EXPECT_TRUE(level) << level.error().message();
    return level ? std::move(*level) : Level{};
}

std::vector<std::int32_t> numbers(const Level& level) {
    std::vector<std::int32_t> result;
    for (const Surface& surface : level.surfaces) result.push_back(surface.lightmap);
    return result;
}

using testing::ElementsAre;
using testing::HasSubstr;

} // namespace

TEST(Lightmaps, PlainPagesAreKeptAsTheyAre) {
    LevelBuilder builder = facesWith({0, 1, 2, -1, -2, -3, -4});
    for (const int value : {10, 20, 30}) builder.raw().lightmaps.push_back(lightPage(static_cast<std::uint8_t>(value)));
    const Level level = load(builder);
    EXPECT_THAT(numbers(level), ElementsAre(0, 1, 2, noLightmap, noLightmap, vertexLit, noLightmap));
    ASSERT_EQ(level.lightmaps.size(), 3U);
    EXPECT_EQ(level.lightmaps[1].rgb.size(), 128U * 128 * 3);
    EXPECT_EQ(level.lightmaps[1].rgb[77], 20);
    EXPECT_FALSE(level.lightmaps[1].external);
}

TEST(Lightmaps, DeluxePagesAreLeftOut) {
    LevelBuilder builder = facesWith({0, 2, 2});
    builder.raw().lightmaps = {lightPage(10), directionPage(), lightPage(30), directionPage()};
    const Level level = load(builder);
    EXPECT_THAT(numbers(level), ElementsAre(0, 1, 1));
    ASSERT_EQ(level.lightmaps.size(), 2U);
    EXPECT_EQ(level.lightmaps[1].rgb[0], 30);
    LoadOptions plain;
    plain.deluxe = false;
    EXPECT_EQ(load(builder, {}, plain).lightmaps.size(), 4U);
}

TEST(Lightmaps, OddNumbersOrOrdinaryPagesAreNotDeluxe) {
    LevelBuilder odd = facesWith({0, 1});
    odd.raw().lightmaps = {lightPage(10), directionPage()};
    EXPECT_EQ(load(odd).lightmaps.size(), 2U);
    // Only page 0 is used, as in a small level, and page 1 is light.
    LevelBuilder unused = facesWith({0});
    unused.raw().lightmaps = {lightPage(10), lightPage(90)};
    EXPECT_EQ(load(unused).lightmaps.size(), 2U);
    LevelBuilder one = facesWith({0});
    one.raw().lightmaps = {lightPage(10)};
    EXPECT_EQ(load(one).lightmaps.size(), 1U);
}

TEST(Lightmaps, TheWorldsKeySaysDeluxeEvenWhereAllIsBlack) {
    LevelBuilder builder = facesWith({0}, {{"deluxeMapping", "1"}});
    builder.raw().lightmaps = {lightPage(10), lightPage(90)};
    EXPECT_EQ(load(builder).lightmaps.size(), 1U);
}

TEST(Lightmaps, ExternalPagesLieBesideTheLevel) {
    const LevelBuilder builder = facesWith({0, 1, 3, -3});
    const auto page = [](int side, std::uint8_t value) {
        return makeTga(side, side, [=](int, int) { return Rgba8(value, value, value, 255); });
    };
    const Level level =
        load(builder, {{"maps/made/lm_0000.tga", page(64, 11)}, {"maps/made/lm_0001.tga", page(256, 22)}});
    EXPECT_THAT(numbers(level), ElementsAre(0, 1, vertexLit, vertexLit));
    ASSERT_GE(level.lightmaps.size(), 2U);
    EXPECT_TRUE(level.lightmaps[1].external);
    EXPECT_EQ(level.lightmaps[0].width, 64);
    EXPECT_EQ(level.lightmaps[1].width, 256);
    EXPECT_EQ(level.lightmaps[1].rgb.size(), 256U * 256 * 3);
    EXPECT_EQ(level.lightmaps[1].rgb[5], 22);
    EXPECT_EQ(level.lightmaps[1].name, "maps/made/lm_0001.tga");
    EXPECT_THAT(level.statistics.warnings,
                ElementsAre(HasSubstr("external lightmap maps/made/lm_0003.tga is missing")));
}

TEST(Lightmaps, ScriptsMayNameExternalPages) {
    LevelBuilder builder;
    builder.polygon(builder.shader("made/generated"), square, -3);
    const std::string script = "made/generated\n{\n{\nmap maps/made/lm_0007.tga\nrgbGen identity\ntcGen "
                               "lightmap\n}\n{\nmap t/wall.tga\nblendfunc filter\n}\n}\n";
    const Bytes page = makeTga(32, 32, [](int, int) { return Rgba8(5, 6, 7, 255); });
    const Level level =
        load(builder,
             {{"scripts/q3map2_made.shader", toBytes(script)}, {"maps/made/lm_0007.tga", page}, {"t/wall.tga", page}});
    EXPECT_THAT(numbers(level), ElementsAre(0));
    ASSERT_EQ(level.lightmaps.size(), 1U);
    EXPECT_EQ(level.lightmaps[0].rgb[1], 6);
    EXPECT_EQ(level.shaders[0].stages[0].source, Stage::Source::Lightmap);
    EXPECT_TRUE(level.statistics.missingTextures.empty());
}
