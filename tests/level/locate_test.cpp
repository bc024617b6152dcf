#include "pie/level/level.h"
#include "tests/level/make_level.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>
#include <zip.h>

using namespace pie;
using namespace pie::level;
using namespace pie::test;

namespace {

void zipText(const std::string& path, const std::vector<std::pair<std::string, std::string>>& files) {
    int code = 0;
    zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
    ASSERT_NE(archive, nullptr);
    for (const auto& [name, text] : files)
        ASSERT_GE(zip_file_add(archive, name.c_str(), zip_source_buffer(archive, text.data(), text.size(), 0),
                               ZIP_FL_ENC_UTF_8),
                  0);
    ASSERT_EQ(zip_close(archive), 0);
}

std::string content(const Location& location, const std::string& name) {
    const Result<Bytes> bytes = location.files.read(name);
    return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : "";
}

class LocateTest : public testing::Test {
protected:
    void SetUp() override {
        std::filesystem::create_directories(folder_.path() / "game/maps");
        std::filesystem::create_directories(folder_.path() / "base");
        zipText(path("game/pak0.pk3"), {{"maps/x.bsp", "x of pak0"}, {"maps/y.bsp", "y of pak0"}, {"t", "t of pak0"}});
        zipText(path("game/pak1.pk3"), {{"maps/x.bsp", "x of pak1"}, {"t", "t of pak1"}});
        zipText(path("base/base.pk3"), {{"t", "t of base"}, {"u", "u of base"}, {"maps/b.bsp", "b of base"}});
    }
    [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
    TemporaryFolder folder_;
};

} // namespace

TEST_F(LocateTest, AFileOnDiskImpliesTheGameDirectoryAboveMaps) {
    (void)folder_.write("game/maps/Loose.bsp", "loose");
    const Result<Location> found = locate(path("game/maps/Loose.bsp"));
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_EQ(found->name, "maps/loose.bsp");
    EXPECT_EQ(content(*found, found->name), "loose");
    EXPECT_EQ(content(*found, "t"), "t of pak1");
    EXPECT_EQ(content(*found, "u"), "");
}

TEST_F(LocateTest, ARelativePathWithDotsWorksToo) {
    (void)folder_.write("game/maps/sub/l.bsp", "deep");
    const Result<Location> found = locate(path("base/../game/maps/./sub/l.bsp"));
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_EQ(found->name, "maps/sub/l.bsp");
    EXPECT_EQ(content(*found, "t"), "t of pak1");
}

TEST_F(LocateTest, AFileElsewhereSeesItsOwnFolder) {
    (void)folder_.write("somewhere/l.bsp", "level");
    (void)folder_.write("somewhere/textures/a.tga", "a");
    const Result<Location> found = locate(path("somewhere/l.bsp"), {}, {path("base")});
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_EQ(found->name, "l.bsp");
    EXPECT_EQ(content(*found, "textures/a.tga"), "a");
    EXPECT_EQ(content(*found, "u"), "u of base");
}

TEST_F(LocateTest, TheNamedArchiveWinsForTheLevelOnly) {
    const Result<Location> lower = locate(path("game/pak0.pk3/maps/x.bsp"));
    ASSERT_TRUE(lower) << lower.error().message();
    EXPECT_EQ(content(*lower, lower->name), "x of pak0");
    EXPECT_EQ(content(*lower, "t"), "t of pak1");
    EXPECT_EQ(lower->files.origin(lower->name), path("game/pak0.pk3/maps/x.bsp"));
    const Result<Location> upper = locate(path("game/pak1.pk3/maps/X.BSP"));
    ASSERT_TRUE(upper) << upper.error().message();
    EXPECT_EQ(content(*upper, upper->name), "x of pak1");
}

TEST_F(LocateTest, AMapNameIsSearchedInTheGame) {
    for (const char* name : {"x", "x.bsp", "maps/x", "maps/x.bsp", "MAPS/X.bsp"}) {
        const Result<Location> found = locate(name, path("game"), {path("base")});
        ASSERT_TRUE(found) << name << ": " << found.error().message();
        EXPECT_EQ(found->name, "maps/x.bsp");
        EXPECT_EQ(content(*found, found->name), "x of pak1");
        EXPECT_EQ(content(*found, "u"), "u of base");
    }
}

TEST_F(LocateTest, ErrorsAreOneClearLine) {
    const auto message = [&](const std::string& level, const std::filesystem::path& game = {}) {
        const Result<Location> found = locate(level, game);
        EXPECT_FALSE(found) << level;
        return found ? std::string() : found.error().message();
    };
    EXPECT_EQ(message("z", path("game")),
              "z: no such map in " + path("game") + " (there are 2 maps, the first is maps/x.bsp)");
    EXPECT_NE(message(path("game/maps/none.bsp")).find("none.bsp: no such file"), std::string::npos);
    EXPECT_EQ(message(path("game/pak0.pk3/maps/none.bsp")),
              path("game/pak0.pk3/maps/none.bsp") + ": no such file in the archive");
    EXPECT_NE(message("x", path("nowhere")).find("is not a game directory"), std::string::npos);
    (void)folder_.write("game/bad.pk3", "no zip");
    EXPECT_NE(message(path("game/bad.pk3/maps/x.bsp")).find("is not a readable pk3 (zip) archive"), std::string::npos);
    EXPECT_NE(message("").find("no such file"), std::string::npos);
}
