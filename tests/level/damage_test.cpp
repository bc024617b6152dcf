// Files damaged in every way that can be thought of: never a crash, always one line that says what is wrong.

#include "pie/level/bsp.h"
#include "pie/level/level.h"
#include "tests/level/make_level.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

using namespace pie;
using namespace pie::level;
using namespace pie::test;

namespace {

std::vector<std::byte> victim() {
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    builder.room(Vec3(-256), Vec3(256), {wall, wall, wall, wall, wall, wall}, 0);
    builder.patch(wall, 7, 7, controlGrid(7, 7, 30, [](int c, int) { return 25.0F * static_cast<float>(c % 3); }), 1);
    builder.effect("t/fog", builder.brush(builder.shader("t/fog", 0, 0x40), Vec3(-64), Vec3(64)), 5);
    builder.submodel();
    builder.polygon(wall, {{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}});
    builder.entity({{"classname", "func_door"}, {"model", "*1"}, {"origin", "1 2 3"}});
    builder.entity({{"classname", "info_player_deathmatch"}, {"origin", "0 0 0"}});
    builder.entity({{"classname", "light"}, {"origin", "0 0 64"}, {"light", "300"}});
    builder.raw().lightmaps.resize(2);
    builder.raw().visibility = {2, 1, {3, 3}};
    return writeBsp(builder.build());
}

/// Loads the bytes through the whole of pie/level. A level that comes out must be sound; else there is one line.
void load(const std::vector<std::byte>& bytes, const std::string& what) {
    Location location;
    location.name = "maps/damaged.bsp";
    location.files.mountMemory("memory", {{"t/wall.tga", makeTga(2, 2, [](int, int) { return Rgba8(128); })}});
    const Result<Level> level = loadLevel(bytes, std::move(location));
    if (!level) {
        const std::string message = level.error().message();
        EXPECT_EQ(message.find("maps/damaged.bsp: "), 0U) << what << ": " << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << what << ": " << message;
        EXPECT_GT(message.size(), 25U) << what;
        return;
    }
    for (const std::uint32_t index : level->indices) ASSERT_LT(index, level->vertices.size()) << what;
    for (const Surface& surface : level->surfaces) {
        ASSERT_LT(surface.shader, level->shaders.size()) << what;
        ASSERT_LT(surface.model, level->models.size()) << what;
        ASSERT_LT(surface.fog, static_cast<std::int32_t>(level->fogs.size())) << what;
        ASSERT_LT(surface.lightmap, static_cast<std::int32_t>(level->lightmaps.size())) << what;
        ASSERT_LE(surface.firstIndex + surface.indexCount, level->indices.size()) << what;
    }
    for (const Vertex& v : level->vertices) {
        ASSERT_TRUE(std::isfinite(v.position.x) && std::isfinite(v.position.y) && std::isfinite(v.position.z)) << what;
        ASSERT_NEAR(glm::length(v.normal), 1, 1e-3) << what;
        ASSERT_TRUE(std::isfinite(v.lightmap.x + v.lightmap.y) || std::abs(v.lightmap.x) > 1e37F ||
                    std::abs(v.lightmap.y) > 1e37F)
            << what;
    }
    if (!level->tree.leaves.empty()) {
        ASSERT_LT(level->tree.leafAt(Vec3(1, 2, 3)), level->tree.leaves.size()) << what;
    }
    (void)level->firstView();
}

} // namespace

TEST(Damage, TheVictimItselfLoads) {
    Location location;
    location.name = "maps/damaged.bsp";
    const Result<Level> level = loadLevel(victim(), std::move(location));
    ASSERT_TRUE(level) << level.error().message();
    EXPECT_EQ(level->surfaces.size(), 8U);
}

TEST(Damage, TruncatedAtEveryLumpBoundary) {
    const std::vector<std::byte> good = victim();
    for (std::size_t lump = 0; lump < lumpCount; ++lump) {
        std::int32_t offset = 0;
        std::int32_t length = 0;
        std::memcpy(&offset, good.data() + 8 + 8 * lump, 4);
        std::memcpy(&length, good.data() + 12 + 8 * lump, 4);
        for (const std::int32_t cut : {offset - 1, offset, offset + 1, offset + length - 1}) {
            if (length == 0 || cut < 0) continue;
            const std::vector<std::byte> bytes(good.begin(), good.begin() + cut);
            EXPECT_FALSE(readBsp(bytes, "x.bsp")) << "cut at " << cut << " in lump " << lump;
            load(bytes, "cut at " + std::to_string(cut));
        }
    }
}

TEST(Damage, TruncatedAnywhere) {
    const std::vector<std::byte> good = victim();
    std::mt19937 random(1);
    for (std::size_t cut = 0; cut < 400; ++cut)
        load({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(cut)}, "cut");
    for (int i = 0; i < 300; ++i)
        load({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(random() % good.size())}, "random cut");
}

TEST(Damage, FlippedBits) {
    const std::vector<std::byte> good = victim();
    std::mt19937 random(2);
    // The lightmaps are most of the file and hold nothing to break: spare them most of the hits.
    const std::size_t meat = good.size() - 2 * sizeof(BspLightmap) - 64;
    for (int i = 0; i < 1500; ++i) {
        std::vector<std::byte> bytes = good;
        const int flips = 1 + static_cast<int>(random() % 4);
        for (int k = 0; k < flips; ++k) bytes[random() % meat] ^= static_cast<std::byte>(1U << (random() % 8));
        load(bytes, "flip " + std::to_string(i));
    }
}

TEST(Damage, WordsReplaced) {
    const std::vector<std::byte> good = victim();
    std::mt19937 random(3);
    const std::size_t meat = good.size() - 2 * sizeof(BspLightmap) - 64;
    const std::int32_t interesting[] = {
        -1, 0, 1, 2, 255, 65535, 0x7fffffff, -0x7fffffff - 1, 0x7f800000, 0x7fc00000, 0x00000001, 0x7f7fffff};
    for (int i = 0; i < 1500; ++i) {
        std::vector<std::byte> bytes = good;
        const std::int32_t value = interesting[random() % std::size(interesting)];
        std::memcpy(bytes.data() + 4 * (2 + random() % (meat / 4 - 2)), &value, sizeof value);
        load(bytes, "word " + std::to_string(i));
    }
}

TEST(Damage, BytesThatAreNoLevelAtAll) {
    std::mt19937 random(4);
    for (int i = 0; i < 200; ++i) {
        std::vector<std::byte> bytes(random() % 2000);
        for (std::byte& b : bytes) b = static_cast<std::byte>(random() % 256);
        if (i % 2 == 0 && bytes.size() >= 8) {
            const std::int32_t version = 46;
            std::memcpy(bytes.data(), "IBSP", 4);
            std::memcpy(bytes.data() + 4, &version, 4);
        }
        load(bytes, "noise");
    }
}

TEST(Damage, ScriptsOfNoiseDoNoHarm) {
    std::mt19937 random(5);
    const char* const pieces[] = {"{",
                                  "}",
                                  "\n",
                                  "map ",
                                  "$lightmap",
                                  "blendfunc ",
                                  "( 1 2 ",
                                  "tcMod ",
                                  "surfaceparm ",
                                  "\"",
                                  "/*",
                                  "*/",
                                  "//",
                                  "skyparms ",
                                  "q3map_sun ",
                                  "-1e30 ",
                                  "nan ",
                                  "rgbGen wave ",
                                  "animMap ",
                                  "x ",
                                  "t/wall ",
                                  "deformVertexes ",
                                  "q3map_skylight "};
    for (int i = 0; i < 500; ++i) {
        std::string text = "t/wall\n{\n";
        for (std::size_t k = random() % 60; k > 0; --k) text += pieces[random() % std::size(pieces)];
        ShaderLibrary library;
        library.parse(text, "noise.shader");
        for (const std::string& name : library.names()) {
            const Shader* shader = library.find(name);
            ASSERT_NE(shader, nullptr);
            EXPECT_LE(shader->stages.size(), 8U);
            EXPECT_TRUE(shader->sort.has_value());
        }
    }
}
