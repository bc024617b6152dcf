// Bookmarks and paths: kept, apart for every level, and never written over what cannot be read.

#include "apps/pieview/level_notes.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace {

namespace fs = std::filesystem;
using pieview::LevelNotes;

class Notes : public ::testing::Test {
protected:
    void SetUp() override { ::setenv("XDG_CONFIG_HOME", folder_.path().c_str(), 1); }
    void TearDown() override { ::unsetenv("XDG_CONFIG_HOME"); }
    pie::test::TemporaryFolder folder_;
};

TEST_F(Notes, ComeBackAsTheyWere) {
    LevelNotes notes;
    notes.bookmarks[0] = apps::Camera{{1.5F, -2, 3}, 45, 10};
    notes.bookmarks[9] = apps::Camera{{-100, 0, 64}, -90, 0};
    notes.path = {{{0, 0, 0}, 0, 0}, {{64, 0, 0}, 90, -5}};
    const fs::path level = R"(some "odd"\place/x.map)";
    const fs::path file = pieview::notesFile(level);
    EXPECT_EQ(file.parent_path(), folder_.path() / "pie/levels");
    const auto error = pieview::writeNotes(file, notes, level);
    ASSERT_FALSE(error) << error->message();
    const auto back = pieview::readNotes(file);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, notes);
}

TEST_F(Notes, AreEmptyWhereThereAreNone) {
    const auto notes = pieview::readNotes(pieview::notesFile("x.map"));
    ASSERT_TRUE(notes);
    EXPECT_EQ(*notes, LevelNotes{});
}

TEST_F(Notes, LevelsOfOneNameAreApart) {
    EXPECT_NE(pieview::notesFile("a/x.map"), pieview::notesFile("b/x.map"));
    EXPECT_EQ(pieview::notesFile("a/x.map"), pieview::notesFile("a/../a/x.map"));
}

TEST_F(Notes, DamageIsSaidWithItsPlace) {
    const std::string file = folder_.write("broken.toml", "path = [\n\"1 2 3\",\n");
    const auto notes = pieview::readNotes(file);
    ASSERT_FALSE(notes);
    EXPECT_NE(notes.error().message().find("broken.toml: line"), std::string::npos) << notes.error().message();
}

TEST_F(Notes, PlacesThatAreNoneAreLeftOut) {
    const std::string file =
        folder_.write("odd.toml", "path = [\"1 2\", \"1 2 3 4 5\", 7]\n[bookmarks]\n3 = \"x\"\n4 = \"1 2 3\"\n");
    const auto notes = pieview::readNotes(file);
    ASSERT_TRUE(notes);
    EXPECT_EQ(notes->path.size(), 1U);
    EXPECT_FALSE(notes->bookmarks[3]);
    EXPECT_TRUE(notes->bookmarks[4]);
}

} // namespace
