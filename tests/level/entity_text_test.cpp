#include "pie/level/entity_text.h"
#include "tests/support/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>

namespace pie::level {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::vector<Entity> entitiesOf(std::string_view text) {
    const Result<std::vector<Entity>> entities = parseEntities(text, "x.map");
    EXPECT_TRUE(entities) << entities.error().message();
    return entities ? *entities : std::vector<Entity>{};
}

EntityEdit with(const Entity& entity, std::string_view key, std::string value) {
    EntityEdit edit{entity, entity};
    edit.after.set(key, std::move(value));
    return edit;
}

std::string edited(std::string_view text, const std::vector<EntityEdit>& edits) {
    const Result<std::string> result = editEntities(text, "x.map", edits);
    EXPECT_TRUE(result) << result.error().message();
    return result ? *result : "";
}
std::string refused(std::string_view text, const std::vector<EntityEdit>& edits) {
    const Result<std::string> result = editEntities(text, "x.map", edits);
    EXPECT_FALSE(result);
    return result ? "" : result.error().message();
}

// As editors write it, with a comment, an odd indentation, and words without quotation marks.
constexpr std::string_view lampText =
    "// entity 0\r\n{\r\n\"classname\" \"worldspawn\"\r\n{\r\n( 0 0 0 ) ( 1 0 0 ) ( 0 1 0 ) "
    "a/b 0 0 0 1 1 0 0 0\r\n}\r\n}\r\n{\r\n\t\"classname\" \"light\" // a lamp\r\n\t\"origin\" "
    "\"1 2 3\"\r\n\t\"light\"  \"200\"\r\n}\r\n{ classname light light 100 }\r\n";

TEST(EntityText, OnlyTheValueChanges) {
    const std::vector<Entity> entities = entitiesOf(lampText);
    const std::string result = edited(lampText, {with(entities.at(1), "LIGHT", "250.5")});
    std::string expected(lampText);
    expected.replace(expected.find("200"), 3, "250.5");
    EXPECT_EQ(result, expected);
    EXPECT_EQ(edited(result, {with(entitiesOf(result).at(1), "light", "200")}), lampText);
}

TEST(EntityText, ANewKeyStandsLikeTheOneBeforeIt) {
    const std::string result = edited(lampText, {with(entitiesOf(lampText).at(1), "_color", "1 0 0")});
    std::string expected(lampText);
    expected.insert(expected.find("\"200\"") + 5, "\r\n\t\"_color\" \"1 0 0\"");
    EXPECT_EQ(result, expected);
}

TEST(EntityText, WordsWithoutQuotationMarksGetThem) {
    const std::vector<Entity> entities = entitiesOf(lampText);
    EntityEdit edit = with(entities.at(2), "light", "50");
    edit.after.set("origin", "7 8 9");
    edit.after.set("_color", "0 1 0");
    EXPECT_THAT(edited(lampText, {edit}),
                HasSubstr(R"({ classname light light "50" "origin" "7 8 9" "_color" "0 1 0" })"));
}

TEST(EntityText, OfTwoAlikeEachIsEditedOnce) {
    const std::string two = R"({ "light" "1" } { "light" "1" })";
    const Entity one = entitiesOf(two).front();
    EXPECT_EQ(edited(two, {with(one, "light", "2"), with(one, "light", "3")}),
              "{ \"light\" \"2\" } { \"light\" \"3\" }");
    EXPECT_EQ(edited(two, {with(one, "light", "2")}), "{ \"light\" \"2\" } { \"light\" \"1\" }");
    EXPECT_THAT(refused(two, {with(one, "light", "2"), with(one, "light", "3"), with(one, "light", "4")}),
                HasSubstr("is not there as it was read"));
}

TEST(EntityText, WhatCannotBeDoneIsRefused) {
    const std::vector<Entity> entities = entitiesOf(lampText);
    EXPECT_THAT(refused(lampText, {with(entities.at(1), "light", "a\"b")}), HasSubstr("quotation mark"));
    EXPECT_THAT(refused(lampText, {with(entities.at(1), "new", "a\nb")}), HasSubstr("line end"));
    EntityEdit lost{entities.at(1), entities.at(1)};
    lost.after.pairs.pop_back();
    EXPECT_THAT(refused(lampText, {lost}), HasSubstr("x.map: light at 1 2 3: a key of it would be lost"));
    EntityEdit renamed{entities.at(1), entities.at(1)};
    renamed.after.pairs[2].first = "brightness";
    EXPECT_THAT(refused(lampText, {renamed}), HasSubstr("its key 'light' would be lost"));
    EXPECT_THAT(refused("{ \"a\"", {}), HasSubstr("x.map: map, line 1"));
    EXPECT_THAT(refused("{ }", {with(entities.at(1), "light", "1")}), HasSubstr("has the file changed since?"));
}

TEST(EntityText, SavingKeepsWhatWasThereBeside) {
    const test::TemporaryFolder folder;
    const fs::path file = folder.write("x.map", lampText);
    fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
    const std::vector<EntityEdit> edits = {with(entitiesOf(lampText).at(1), "light", "1")};
    EXPECT_FALSE(saveEntities(file, edits));
    EXPECT_EQ(test::readText(file), edited(lampText, edits));
    EXPECT_EQ(test::readText(folder.path() / "x.map.before"), lampText);
    EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2);
}

TEST(EntityText, SavingNothingWritesNothing) {
    const test::TemporaryFolder folder;
    const fs::path file = folder.write("x.map", lampText);
    EXPECT_FALSE(saveEntities(file, {}));
    EXPECT_FALSE(saveEntities(file, std::vector<EntityEdit>{with(entitiesOf(lampText).at(1), "light", "200")}));
    EXPECT_FALSE(fs::exists(folder.path() / "x.map.before"));
}

TEST(EntityText, ALinkStaysALink) {
    const test::TemporaryFolder folder;
    const fs::path real = folder.write("real/x.map", lampText);
    fs::create_symlink("real/x.map", folder.path() / "x.map");
    const std::vector<EntityEdit> edits = {with(entitiesOf(lampText).at(1), "light", "1")};
    EXPECT_FALSE(saveEntities(folder.path() / "x.map", edits));
    EXPECT_TRUE(fs::is_symlink(folder.path() / "x.map"));
    EXPECT_EQ(test::readText(real), edited(lampText, edits));
}

TEST(EntityText, AFailureLeavesTheFile) {
    const test::TemporaryFolder folder;
    const fs::path file = folder.write("x.map", lampText);
    const std::optional<Error> changed =
        saveEntities(file, std::vector<EntityEdit>{with(Entity{{{"a", "b"}}}, "a", "c")});
    ASSERT_TRUE(changed);
    EXPECT_THAT(changed->message(), HasSubstr("x.map"));
    EXPECT_EQ(test::readText(file), lampText);
    EXPECT_TRUE(saveEntities(folder.path() / "absent.map", {}));
}

} // namespace
} // namespace pie::level
