#include "pie/level/entities.h"

#include <gtest/gtest.h>

using namespace pie;
using namespace pie::level;

namespace {

std::vector<Entity> parse(std::string_view text) {
    Result<std::vector<Entity>> entities = parseEntities(text, "x.bsp");
    EXPECT_TRUE(entities) << entities.error().message();
    return entities ? *entities : std::vector<Entity>{};
}

std::string failure(std::string_view text) {
    const Result<std::vector<Entity>> entities = parseEntities(text, "x.bsp", "lump entities");
    EXPECT_FALSE(entities);
    return entities ? "" : entities.error().message();
}

} // namespace

TEST(Entities, KeysComeInOrderAndTheLastOneWins) {
    const auto entities =
        parse("{ \"classname\" \"light\" \"a\" \"1\" \"A\" \"2\" }\n{ \"classname\" \"worldspawn\" }");
    ASSERT_EQ(entities.size(), 2U);
    EXPECT_EQ(entities[0].pairs.size(), 3U);
    EXPECT_EQ(entities[0].className(), "light");
    EXPECT_EQ(entities[0].value("a"), "2");
    EXPECT_EQ(entities[0].value("CLASSNAME"), "light");
    EXPECT_EQ(entities[0].value("b"), "");
    EXPECT_TRUE(entities[0].has("a"));
    EXPECT_FALSE(entities[0].has("b"));
}

TEST(Entities, NumbersAndVectorsAreCheckedForSense) {
    const auto entities =
        parse(R"({ "n" "12.5 units" "bad" "x" "inf" "1e99" "v" "1 -2 +3.5" "short" "1 2" "empty" "" })");
    const Entity& e = entities.at(0);
    EXPECT_EQ(e.number("n"), 12.5F);
    EXPECT_FALSE(e.number("bad"));
    EXPECT_FALSE(e.number("inf"));
    EXPECT_FALSE(e.number("absent"));
    EXPECT_FALSE(e.number("empty"));
    EXPECT_EQ(e.vector("v"), Vec3(1, -2, 3.5F));
    EXPECT_FALSE(e.vector("short"));
    EXPECT_FALSE(e.vector("absent"));
}

TEST(Entities, BrushesOfAMapFileAreSkipped) {
    const auto entities = parse("// entity 0\n{\n\"classname\" \"worldspawn\"\n// brush 0\n{\n( 0 0 0 ) ( 1 0 0 ) ( 0 "
                                "1 0 ) a/b 0 0 0 1 1 0 0 0\n}\n"
                                "{\npatchDef2\n{\ntextures/x\n( 3 3 0 0 0 )\n(\n( ( 0 0 0 0 0 ) )\n)\n}\n}\n\"after\" "
                                "\"yes\"\n}\n{\n\"classname\" \"light\"\n}\n");
    ASSERT_EQ(entities.size(), 2U);
    EXPECT_EQ(entities[0].value("after"), "yes");
    EXPECT_EQ(entities[1].className(), "light");
}

TEST(Entities, ErrorsNameLineAndColumn) {
    EXPECT_EQ(failure("{\n\"a\" \"b\"\n"),
              "x.bsp: lump entities, line 1, column 1: this entity is not closed by '}' before the text ends");
    EXPECT_EQ(failure("{ }\n  nonsense"), "x.bsp: lump entities, line 2, column 3: expected '{', found 'nonsense'");
    EXPECT_EQ(failure("{\n \"key\"\n}"), "x.bsp: lump entities, line 2, column 2: the key 'key' has no value");
    EXPECT_EQ(failure("{ { { }"),
              "x.bsp: lump entities, line 1, column 3: this brush is not closed by '}' before the text ends");
}

TEST(Entities, NoEntitiesIsFine) { EXPECT_TRUE(parse(" \n // nothing\n").empty()); }
