#include "pie/level/level.h"
#include "tests/level/make_level.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

using namespace pie;
using namespace pie::level;
using namespace pie::test;
using testing::ElementsAre;
using testing::HasSubstr;

namespace {

Bytes colour(const Rgba8& c, int side = 2) {
    return makeTga(side, side, [=](int, int) { return c; });
}

Level load(const LevelBuilder& builder, std::vector<std::pair<std::string, Bytes>> files = {},
           const LoadOptions& options = {}) {
    Result<Level> level = loadLevel(inMemory(builder.build(), std::move(files)), options);
    EXPECT_TRUE(level) << level.error().message();
    return level ? std::move(*level) : Level{};
}

Vec3 triangleNormal(const Level& level, std::size_t first) {
    const auto at = [&](std::size_t i) { return level.vertices[level.indices[first + i]].position; };
    return glm::normalize(glm::cross(at(1) - at(0), at(2) - at(0)));
}

LevelBuilder roomBuilder() {
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    builder.room(Vec3(-128), Vec3(128), {wall, wall, wall, wall, wall, wall});
    return builder;
}

} // namespace

TEST(Load, ARoomLooksInwards) {
    const Level level = load(roomBuilder(), {{"t/wall.tga", colour({200, 100, 50, 255})}});
    EXPECT_EQ(level.name, "made");
    EXPECT_EQ(level.file, "memory/maps/made.bsp");
    EXPECT_EQ(level.surfaces.size(), 6U);
    EXPECT_EQ(level.statistics.polygons, 6U);
    EXPECT_EQ(level.statistics.drawnTriangles, 12U);
    EXPECT_DOUBLE_EQ(level.statistics.drawnArea, 6 * 256.0 * 256.0);
    EXPECT_EQ(level.statistics.drawnBounds.lower, Vec3(-128));
    EXPECT_EQ(level.statistics.drawnBounds.upper, Vec3(128));
    EXPECT_THAT(level.statistics.dialect, HasSubstr("IBSP 46"));
    EXPECT_EQ(level.statistics.lumps.size(), 17U);
    std::vector<std::string> stages;
    for (const auto& [stage, milliseconds] : level.statistics.times) stages.push_back(stage);
    EXPECT_THAT(stages, ElementsAre("file", "parse", "shaders", "surfaces", "images"));
    for (const Surface& surface : level.surfaces)
        for (std::size_t i = surface.firstIndex; i < surface.firstIndex + surface.indexCount; i += 3) {
            const Vec3 centre = level.vertices[level.indices[i]].position;
            EXPECT_LT(glm::dot(triangleNormal(level, i), centre), 0);
            EXPECT_NEAR(glm::dot(triangleNormal(level, i), level.vertices[level.indices[i]].normal), 1, 1e-6);
        }
}

TEST(Load, MeshVerticesAreHonoured) {
    LevelBuilder builder;
    // An L that a fan from its first corner would fill wrongly.
    const std::vector<Vec3> corners = {{64, 64, 0}, {0, 64, 0}, {0, 0, 0}, {128, 0, 0}, {128, 32, 0}, {64, 32, 0}};
    const auto face = static_cast<std::size_t>(builder.polygon(builder.shader("t/l"), corners));
    Bsp& bsp = builder.raw();
    bsp.meshVertices = {2, 1, 0, 2, 0, 5, 2, 5, 4, 2, 4, 3}; // clockwise from above
    bsp.faces[face].meshVertexCount = 12;
    const Level level = load(builder);
    EXPECT_DOUBLE_EQ(level.statistics.drawnArea, 64.0 * 64 + 128 * 32 - 64 * 32);
    for (std::size_t i = 0; i < level.indices.size(); i += 3) EXPECT_GT(triangleNormal(level, i).z, 0.999F);
}

TEST(Load, SubmodelsStandAtTheirEntitysOrigin) {
    LevelBuilder builder = roomBuilder();
    const int wall = builder.shader("t/wall");
    const std::vector<Vec3> square = {{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}};
    for (int i = 0; i < 6; ++i) {
        builder.submodel();
        builder.polygon(wall, square);
    }
    builder.entity({{"classname", "func_door"}, {"model", "*1"}, {"origin", "10 20 30"}});
    builder.entity({{"classname", "trigger_multiple"}, {"model", "*2"}});
    builder.entity({{"classname", "func_static"}, {"model", "*3"}, {"notfree", "1"}});
    builder.entity({{"classname", "func_static"}, {"model", "*4"}, {"gametype", "ctf oneflag"}});
    builder.entity({{"classname", "func_static"}, {"model", "*5"}, {"gametype", "ctf FFA"}});
    builder.entity({{"classname", "func_static"}, {"model", "*99"}});
    builder.entity({{"classname", "misc_model"}, {"model", "models/x.md3"}});
    const Level level = load(builder, {{"t/wall.tga", colour({1, 2, 3, 255})}});
    ASSERT_EQ(level.models.size(), 7U);
    EXPECT_TRUE(level.models[0].drawn);
    EXPECT_EQ(level.models[0].entity, -1);
    EXPECT_TRUE(level.models[1].drawn);
    EXPECT_EQ(level.models[1].entity, 1);
    EXPECT_EQ(level.models[1].origin, Vec3(10, 20, 30));
    EXPECT_EQ(level.models[1].bounds.lower, Vec3(10, 20, 30));
    EXPECT_EQ(level.models[1].bounds.upper, Vec3(18, 28, 30));
    for (const std::size_t hidden : {2U, 3U, 4U, 6U}) EXPECT_FALSE(level.models[hidden].drawn) << hidden;
    EXPECT_TRUE(level.models[5].drawn);
    const Surface& door = level.surfaces[6];
    EXPECT_EQ(door.model, 1U);
    EXPECT_EQ(level.vertices[door.firstVertex].position, Vec3(10, 20, 30));
    EXPECT_EQ(level.statistics.drawnTriangles, 12U + 2 * 2);
    EXPECT_THAT(level.statistics.warnings, ElementsAre(HasSubstr("entity 6: model '*99' is not one of the level's 7")));
}

TEST(Load, UndrawnSurfacesAreKeptButNotCounted) {
    LevelBuilder builder;
    const std::vector<Vec3> square = {{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}};
    builder.polygon(builder.shader("t/wall"), square);
    builder.polygon(builder.shader("t/wall", 0x80), square); // the same name, not drawn
    builder.polygon(builder.shader("t/sky", 0x4), square);
    builder.polygon(builder.shader("common/clip", 0, 0x10000), square);
    builder.polygon(builder.shader("common/trigger", 0, 0x40000000), square);
    BspFace flare;
    flare.type = BspFaceType::Flare;
    builder.raw().faces.push_back(flare);
    builder.raw().models[0].faceCount++;
    const Level level = load(builder, {{"t/wall.tga", colour({1, 2, 3, 255})}});
    EXPECT_EQ(level.surfaces.size(), 5U);
    EXPECT_EQ(level.statistics.flares, 1U);
    EXPECT_EQ(level.statistics.drawnTriangles, 2U);
    EXPECT_TRUE(level.shaders[level.surfaces[0].shader].drawn());
    EXPECT_FALSE(level.shaders[level.surfaces[1].shader].drawn());
    EXPECT_EQ(level.shaders[level.surfaces[1].shader].name, "t/wall");
}

TEST(Load, ScriptsWinOverImagesAndMissingPicturesAreListedOnce) {
    LevelBuilder builder;
    const std::vector<Vec3> square = {{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}};
    for (const char* name : {"t/scripted", "t/plain", "t/none", "t/none"})
        builder.polygon(builder.shader(name), square);
    builder.polygon(builder.shader("t/none", 1), square);
    const std::string script =
        "t/scripted\n{\nqer_editorimage t/editor.tga\n{\nmap t/lost.tga\n}\n{\nmap t/stage.tga\nblendfunc add\n}\n}\n";
    const Level level = load(builder, {{"scripts/a.shader", toBytes(script)},
                                       {"t/scripted.tga", colour({1, 1, 1, 255})},
                                       {"t/plain.jpg", toBytes("broken")},
                                       {"t/stage.tga", colour({9, 8, 7, 255})},
                                       {"t/editor.tga", colour({5, 5, 5, 255})}});
    EXPECT_EQ(level.shaders[level.surfaces[0].shader].origin, "scripts/a.shader:1");
    EXPECT_EQ(level.shaders[level.surfaces[1].shader].origin, "image");
    EXPECT_EQ(level.shaders[level.surfaces[2].shader].origin, "missing");
    EXPECT_THAT(level.statistics.missingTextures, ElementsAre("t/lost.tga", "t/none"));
    EXPECT_THAT(level.statistics.warnings, ElementsAre(HasSubstr("memory/t/plain.jpg: is not a readable picture")));
    ASSERT_NE(level.texture("t/stage.tga"), nullptr);
    ASSERT_NE(level.texture("t/stage.tga")->image, nullptr);
    EXPECT_EQ(level.texture("t/stage.tga")->image->pixels[0], Rgba8(9, 8, 7, 255));
    EXPECT_EQ(level.texture("t/editor.tga")->image, nullptr); // nobody looks at it
    EXPECT_EQ(level.texture("t/lost.tga")->path, "");
    EXPECT_EQ(level.texture("never/named"), nullptr);
}

TEST(Load, WithoutImagesOnlyNamesAreResolved) {
    LoadOptions options;
    options.images = false;
    const Level level = load(roomBuilder(), {{"t/wall.tga", toBytes("not even a picture")}}, options);
    ASSERT_NE(level.texture("t/wall"), nullptr);
    EXPECT_EQ(level.texture("t/wall")->path, "t/wall.tga");
    EXPECT_EQ(level.texture("t/wall")->image, nullptr);
    EXPECT_TRUE(level.statistics.warnings.empty());
}

TEST(Load, TheLightImageIsTheCompilersChoice) {
    const auto chosen = [](const std::string& body, const std::vector<std::string>& existing) {
        LevelBuilder builder;
        builder.polygon(builder.shader("t/x"), {{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}});
        std::vector<std::pair<std::string, Bytes>> files = {{"scripts/a.shader", toBytes("t/x\n{\n" + body + "\n}\n")}};
        for (const std::string& name : existing) files.emplace_back(name, colour({7, 7, 7, 255}));
        const Level level = load(builder, std::move(files));
        const Texture* texture = level.lightImage(level.shaders.at(0));
        if (texture == nullptr) return std::string("none");
        EXPECT_NE(texture->image, nullptr) << body; // what it names is decoded
        return texture->path;
    };
    const std::string all =
        "q3map_lightimage l.tga\nqer_editorimage e.tga\nskyparms env/s - -\n{\nmap $lightmap\n}\n{\nmap env.tga\ntcgen "
        "environment\nblendfunc add\n}\n{\nmap s.tga\nblendfunc filter\n}\n";
    EXPECT_EQ(chosen(all, {"l.tga", "s.tga", "env.tga", "env/s_up.tga", "e.tga", "t/x.tga"}), "l.tga");
    EXPECT_EQ(chosen(all, {"s.tga", "env.tga", "env/s_up.tga", "e.tga", "t/x.tga"}), "s.tga");
    EXPECT_EQ(chosen(all, {"env.tga", "env/s_up.tga", "e.tga", "t/x.tga"}), "env/s_up.tga");
    EXPECT_EQ(chosen(all, {"env.tga", "e.tga", "t/x.tga"}), "e.tga");
    EXPECT_EQ(chosen(all, {"t/x.tga"}), "t/x.tga");
    EXPECT_EQ(chosen(all, {}), "none");
}

TEST(Load, LightEntitiesComeFromTheLevelOrElseItsMap) {
    LevelBuilder without = roomBuilder();
    const std::string map =
        "{\n\"classname\" \"worldspawn\"\n{\n( 0 0 0 ) ( 0 0 0 ) ( 0 0 0 ) x 0 0 0 1 1 0 0 0\n}\n}\n"
        "{\n\"classname\" \"light\"\n\"origin\" \"1 2 3\"\n\"target\" \"T1\"\n}\n{\n\"classname\" "
        "\"info_null\"\n\"targetname\" \"t1\"\n}\n"
        "{\n\"classname\" \"info_null\"\n\"targetname\" \"t2\"\n}\n{\n\"classname\" \"lightJunior\"\n}\n";
    const Level fromMap = load(without, {{"maps/made.map", toBytes(map)}});
    ASSERT_EQ(fromMap.lightEntities.size(), 3U);
    EXPECT_EQ(fromMap.lightEntities[0].className(), "light");
    EXPECT_EQ(fromMap.lightEntities[1].className(), "lightJunior");
    EXPECT_EQ(fromMap.lightEntities[2].value("targetname"), "t1");
    EXPECT_EQ(fromMap.lightEntitySource, "maps/made.map");
    EXPECT_EQ(fromMap.entities.size(), 1U);

    LevelBuilder with = roomBuilder();
    with.entity({{"classname", "light"}, {"origin", "5 5 5"}});
    const Level own = load(with, {{"maps/made.map", toBytes(map)}});
    ASSERT_EQ(own.lightEntities.size(), 1U);
    EXPECT_EQ(own.lightEntitySource, "maps/made.bsp");

    const Level none = load(without);
    EXPECT_TRUE(none.lightEntities.empty());
    EXPECT_EQ(none.lightEntitySource, "");
    // None of them is a .map on disk.
    EXPECT_THAT(own.lightEntityFile().error().message(), HasSubstr("is compiled"));
    EXPECT_THAT(fromMap.lightEntityFile().error().message(), HasSubstr("is not a file of its own"));
    EXPECT_THAT(none.lightEntityFile().error().message(), HasSubstr("has no light entities"));
    const Level broken = load(without, {{"maps/made.map", toBytes("{ \"a\"")}});
    EXPECT_THAT(broken.statistics.warnings, testing::Contains(HasSubstr("memory/maps/made.map: map, line 1")));
}

TEST(Load, TheFirstViewIsAPlayersEye) {
    LevelBuilder builder = roomBuilder();
    builder.entity({{"classname", "info_player_intermission"}, {"origin", "9 9 9"}});
    builder.entity({{"classname", "team_CTF_redspawn"}, {"origin", "8 8 8"}, {"angle", "45"}});
    const Level::View ctf = load(builder).firstView();
    EXPECT_EQ(ctf.eye, Vec3(8, 8, 43));
    EXPECT_EQ(ctf.yaw, 45);
    builder.entity({{"classname", "info_player_start"}, {"origin", "1 2 3"}, {"angles", "0 135 0"}});
    builder.entity({{"classname", "info_player_deathmatch"}, {"origin", "4 5 6"}, {"angle", "90"}});
    const Level::View first = load(builder).firstView();
    EXPECT_EQ(first.eye, Vec3(1, 2, 38));
    EXPECT_EQ(first.yaw, 135);
    const Level::View inside = load(roomBuilder()).firstView();
    EXPECT_EQ(inside.eye, Vec3(0));
    EXPECT_EQ(inside.yaw, 0);
}

TEST(Load, FogVolumesHaveTheirBrushsBounds) {
    LevelBuilder builder = roomBuilder();
    const int fogShader = builder.shader("t/fog", 0, 0x40);
    builder.effect("t/fog", builder.brush(fogShader, {-64, -32, -16}, {64, 32, 16}), 5);
    builder.effect("t/unknown", -1, -1);
    builder.raw().faces[2].effect = 0;
    const Level level =
        load(builder, {{"scripts/f.shader", toBytes("t/fog\n{\nsurfaceparm fog\nfogparms ( .5 .25 1 ) 320\n}\n")},
                       {"t/wall.tga", colour({1, 2, 3, 255})}});
    ASSERT_EQ(level.fogs.size(), 2U);
    EXPECT_EQ(level.fogs[0].bounds.lower, Vec3(-64, -32, -16));
    EXPECT_EQ(level.fogs[0].bounds.upper, Vec3(64, 32, 16));
    EXPECT_EQ(level.fogs[0].keys.colour, Rgb(.5F, .25F, 1));
    EXPECT_EQ(level.fogs[0].keys.opaqueDistance, 320);
    ASSERT_TRUE(level.fogs[0].visiblePlane);
    EXPECT_EQ(level.fogs[0].visiblePlane->normal, Vec3(0, 0, 1));
    EXPECT_EQ(level.fogs[0].visiblePlane->distance, 16);
    EXPECT_EQ(level.fogs[1].bounds.upper, Vec3(128)); // the whole level
    EXPECT_FALSE(level.fogs[1].visiblePlane);
    EXPECT_EQ(level.surfaces[2].fog, 0);
    EXPECT_EQ(level.surfaces[1].fog, -1);
    EXPECT_THAT(level.statistics.warnings, ElementsAre(HasSubstr("fog shader 't/unknown' has no fogParms")));
}

TEST(Load, TheTreeFindsLeaves) {
    const Level level = load(roomBuilder());
    ASSERT_EQ(level.tree.leaves.size(), 2U);
    EXPECT_EQ(level.tree.leafAt({0, 0, 0}), 0U);
    EXPECT_EQ(level.tree.leafAt({0, 0, -500}), 1U);
    EXPECT_EQ(Tree{}.leafAt({0, 0, 0}), 0U);
}

TEST(Load, PatchesBecomeSurfaces) {
    LevelBuilder builder;
    builder.patch(builder.shader("t/wall"), 3, 3,
                  controlGrid(3, 3, 64, [](int c, int) { return c == 1 ? 64.0F : 0.0F; }));
    const Level level = load(builder, {{"t/wall.tga", colour({1, 2, 3, 255})}});
    ASSERT_EQ(level.surfaces.size(), 1U);
    EXPECT_EQ(level.surfaces[0].kind, SurfaceKind::Patch);
    EXPECT_GT(level.statistics.drawnTriangles, 2U);
    for (std::size_t i = 0; i < level.indices.size(); i += 3) EXPECT_GT(triangleNormal(level, i).z, 0);
    for (const Vertex& v : level.vertices) EXPECT_EQ(v.colour, Rgba8(255));
}

TEST(Load, BytesAndLocationGiveTheSame) {
    const Bsp bsp = roomBuilder().build();
    const std::vector<std::byte> bytes = writeBsp(bsp);
    Location location;
    location.name = "maps/stream.bsp";
    const Result<Level> level = loadLevel(bytes, std::move(location));
    ASSERT_TRUE(level);
    EXPECT_EQ(level->name, "stream");
    EXPECT_EQ(level->file, "maps/stream.bsp");
    EXPECT_EQ(level->surfaces.size(), 6U);
    Location absent;
    absent.name = "maps/none.bsp";
    EXPECT_EQ(loadLevel(std::move(absent)).error().message(),
              "maps/none.bsp: no such file in the folders and pk3 files of the level");
}

TEST(Load, DamagedEntitiesAreAnError) {
    LevelBuilder builder = roomBuilder();
    builder.raw().entities += "{ \"classname\"";
    const Result<Level> level = loadLevel(inMemory(builder.build()));
    ASSERT_FALSE(level);
    EXPECT_THAT(level.error().message(),
                HasSubstr("memory/maps/made.bsp: lump entities, line 4, column 3: the key 'classname' has no value"));
}
