// From text to a level: what is kept, what leaks, what a compiled file gives back, and that no light gets out.

#include "pie/brushes/compile.h"
#include "pie/photons/tracer.h"
#include "tests/brushes/make_map.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

namespace {

using namespace pie;
using namespace pie::brushes;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

level::Level loaded(const std::string& text, std::vector<std::pair<std::string, std::string>> files = {}) {
    Result<level::Level> level = test::loadMapText(text, std::move(files));
    EXPECT_TRUE(level) << (level ? "" : level.error().message());
    return level ? std::move(*level) : level::Level{};
}

const std::string scripts =
    "textures/common/caulk\n{\nsurfaceparm nodraw\n}\n"
    "textures/t/water\n{\nsurfaceparm water\nsurfaceparm trans\n{\nmap t/water.tga\nblendFunc blend\n}\n}\n"
    "textures/t/grate\n{\nsurfaceparm trans\ncull none\n{\nmap t/grate.tga\nalphaFunc GE128\n}\n}\n"
    "textures/t/fog\n{\nsurfaceparm fog\nsurfaceparm trans\nsurfaceparm nonsolid\nsurfaceparm nodraw\nfogParms ( 1 0 0 "
    ") 256\n}\n";

TEST(Compile, AClosedRoomIsItsInside) {
    const level::Level level = loaded(test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}), {0, 0, 64}));
    EXPECT_THAT(level.statistics.warnings, IsEmpty());
    EXPECT_EQ(level.statistics.drawnTriangles, 12U);
    EXPECT_DOUBLE_EQ(level.statistics.drawnArea, 2.0 * (256 * 192 + 256 * 128 + 192 * 128));
    EXPECT_EQ(level.statistics.drawnBounds.lower, Vec3(-128, -96, 0));
    EXPECT_EQ(level.statistics.drawnBounds.upper, Vec3(128, 96, 128));
    // Every normal looks into the room, every triangle runs counter-clockwise around it.
    for (std::size_t i = 0; i < level.indices.size(); i += 3) {
        const auto& a = level.vertices[level.indices[i]];
        const Vec3 n = glm::cross(level.vertices[level.indices[i + 1]].position - a.position,
                                  level.vertices[level.indices[i + 2]].position - a.position);
        EXPECT_GT(glm::dot(n, a.normal), 0);
        EXPECT_GT(glm::dot(Vec3(0, 0, 64) - a.position, a.normal), 0);
    }
    EXPECT_EQ(level.lightEntities.size(), 1U);
    EXPECT_FALSE(level.tree.nodes.empty());
}

TEST(Compile, PillarsAndDoorwaysTakeTheirShareOfTheWalls) {
    const std::string pillar = test::boxText({-16, -16, 0}, {16, 16, 128});
    const level::Level level =
        loaded(test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}) + pillar, {64, 0, 64}));
    EXPECT_DOUBLE_EQ(level.statistics.drawnArea,
                     2.0 * (256 * 192 + 256 * 128 + 192 * 128) - 2 * 32 * 32 + 4 * 32 * 128);
}

TEST(Compile, CaulkAndToolsAreNotKeptAndStillHide) {
    const std::vector<std::pair<std::string, std::string>> files{{"scripts/t.shader", scripts}};
    // A caulk block on the floor hides the floor below it and shows nothing itself; a clip brush and a hint do neither.
    const std::string blocks = test::boxText({-16, -16, 0}, {16, 16, 64}, "common/caulk") +
                               test::boxText({32, 32, 0}, {48, 48, 64}, "common/clip") +
                               test::boxText({-64, -64, 0}, {-48, -48, 64}, "common/hint");
    for (const auto& with : {files, std::vector<std::pair<std::string, std::string>>{}}) {
        const level::Level level =
            loaded(test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}) + blocks, {64, 0, 64}), with);
        EXPECT_DOUBLE_EQ(level.statistics.drawnArea, 2.0 * (256 * 192 + 256 * 128 + 192 * 128) - 32 * 32);
    }
}

TEST(Compile, WaterAndGratesHideNothingButAreCutBySolids) {
    const std::vector<std::pair<std::string, std::string>> files{{"scripts/t.shader", scripts}};
    const std::string room = test::roomText({-128, -96, 0}, {128, 96, 128});
    const double walls = 2.0 * (256 * 192 + 256 * 128 + 192 * 128);
    // A pool from wall to wall: only its surface is not against a wall.
    const level::Level pool =
        loaded(test::levelText(room + test::boxText({-128, -96, 0}, {128, 96, 32}, "t/water"), {64, 0, 64}), files);
    EXPECT_DOUBLE_EQ(pool.statistics.drawnArea, walls + 256 * 192);
    const level::Level grate =
        loaded(test::levelText(room + test::boxText({-8, -8, 0}, {8, 8, 16}, "t/grate"), {64, 0, 64}), files);
    EXPECT_DOUBLE_EQ(grate.statistics.drawnArea, walls + 5 * 256);
}

TEST(Compile, FogVolumesHoldTheFacesInThem) {
    const std::vector<std::pair<std::string, std::string>> files{{"scripts/t.shader", scripts}};
    const level::Level level = loaded(test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}) +
                                                          test::boxText({-128, -96, 0}, {0, 96, 128}, "t/fog"),
                                                      {64, 0, 64}),
                                      files);
    ASSERT_EQ(level.fogs.size(), 1U);
    EXPECT_EQ(level.fogs[0].bounds.upper.x, 0);
    // Floor, ceiling and two walls are cut in halves at the fog's border.
    double inside = 0;
    std::size_t faces = 0;
    for (const level::Surface& surface : level.surfaces) {
        faces += surface.fog == 0 ? 1 : 0;
        for (std::size_t i = surface.firstIndex; surface.fog == 0 && i < surface.firstIndex + surface.indexCount;
             i += 3) {
            const Vec3& a = level.vertices[level.indices[i]].position;
            inside += 0.5 * glm::length(glm::cross(level.vertices[level.indices[i + 1]].position - a,
                                                   level.vertices[level.indices[i + 2]].position - a));
        }
    }
    EXPECT_EQ(faces, 5U);
    EXPECT_DOUBLE_EQ(inside, 192 * 128 + 2 * 128 * 192 + 2 * 128 * 128);
}

/// Rounding of editors leaves slits between brushes; the level compiler's limit is a fifth of a unit.
TEST(Compile, SlitsOfRoundingAreNoLeaks) {
    for (const auto& [slit, leaks] : {std::pair{0.03, false}, std::pair{0.15, false}, std::pair{0.5, true}}) {
        std::string room = test::roomText({-128, -96, 0}, {128, 96, 128});
        room.erase(0, room.find("}\n") + 2); // the wall at +x is lower
        room +=
            test::boxText({128, -112, -16}, {144, 112, 128 - slit}) + test::boxText({128, -112, 128}, {144, 112, 144});
        const Result<MapText> map = parseMap(test::levelText(room, {0, 0, 64}), "x.map");
        ASSERT_TRUE(map);
        const Result<CompiledMap> compiled = compileMap(*map, "x.map", {}, level::ShaderLibrary{});
        ASSERT_TRUE(compiled);
        EXPECT_EQ(!compiled->leakPath.empty(), leaks) << slit;
    }
}

/// A wall with a glass sheet on one side is a wall, if its first side is.
TEST(Compile, TheFirstSideOfABrushSaysWhetherItSeals) {
    const std::vector<std::pair<std::string, std::string>> files{{"scripts/t.shader", scripts}};
    const std::string wall = test::boxText({128, -112, -16}, {144, 112, 144});
    for (const bool first : {true, false}) {
        std::string room = test::roomText({-128, -96, 0}, {128, 96, 128});
        room.erase(0, room.find("}\n") + 2);
        std::string mixed = wall;
        mixed.replace(first ? mixed.find("t/wall") : mixed.rfind("t/wall"), 6, "t/grate");
        const level::Location location = test::mapInMemory(test::levelText(room + mixed, {0, 0, 64}), files);
        const Result<level::Level> level = brushes::loadLevel(location);
        ASSERT_TRUE(level);
        const auto& warnings = level->statistics.warnings;
        EXPECT_EQ(std::any_of(warnings.begin(), warnings.end(),
                              [](const std::string& w) { return w.find("leaks") != std::string::npos; }),
                  first);
    }
}

TEST(Compile, ALeakIsNamedWithItsWayAndKeepsEverything) {
    std::string room = test::roomText({-128, -96, 0}, {128, 96, 128});
    room.erase(0, room.find("}\n") + 2); // without the wall at +x
    const Result<MapText> map = parseMap(test::levelText(room, {0, 0, 64}), "x.map");
    ASSERT_TRUE(map);
    const Result<CompiledMap> compiled = compileMap(*map, "x.map", {}, {});
    ASSERT_TRUE(compiled);
    EXPECT_THAT(compiled->warnings, Contains(AllOf(HasSubstr("leaks"), HasSubstr("info_player_start"))));
    ASSERT_FALSE(compiled->leakPath.empty());
    EXPECT_NEAR(compiled->leakPath.front().z, 65, 1e-9);
    EXPECT_GT(compiled->bsp.faces.size(), 5U) << "the outer faces are there";
}

TEST(Compile, BrushEntitiesBecomeModelsAtTheirOrigin) {
    const std::string door =
        test::boxText({-16, -16, 0}, {16, 16, 64}) + test::boxText({-4, -4, 0}, {4, 4, 8}, "common/origin");
    const level::Level level = loaded(
        test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}), {64, 0, 64}) +
        test::entityText({{"classname", "func_rotating"}}, door) +
        test::entityText({{"classname", "trigger_once"}}, test::boxText({60, 60, 0}, {70, 70, 8}, "common/trigger")) +
        test::entityText({{"classname", "func_group"}}, test::boxText({96, 64, 0}, {112, 80, 16})));
    ASSERT_EQ(level.models.size(), 3U) << "a group is part of the world";
    EXPECT_EQ(level.models[1].origin, Vec3(0, 0, 4));
    EXPECT_EQ(level.models[1].bounds.upper, Vec3(16, 16, 64));
    EXPECT_TRUE(level.models[1].drawn);
    EXPECT_FALSE(level.models[2].drawn);
    const double walls = 2.0 * (256 * 192 + 256 * 128 + 192 * 128);
    EXPECT_DOUBLE_EQ(level.statistics.drawnArea, walls + 2 * 32 * 32 + 4 * 32 * 64 + 4 * 16 * 16);
}

TEST(Compile, DefectsAreReportedOnceEachAndTheRestLoads) {
    const std::string bad = test::boxText({0, 0, 0}, {64, 64, 0}) + test::boxText({0, 0, 0}, {300000, 1, 1});
    const level::Level level =
        loaded(test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}) + bad, {0, 0, 64}));
    ASSERT_EQ(level.statistics.warnings.size(), 2U);
    EXPECT_THAT(level.statistics.warnings[0],
                AllOf(HasSubstr("memory/maps/made.map: line"), HasSubstr("no volume"), HasSubstr("it is left out")));
    EXPECT_THAT(level.statistics.warnings[1], HasSubstr("beyond the world"));
    EXPECT_EQ(level.statistics.drawnTriangles, 12U);
    EXPECT_THAT(level.statistics.missingTextures, Contains(HasSubstr("t/wall")));
    const Result<level::Level> none = test::loadMapText(test::entityText({{"classname", "worldspawn"}}));
    ASSERT_FALSE(none);
    EXPECT_THAT(none.error().message(), HasSubstr("no worldspawn with brushes"));
}

TEST(Compile, KeysOfLightsThatNobodyReadsAreNamedOnce) {
    const std::string odd = test::entityText({{"classname", "light"}, {"origin", "0 0 32"}, {"ligth", "300"}});
    const level::Level level =
        loaded(test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}), {0, 0, 64}) + odd + odd +
               test::entityText({{"classname", "misc_model"}, {"origin", "0 0 32"}, {"model", "x.md3"}}));
    ASSERT_EQ(level.statistics.warnings.size(), 2U);
    EXPECT_THAT(level.statistics.warnings[0], HasSubstr("key 'ligth'"));
    EXPECT_THAT(level.statistics.warnings[1], HasSubstr("the model 'x.md3' is not there"));
}

TEST(Compile, TheFileGivesBackTheSameTriangles) {
    const std::string text =
        test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}) + test::boxText({-16, -16, 0}, {16, 16, 128}),
                        {64, 0, 64}) +
        test::entityText({{"classname", "func_static"}}, test::boxText({60, 60, 10}, {70, 70, 30}));
    const level::Level direct = loaded(text);
    const Result<MapText> map = parseMap(text, "x.map");
    ASSERT_TRUE(map);
    const Result<CompiledMap> compiled = compileMap(*map, "x.map", {}, {});
    ASSERT_TRUE(compiled);
    const std::vector<std::byte> file = level::writeBsp(compiled->bsp);
    level::Location location = test::mapInMemory(text);
    location.name = "maps/made.bsp";
    const Result<level::Level> read = brushes::loadLevel(file, std::move(location));
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(read->vertices.size(), direct.vertices.size());
    for (std::size_t i = 0; i < direct.vertices.size(); ++i) {
        EXPECT_EQ(read->vertices[i].position, direct.vertices[i].position);
        EXPECT_EQ(read->vertices[i].texture, direct.vertices[i].texture);
    }
    EXPECT_EQ(read->indices, direct.indices);
    EXPECT_EQ(read->lightEntities.size(), direct.lightEntities.size());
}

TEST(Compile, BrushesInTheFileBeginWithTheirBoundsAsTheGameWants) {
    const Result<MapText> map =
        parseMap(test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}), {64, 0, 64}), "x.map");
    ASSERT_TRUE(map);
    const Result<CompiledMap> compiled = compileMap(*map, "x.map", {}, {});
    ASSERT_TRUE(compiled);
    const level::Bsp& bsp = compiled->bsp;
    for (const level::BspBrush& brush : bsp.brushes) {
        ASSERT_GE(brush.sideCount, 6);
        for (int s = 0; s < 6; ++s) {
            const auto& plane = bsp.planes[static_cast<std::size_t>(
                bsp.brushSides[static_cast<std::size_t>(brush.firstSide + s)].plane)];
            EXPECT_EQ(plane.normal[s / 2], s % 2 == 0 ? -1.0F : 1.0F);
        }
    }
    for (std::size_t i = 0; i + 1 < bsp.planes.size(); i += 2)
        EXPECT_EQ(bsp.planes[i].normal, -bsp.planes[i + 1].normal);
}

TEST(Compile, NoPhotonLeavesAClosedLevel) {
    // Turned boxes crossing walls and each other, in a room.
    std::string text = test::roomText({-256, -256, 0}, {256, 256, 192});
    for (int i = 0; i < 12; ++i) {
        const double angle = 0.5 * i;
        const glm::dmat3 rotation(glm::dvec3(std::cos(angle), std::sin(angle), 0),
                                  glm::dvec3(-std::sin(angle), std::cos(angle), 0), glm::dvec3(0, 0, 1));
        text += test::boxText({-20, -30, -8}, {20, 30, 60 + 4.0 * i}, "t/wall", rotation,
                              {-200 + 36.0 * i, 230 * std::sin(1.7 * i), 0});
    }
    const level::Level level = loaded(test::levelText(text, {0, 0, 120}));
    EXPECT_THAT(level.statistics.warnings, IsEmpty());
    const photons::TraceCounts counts = test::traceLevel(level, 200'000);
    EXPECT_EQ(counts.escaped, 0U);
    EXPECT_GT(counts.stored, 200'000U);
}

/// A pane that fills an opening: behind it, right beside the way of many photons, stand the jambs.
TEST(Compile, NoPhotonLeavesBesideAFilter) {
    const std::string filter = "textures/t/pane\n{\nsurfaceparm trans\nsurfaceparm lightfilter\ncull none\n{\nmap "
                               "t/pane.tga\nblendFunc filter\n}\n}\n";
    std::string pixel(18, '\0'); // an uncompressed TGA of one pixel
    pixel[2] = 2;
    pixel[12] = pixel[14] = 1;
    pixel[16] = 24;
    pixel += "\x90\x90\xC0";
    std::string text = test::roomText({-256, -128, 0}, {256, 128, 128});
    text += test::boxText({-8, -128, 0}, {8, -32, 128}) + test::boxText({-8, 32, 0}, {8, 128, 128}) +
            test::boxText({-8, -32, 96}, {8, 32, 128});
    text += test::boxText({-1, -32, 0}, {1, 32, 96}, "t/pane");
    const level::Level level =
        loaded(test::levelText(text, {100, 0, 64}), {{"scripts/t.shader", filter}, {"t/pane.tga", pixel}});
    const photons::TraceCounts counts = test::traceLevel(level, 1'000'000);
    EXPECT_EQ(counts.escaped, 0U);
    EXPECT_GT(counts.filtered, 100'000U);
}

} // namespace
