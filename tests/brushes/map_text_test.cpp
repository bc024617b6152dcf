// The text: the three forms of faces, patches, and what is wrong with it, line and column.

#include "pie/brushes/map_text.h"
#include "pie/brushes/texture_axes.h"
#include "tests/brushes/make_map.h"

#include <gmock/gmock.h>

#include <random>

namespace {

using namespace pie;
using namespace pie::brushes;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

MapText parsed(const std::string& text) {
    const Result<MapText> map = parseMap(text, "x.map");
    EXPECT_TRUE(map) << (map ? "" : map.error().message());
    return map ? *map : MapText{};
}

const std::string world = "{\n\"classname\" \"worldspawn\"\n";

TEST(MapText, ReadsTheThreeFormsOfFaces) {
    const MapText map = parsed(world + R"({
( 0 0 64 ) ( 64 0 64 ) ( 0 -64 64 ) gothic/Floor 8 -4 90 0.5 0.25 134217728 0 0
( 0 0 64 ) ( 64 0 64 ) ( 0 -64 64 ) "odd name" [ 1 0 0 16 ] [ 0 -1 0 0.5 ] 30 0.25 2 0 0 0
( 1e1 -.5 +3 ) ( 64 0 64 ) ( 0 -64 64 ) a\b 0 0 0 1 1
}
{
brushDef
{
( 0 0 64 ) ( 64 0 64 ) ( 0 -64 64 ) ( ( 0.1 0 0.5 ) ( 0 0.2 0.25 ) ) textures/base/wall 0 0 0
}
}
})");
    EXPECT_THAT(map.problems, IsEmpty());
    ASSERT_EQ(map.entities.size(), 1U);
    ASSERT_EQ(map.entities[0].brushes.size(), 2U);
    const BrushText& first = map.entities[0].brushes[0];
    EXPECT_EQ(first.line, 3);
    ASSERT_EQ(first.faces.size(), 3U);
    EXPECT_EQ(first.faces[0].shader, "textures/gothic/floor");
    EXPECT_EQ(first.faces[0].contents, 0x8000000);
    const auto& shifted = std::get<ShiftedTexture>(first.faces[0].texture);
    EXPECT_THAT(shifted.shift, ElementsAre(8, -4));
    EXPECT_EQ(shifted.rotate, 90);
    EXPECT_THAT(shifted.scale, ElementsAre(0.5, 0.25));
    EXPECT_EQ(first.faces[1].shader, "textures/odd name");
    const auto& axes = std::get<AxisTexture>(first.faces[1].texture);
    EXPECT_EQ(axes.axes[1], glm::dvec3(0, -1, 0));
    EXPECT_THAT(axes.shift, ElementsAre(16, 0.5));
    EXPECT_EQ(first.faces[2].points[0], glm::dvec3(10, -0.5, 3));
    EXPECT_EQ(first.faces[2].shader, "textures/a/b");
    const auto& matrix = std::get<MatrixTexture>(map.entities[0].brushes[1].faces[0].texture);
    EXPECT_EQ(matrix.rows[1], glm::dvec3(0, 0.2, 0.25));
}

TEST(MapText, ReadsPatches) {
    std::string text = world + "{\npatchDef2\n{\ncurves/pipe\n( 3 5 0 0 0 )\n(\n";
    for (int column = 0; column < 3; ++column) {
        text += "( ";
        for (int row = 0; row < 5; ++row)
            text += "( " + std::to_string(column) + " " + std::to_string(row) + " 7 0.5 " + std::to_string(row) + " ) ";
        text += ")\n";
    }
    const MapText map = parsed(text + ")\n}\n}\n}");
    EXPECT_THAT(map.problems, IsEmpty());
    ASSERT_THAT(map.entities[0].patches, SizeIs(1));
    const PatchText& patch = map.entities[0].patches[0];
    EXPECT_EQ(patch.width, 3);
    EXPECT_EQ(patch.height, 5);
    EXPECT_EQ(patch.controls[4 * 3 + 2].position, glm::dvec3(2, 4, 7));
    EXPECT_THAT(patch.controls[4 * 3 + 2].texture, ElementsAre(0.5, 4));
}

struct FaultCase {
    const char* brush;
    const char* message;
};
class Faults : public ::testing::TestWithParam<FaultCase> {};

TEST_P(Faults, AreNamedOnceAndTheRestIsRead) {
    const std::string good = test::boxText({0, 0, 0}, {64, 64, 64});
    const MapText map =
        parsed(world + GetParam().brush + "\n" + good + "}\n" + test::entityText({{"classname", "light"}}));
    ASSERT_THAT(map.problems, SizeIs(1));
    EXPECT_THAT(map.problems[0], HasSubstr(GetParam().message));
    ASSERT_THAT(map.entities, SizeIs(2));
    EXPECT_THAT(map.entities[0].brushes, SizeIs(1)) << "the good one";
    EXPECT_EQ(map.entities[1].entity.className(), "light");
}

INSTANTIATE_TEST_SUITE_P(
    MapText, Faults,
    ::testing::Values(
        FaultCase{"{\n( 0 0 x ) ( 64 0 64 ) ( 0 -64 64 ) a 0 0 0 1 1\n}",
                  "x.map: line 4, column 7: expected a number, found 'x'"},
        FaultCase{"{\n( 0 0 1 ( 64 0 64 ) ( 0 -64 64 ) a 0 0 0 1 1\n}", "line 4, column 9: expected ')', found '('"},
        FaultCase{"{\n( 0 0 1 ) ( 64 0 64 ) ( 0 -64 64 ) a 0 0 0\n}", "line 5, column 1: expected a number, found '}'"},
        FaultCase{"{\n( 0 0 1 ) ( 64 0 64 ) ( 0 -64 64 )\n}", "expected a shader name, found '}'"},
        FaultCase{"{\nbrushDef\n{\n( 0 0 1 ) ( 64 0 64 ) ( 0 -64 64 ) a 0 0 0\n}\n}", "expected '(', found 'a'"},
        FaultCase{"{\npatchDef2\n{\na\n( 2 3 0 0 0 )\n(\n)\n}\n}",
                  "a patch of 2 x 3 controls: both must be odd, at least 3"},
        FaultCase{"{\nterrainDef\n{\n}\n}", "expected '(', patchDef2 or brushDef, found 'terrainDef'"},
        FaultCase{"{\n( 0 0 1e999 ) ( 64 0 64 ) ( 0 -64 64 ) a 0 0 0 1 1\n}", "expected a number, found '1e999'"},
        FaultCase{"\"message\" \"open", "line 3, column 11: the quote is not closed on its line"}));

TEST(MapText, WhatIsNotClosedIsKeptAsFarAsItGoes) {
    const MapText map = parsed(world + "\"light\" \"300\"\n");
    ASSERT_THAT(map.problems, SizeIs(1));
    EXPECT_THAT(map.problems[0], HasSubstr("line 1, column 1: the entity is not closed"));
    EXPECT_EQ(map.entities.at(0).entity.value("light"), "300");
}

TEST(MapText, TextThatIsNoMapIsAnError) {
    for (const char* text : {"", "// nothing\n", "hello", "\x01\x02\x03"}) {
        const Result<MapText> map = parseMap(text, "x.map");
        ASSERT_FALSE(map) << text;
        EXPECT_THAT(map.error().message(), HasSubstr("x.map"));
    }
}

/// Whatever a text loses or has changed: an answer, and no crash.
TEST(MapText, DamagedTextIsReadOrRefused) {
    const std::string whole =
        world + test::boxText({0, 0, 0}, {64, 64, 64}) + "{\npatchDef2\n{\na\n( 3 3 0 0 0 )\n(\n" +
        "( ( 0 0 0 0 0 ) ( 0 1 0 0 0 ) ( 0 2 0 0 0 ) )\n( ( 1 0 0 0 0 ) ( 1 1 0 0 0 ) ( 1 2 0 0 0 ) )\n" +
        "( ( 2 0 0 0 0 ) ( 2 1 0 0 0 ) ( 2 2 0 0 0 ) )\n)\n}\n}\n}\n" + test::entityText({{"classname", "light"}});
    std::size_t read = 0;
    for (std::size_t cut = 0; cut < whole.size(); ++cut) read += parseMap(whole.substr(0, cut), "x.map") ? 1 : 0;
    EXPECT_GT(read, whole.size() / 2);
    std::mt19937 random(5);
    const std::string odd = "{}()[]\"\n x9-.";
    for (int i = 0; i < 3000; ++i) {
        std::string text = whole;
        for (int k = 0; k < 1 + i % 4; ++k) text[random() % text.size()] = odd[random() % odd.size()];
        const Result<level::Level> level = test::loadMapText(text);
        if (!level) {
            EXPECT_FALSE(level.error().message().empty());
            EXPECT_EQ(level.error().message().find('\n'), std::string::npos);
        }
    }
}

/// A floor tile of 64 texels at half a unit a texel repeats every 32 units; the numbers are the editors'.
TEST(TextureAxes, FormsAgreeOnTheSameTexture) {
    const glm::dvec3 up(0, 0, 1);
    const TextureMapping shifted = makeMapping(ShiftedTexture{{16, 8}, 0, {0.5, 0.5}}, up, 64, 64);
    const TextureMapping axes =
        makeMapping(AxisTexture{{glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0)}, {16, 8}, {0.5, 0.5}}, up, 64, 64);
    for (const glm::dvec3& p : {glm::dvec3(0, 0, 0), glm::dvec3(32, 0, 5), glm::dvec3(-7, 19, 1)}) {
        EXPECT_NEAR(shifted.at(p).x, (p.x / 0.5 + 16) / 64, 1e-12);
        EXPECT_NEAR(shifted.at(p).y, (-p.y / 0.5 + 8) / 64, 1e-12);
        EXPECT_NEAR(axes.at(p).x, shifted.at(p).x, 1e-12);
        EXPECT_NEAR(axes.at(p).y, shifted.at(p).y, 1e-12);
    }
    // A quarter turn swaps the axes exactly.
    const TextureMapping turned = makeMapping(ShiftedTexture{{0, 0}, 90, {1, 1}}, up, 64, 64);
    EXPECT_EQ(turned.at({0, 64, 0}).x, 1 - 2 * (turned.axes[0].y < 0 ? 1 : 0));
    EXPECT_EQ(turned.axes[0].x, 0);
    // Walls take z downwards.
    const TextureMapping wall = makeMapping(ShiftedTexture{{0, 0}, 0, {1, 1}}, {1, 0, 0}, 64, 128);
    EXPECT_EQ(wall.at({5, 64, 128}), glm::dvec2(1, -1));
    // Scale nought counts as one.
    EXPECT_EQ(makeMapping(ShiftedTexture{{0, 0}, 0, {0, 0}}, up, 64, 64).at({64, 0, 0}).x, 1);
}

} // namespace
