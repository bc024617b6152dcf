#include "pie/level/bsp.h"
#include "tests/level/make_level.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

using namespace pie;
using namespace pie::level;
using namespace pie::test;

namespace {

/// A level with at least one record in every lump.
Bsp full() {
    LevelBuilder builder;
    const int wall = builder.shader("textures/wall");
    builder.room(Vec3(-256), Vec3(256), {wall, wall, wall, wall, wall, wall}, 0);
    builder.patch(wall, 5, 3, controlGrid(5, 3, 20, [](int c, int) { return 10.0F * static_cast<float>(c % 2); }), 0);
    const int fog = builder.brush(builder.shader("textures/fog", 0, 0x40), Vec3(-64), Vec3(64));
    builder.effect("textures/fog", fog, 5);
    builder.raw().faces.front().effect = 0;
    builder.submodel();
    builder.polygon(wall, {{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}, {-4, 4, 0}}, 0);
    builder.raw().lightmaps.resize(1);
    for (std::size_t i = 0; i < builder.raw().lightmaps[0].size(); ++i)
        builder.raw().lightmaps[0][i] = static_cast<std::uint8_t>(i);
    builder.raw().lightVolumes.push_back({{1, 2, 3}, {4, 5, 6}, {7, 8}});
    builder.raw().visibility = {9, 2, std::vector<std::uint8_t>(18, 0xff)};
    return builder.build();
}

std::string failure(const std::vector<std::byte>& bytes) {
    const Result<Bsp> bsp = readBsp(bytes, "x.bsp");
    EXPECT_FALSE(bsp) << "was accepted";
    if (bsp) return {};
    std::string message = bsp.error().message();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
}

/// The message for a level with one thing changed.
std::string failureOf(const std::function<void(Bsp&)>& change) {
    Bsp bsp = full();
    change(bsp);
    return failure(writeBsp(bsp));
}

std::vector<std::byte> header(const char* magic, std::int32_t version) {
    std::vector<std::byte> bytes(1024);
    std::memcpy(bytes.data(), magic, 4);
    std::memcpy(bytes.data() + 4, &version, 4);
    return bytes;
}

} // namespace

TEST(Bsp, WritingAndReadingGivesTheSameBytesAgain) {
    const std::vector<std::byte> bytes = writeBsp(full());
    const Result<Bsp> read = readBsp(bytes, "x.bsp");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(writeBsp(*read), bytes);
    EXPECT_EQ(read->faces.size(), 8U);
    EXPECT_EQ(read->shaders[0].name, "textures/wall");
    EXPECT_EQ(read->faces[6].type, BspFaceType::Patch);
    EXPECT_EQ(read->faces[6].patchSize, (std::array<std::int32_t, 2>{5, 3}));
    EXPECT_EQ(read->faces[0].lightmap, 0);
    EXPECT_EQ(read->effects[0].visibleSide, 5);
    EXPECT_EQ(read->lightmaps[0][300], static_cast<std::uint8_t>(300));
    EXPECT_EQ(read->lightVolumes[0].directed[2], 6);
    EXPECT_EQ(read->visibility.clusterCount, 9);
    EXPECT_EQ(read->models[1].faceCount, 1);
    EXPECT_EQ(read->vertices[0].colour, Rgba8(255));
    EXPECT_EQ(read->entities, full().entities);
}

TEST(Bsp, DialectsAreRecognisedAndNamed) {
    const auto check = [](const std::vector<std::byte>& bytes, Format format, const std::string& name) {
        EXPECT_EQ(recognise(bytes), format) << name;
        EXPECT_NE(dialect(bytes).find(name), std::string::npos) << dialect(bytes);
        if (format == Format::Quake3) return;
        const std::string message = failure(bytes);
        EXPECT_EQ(message.find("x.bsp: is not a Quake 3 level (IBSP 46) but "), 0U) << message;
        EXPECT_NE(message.find(name), std::string::npos) << message;
    };
    check(writeBsp(full()), Format::Quake3, "IBSP 46 (Quake 3)");
    check(header("IBSP", 47), Format::QuakeLiveOrWolfenstein, "IBSP 47 (Return to Castle Wolfenstein");
    check(header("IBSP", 38), Format::Quake2, "IBSP 38 (Quake 2)");
    check(header("IBSP", 99), Format::Unknown, "IBSP 99 (an unknown version)");
    check(header("RBSP", 1), Format::Raven, "RBSP 1 (Raven");
    check(header("FBSP", 1), Format::Fusion, "FBSP 1 (Fusion");
    check(header("VBSP", 20), Format::Source, "VBSP 20 (Valve Source)");
    check(header("\x1d\0\0\0", 0), Format::Quake1, "BSP 29 (Quake)");
    check(header("\x1e\0\0\0", 0), Format::Quake1, "BSP 30 (Half-Life)");
    check(header("BSP2", 0), Format::Quake1, "BSP2 (Quake)");
    check(header("PK\3\4", 0), Format::Archive, "zip (pk3)");
    check(toBytes("// a .map file\n{\n\"classname\" \"worldspawn\"\n}\n"), Format::Text, "plain text");
    check({}, Format::Unknown, "only 0 bytes");
    check(toBytes("IBS"), Format::Unknown, "only 3 bytes");
    check(header("\xde\xad\xbe\xef", 46), Format::Unknown, "bytes deadbeef");
}

TEST(Bsp, DamagedDirectoriesAreTold) {
    const std::vector<std::byte> good = writeBsp(full());
    const auto with = [&](std::size_t at, std::int32_t value) {
        std::vector<std::byte> bytes = good;
        std::memcpy(bytes.data() + at, &value, sizeof value);
        return failure(bytes);
    };
    const auto entry = [](Lump lump) { return 8 + 8 * static_cast<std::size_t>(lump); };
    EXPECT_EQ(with(entry(Lump::Faces), -4), "x.bsp: lump faces: offset -4 and length 832 must not be negative");
    EXPECT_NE(with(entry(Lump::Faces), 0x7fffffff)
                  .find("lump faces: bytes 2147483647 to 2147484479 lie behind the end of the file"),
              std::string::npos);
    EXPECT_NE(
        with(entry(Lump::Vertices) + 4, 43).find("lump vertices: length 43 is not a multiple of the record size 44"),
        std::string::npos);
    EXPECT_NE(with(entry(Lump::Planes) + 4, -16).find("lump planes"), std::string::npos);
    EXPECT_NE(with(entry(Lump::Visibility) + 4, 4).find("lump visibility: 4 bytes are less than its header of 8"),
              std::string::npos);
    EXPECT_EQ(failure({good.begin(), good.begin() + 100}), "x.bsp: header: the file has 100 bytes, its header 144");
}

TEST(Bsp, EveryIndexIsChecked) {
    EXPECT_EQ(failureOf([](Bsp& b) { b.faces[2].shader = 2; }),
              "x.bsp: lump faces, record 2: shader 2 is not one of the 2 records of lump shaders");
    const auto says = [](const std::function<void(Bsp&)>& change, const std::string& expected) {
        const std::string message = failureOf(change);
        EXPECT_NE(message.find(expected), std::string::npos) << message;
    };
    for (const std::int32_t bad :
         {-1, 1000000, std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min()}) {
        says([&](Bsp& b) { b.nodes[0].plane = bad; }, "lump nodes, record 0: plane ");
        says([&](Bsp& b) { b.nodes[0].children[1] = bad == -1 ? -100 : bad; }, "lump nodes, record 0: child ");
        says([&](Bsp& b) { b.leafFaces[1] = bad; }, "lump leaf faces, record 1: face ");
        says([&](Bsp& b) { b.leafBrushes[0] = bad; }, "lump leaf brushes, record 0: brush ");
        says([&](Bsp& b) { b.leaves[1].firstLeafFace = bad; }, "lump leaves, record 1: first leaf face ");
        says([&](Bsp& b) { b.leaves[0].leafFaceCount = bad; }, "lump leaves, record 0: first leaf face ");
        says([&](Bsp& b) { b.leaves[0].firstLeafBrush = bad; }, "lump leaves, record 0: first leaf brush ");
        says([&](Bsp& b) { b.leaves[0].leafBrushCount = bad; }, "lump leaves, record 0: first leaf brush ");
        says([&](Bsp& b) { b.models[1].firstFace = bad; }, "lump models, record 1: first face ");
        says([&](Bsp& b) { b.models[1].faceCount = bad; }, "lump models, record 1: first face ");
        says([&](Bsp& b) { b.models[0].firstBrush = bad; }, "lump models, record 0: first brush ");
        says([&](Bsp& b) { b.models[0].brushCount = bad; }, "lump models, record 0: first brush ");
        says([&](Bsp& b) { b.brushes[0].firstSide = bad; }, "lump brushes, record 0: first side ");
        says([&](Bsp& b) { b.brushes[0].sideCount = bad; }, "lump brushes, record 0: first side ");
        says([&](Bsp& b) { b.brushes[0].shader = bad; }, "lump brushes, record 0: shader ");
        says([&](Bsp& b) { b.brushSides[3].plane = bad; }, "lump brush sides, record 3: plane ");
        says([&](Bsp& b) { b.brushSides[3].shader = bad; }, "lump brush sides, record 3: shader ");
        says([&](Bsp& b) { b.effects[0].brush = bad == -1 ? -2 : bad; }, "lump effects, record 0: brush ");
        says([&](Bsp& b) { b.effects[0].visibleSide = bad == -1 ? 6 : bad; }, "lump effects, record 0: visible side ");
        says([&](Bsp& b) { b.faces[1].shader = bad; }, "lump faces, record 1: shader ");
        says([&](Bsp& b) { b.faces[1].effect = bad == -1 ? 1 : bad; }, "lump faces, record 1: effect ");
        says([&](Bsp& b) { b.faces[1].firstVertex = bad; }, "lump faces, record 1: first vertex ");
        says([&](Bsp& b) { b.faces[1].vertexCount = bad; }, "lump faces, record 1: first vertex ");
        says([&](Bsp& b) { b.faces[1].firstMeshVertex = bad; }, "lump faces, record 1: first mesh vertex ");
        says([&](Bsp& b) { b.faces[1].meshVertexCount = bad; }, "lump faces, record 1: first mesh vertex ");
        says([&](Bsp& b) { b.meshVertices[7] = bad; }, "lump faces, record 1: mesh vertex 7 holds ");
        says([&](Bsp& b) { b.faces[6].patchSize[0] = bad; }, "lump faces, record 6: patch size ");
        says([&](Bsp& b) { b.faces[6].patchSize[1] = bad; }, "lump faces, record 6: patch size ");
        says([&](Bsp& b) { b.faces[3].type = static_cast<BspFaceType>(bad); }, "lump faces, record 3: type ");
    }
    says([](Bsp& b) { b.faces[1].lightmap = 1; },
         "lump faces, record 1: lightmap 1 is not one of the 1 records of lump lightmaps");
    says([](Bsp& b) { b.leaves[0].cluster = 9; },
         "lump leaves, record 0: cluster 9 is not one of the 9 clusters of lump visibility");
    says([](Bsp& b) { b.models.clear(); }, "lump models: is empty, so there is no world");
    says([](Bsp& b) { b.faces[1].meshVertexCount = 4; }, "mesh vertex count 4 is not a multiple of 3");
    says([](Bsp& b) { b.faces[1].type = static_cast<BspFaceType>(0); },
         "type 0 is none of 1 (polygon), 2 (patch), 3 (mesh), 4 (flare)");
    says([](Bsp& b) { b.visibility.bits.pop_back(); },
         "lump visibility: 9 clusters of 2 bytes do not fit into its 17 bytes");
    says([](Bsp& b) { b.visibility.bytesPerCluster = 1; },
         "lump visibility: 1 bytes per cluster cannot hold 9 clusters");
}

TEST(Bsp, PatchesOfImpossibleSizesAreTold) {
    const auto patch = [](std::int32_t w, std::int32_t h, std::int32_t count) {
        return failureOf([&](Bsp& b) {
            b.faces[6].patchSize = {w, h};
            b.vertices.resize(140000);
            b.faces[6].vertexCount = count;
        });
    };
    EXPECT_NE(patch(4, 3, 12).find("patch size 4x3 must be odd"), std::string::npos);
    EXPECT_NE(patch(1, 15, 15).find("patch size 1x15 must be odd and at least 3"), std::string::npos);
    EXPECT_NE(patch(3, 3, 15).find("patch size 3x3 does not fit its vertex count 15"), std::string::npos);
    EXPECT_NE(patch(1027, 3, 3081).find("beyond the limit of 1025 a side"), std::string::npos);
    EXPECT_NE(patch(1025, 65, 66625).find("and 65536 points"), std::string::npos);
    EXPECT_NE(patch(65537, 65537, 131073).find("beyond the limit"), std::string::npos);
}

TEST(Bsp, TreesWithoutEndAreTold) {
    const auto nodes = [](const std::vector<std::array<std::int32_t, 2>>& children) {
        return [children](Bsp& b) {
            b.nodes.resize(children.size(), b.nodes[0]);
            for (std::size_t i = 0; i < children.size(); ++i) b.nodes[i].children = children[i];
        };
    };
    const auto message = [&](const std::vector<std::array<std::int32_t, 2>>& children) {
        return failureOf(nodes(children));
    };
    EXPECT_NE(message({{0, -1}}).find("lump nodes, record 0: child 0 is reached twice"), std::string::npos);
    EXPECT_NE(message({{1, -1}, {2, -1}, {1, -2}}).find("record 2: child 1 is reached twice"), std::string::npos);
    EXPECT_NE(message({{1, 1}, {-1, -2}}).find("record 0: child 1 is reached twice"), std::string::npos);
    Bsp fine = full();
    nodes({{1, 2}, {-1, 3}, {-1, -2}, {-2, -2}})(fine);
    EXPECT_TRUE(readBsp(writeBsp(fine), "x.bsp"));
}

TEST(Bsp, NumbersThatAreNotFinite) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    EXPECT_EQ(failureOf([&](Bsp& b) { b.vertices[5].position.y = nan; }),
              "x.bsp: lump vertices, record 5: position is not finite");
    EXPECT_NE(
        failureOf([&](Bsp& b) { b.planes[2].normal.x = inf; }).find("lump planes, record 2: normal is not finite"),
        std::string::npos);
    EXPECT_NE(failureOf([&](Bsp& b) { b.planes[2].distance = -inf; }).find("distance is not finite"),
              std::string::npos);
    EXPECT_NE(failureOf([&](Bsp& b) { b.models[0].maxs.z = nan; }).find("lump models, record 0: maxs is not finite"),
              std::string::npos);
    Bsp bsp = full();
    bsp.vertices[3].lightmap = Vec2(nan, inf);
    bsp.vertices[4].texture.x = nan;
    const Result<Bsp> read = readBsp(writeBsp(bsp), "x.bsp");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->nonFiniteLightmapCoordinates, 2U);
    EXPECT_EQ(read->vertices[3].lightmap, Vec2(0));
    EXPECT_EQ(read->vertices[4].texture.x, 0);
    EXPECT_EQ(read->vertices[4].texture.y, bsp.vertices[4].texture.y);
}

TEST(Bsp, CountsThatOnlyTheirSumMakesTooLargeAreTold) {
    Bsp bsp = full();
    bsp.vertices.resize(60000);
    for (BspFace& face : bsp.faces) face.vertexCount = face.type == BspFaceType::Polygon ? 59000 : face.vertexCount;
    for (BspFace& face : bsp.faces)
        if (face.type == BspFaceType::Polygon) face.firstVertex = 0;
    for (int i = 0; i < 400; ++i) bsp.faces.push_back(bsp.faces[0]);
    EXPECT_NE(failure(writeBsp(bsp)).find("beyond the limits of 16777216 and 67108864"), std::string::npos);
}

TEST(Bsp, NamesThatFillTheirFieldAreKeptWithinIt) {
    Bsp bsp = full();
    bsp.shaders[0].name = std::string(80, 'n');
    const Result<Bsp> read = readBsp(writeBsp(bsp), "x.bsp");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->shaders[0].name, std::string(63, 'n'));
    EXPECT_EQ(lumpName(Lump::BrushSides), "brush sides");
}
