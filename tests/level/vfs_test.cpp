#include "pie/level/vfs.h"
#include "tests/level/make_level.h"
#include "tests/support/files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zip.h>

#include <atomic>
#include <thread>

using namespace pie;
using namespace pie::level;
using namespace pie::test;

namespace {

using Files = std::vector<std::pair<std::string, std::string>>;

/// Writes a zip archive; names go in as they are.
void writeZip(const std::string& path, const Files& files) {
    int code = 0;
    zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
    ASSERT_NE(archive, nullptr);
    for (const auto& [name, text] : files) {
        zip_source_t* source = zip_source_buffer(archive, text.data(), text.size(), 0);
        ASSERT_GE(zip_file_add(archive, name.c_str(), source, ZIP_FL_ENC_UTF_8), 0) << name;
    }
    ASSERT_EQ(zip_close(archive), 0) << zip_strerror(archive);
}

std::string text(const Vfs& files, std::string_view name) {
    const Result<Bytes> bytes = files.read(name);
    if (!bytes) return "error: " + bytes.error().message();
    return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
}

class VfsTest : public testing::Test {
protected:
    [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
    TemporaryFolder folder_;
};

using Names = std::vector<std::string>;

} // namespace

TEST_F(VfsTest, FoldersAreReadWithoutCase) {
    (void)folder_.write("Textures/Base/Wall.TGA", "wall");
    Vfs files;
    ASSERT_TRUE(files.mountFolder(folder_.path()));
    EXPECT_EQ(text(files, "textures/base/wall.tga"), "wall");
    EXPECT_EQ(text(files, "TEXTURES\\base//WALL.tga"), "wall");
    EXPECT_TRUE(files.contains("textures/base/wall.tga"));
    EXPECT_FALSE(files.contains("textures/base"));
    EXPECT_FALSE(files.contains("textures/base/wall.tga/x"));
    EXPECT_EQ(files.origin("textures/base/wall.tga"), path("Textures/Base/Wall.TGA"));
    EXPECT_EQ(files.origin("nothing"), "");
}

TEST_F(VfsTest, NamesThatClimbOutAreNeverFound) {
    (void)folder_.write("secret.txt", "secret");
    (void)folder_.write("game/x.txt", "x");
    Vfs files;
    ASSERT_TRUE(files.mountFolder(folder_.path() / "game"));
    for (const std::string& name : {std::string("../secret.txt"), std::string("a/../../secret.txt"), path("secret.txt"),
                                    std::string("..\\secret.txt")}) {
        EXPECT_FALSE(files.contains(name)) << name;
        EXPECT_FALSE(files.read(name)) << name;
    }
    EXPECT_TRUE(files.list("..", "").empty());
    EXPECT_EQ(text(files, "./x.txt"), "x");
}

TEST_F(VfsTest, LinksInsideAFolderAreFollowedAndLoopsEnd) {
    (void)folder_.write("elsewhere/x.txt", "linked");
    (void)folder_.write("game/y.txt", "y");
    std::filesystem::create_directory_symlink(folder_.path() / "elsewhere", folder_.path() / "game/link");
    std::filesystem::create_directory_symlink(folder_.path() / "game", folder_.path() / "game/loop");
    Vfs files;
    ASSERT_TRUE(files.mountFolder(folder_.path() / "game"));
    EXPECT_EQ(text(files, "link/x.txt"), "linked");
    EXPECT_FALSE(files.list("", ".txt").empty());
}

TEST_F(VfsTest, ArchivesAreReadWithoutCaseAndHideUnsafeNames) {
    writeZip(path("a.pk3"), {{"Maps/X.bsp", "level"}, {"../evil.txt", "evil"}, {"/abs.txt", "abs"}, {"empty.txt", ""}});
    Vfs files;
    ASSERT_TRUE(files.mountArchive(path("a.pk3")));
    EXPECT_EQ(text(files, "maps/x.BSP"), "level");
    EXPECT_EQ(text(files, "empty.txt"), "");
    EXPECT_EQ(files.origin("maps/x.bsp"), path("a.pk3/maps/x.bsp"));
    EXPECT_FALSE(files.contains("../evil.txt"));
    EXPECT_FALSE(files.contains("evil.txt"));
    EXPECT_EQ(files.list("", ""), (Names{"empty.txt", "maps/x.bsp"}));
}

TEST_F(VfsTest, PrecedenceIsTheGames) {
    writeZip(path("pak0.pk3"), {{"a", "pak0"}, {"b", "pak0"}, {"c", "pak0"}, {"d", "pak0"}, {"only0", "pak0"}});
    writeZip(path("PAK1.pk3"), {{"a", "pak1"}, {"b", "pak1"}, {"c", "pak1"}});
    writeZip(path("zz.pk3"), {{"a", "zz"}, {"b", "zz"}});
    (void)folder_.write("a", "folder");
    Vfs files;
    ASSERT_TRUE(files.mountGame(folder_.path()));
    EXPECT_EQ(text(files, "a"), "folder");
    EXPECT_EQ(text(files, "b"), "zz");
    EXPECT_EQ(text(files, "c"), "pak1");
    EXPECT_EQ(text(files, "d"), "pak0");
    files.mountMemory("given", {{"a", toBytes("given")}});
    EXPECT_EQ(text(files, "a"), "given");
    // As the game lists them: from the highest down, each name where it is first met.
    EXPECT_EQ(files.scan("", ""), (Names{"a", "pak0.pk3", "pak1.pk3", "zz.pk3", "b", "c", "d", "only0"}));
    EXPECT_EQ(files.list("", ""), (Names{"a", "b", "c", "d", "only0", "pak0.pk3", "pak1.pk3", "zz.pk3"}));
}

TEST_F(VfsTest, UnderscoresSortBehindLettersInPakNames) {
    writeZip(path("a_b.pk3"), {{"x", "underscore"}});
    writeZip(path("azb.pk3"), {{"x", "letter"}});
    Vfs files;
    ASSERT_TRUE(files.mountGame(folder_.path()));
    EXPECT_EQ(text(files, "x"), "underscore");
}

TEST_F(VfsTest, FoldersNamedLikeArchivesStandAmongThem) {
    writeZip(path("pak0.pk3"), {{"x", "zip"}, {"y", "zip"}});
    (void)folder_.write("pak1.pk3dir/x", "dir");
    Vfs files;
    ASSERT_TRUE(files.mountGame(folder_.path()));
    EXPECT_EQ(text(files, "x"), "dir");
    EXPECT_EQ(text(files, "y"), "zip");
}

TEST_F(VfsTest, DamagedArchivesAreErrorsAloneAndWarningsInAGame) {
    (void)folder_.write("bad.pk3", "this is no zip file");
    writeZip(path("good.pk3"), {{"x", "good"}});
    Vfs files;
    const Result<bool> mounted = files.mountArchive(path("bad.pk3"));
    ASSERT_FALSE(mounted);
    EXPECT_NE(mounted.error().message().find("bad.pk3: is not a readable pk3 (zip) archive"), std::string::npos);
    ASSERT_TRUE(files.mountGame(folder_.path()));
    EXPECT_EQ(text(files, "x"), "good");
    ASSERT_EQ(files.warnings().size(), 1U);
    EXPECT_NE(files.warnings()[0].find("bad.pk3"), std::string::npos);
}

TEST_F(VfsTest, DamagedContentIsNoticed) {
    writeZip(path("a.pk3"), {{"x", std::string(5000, 'x') + "some text that does not compress away"}});
    std::string bytes = readText(path("a.pk3"));
    bytes[35] = static_cast<char>(bytes[35] ^ 0x55); // inside the compressed data
    (void)folder_.write("a.pk3", bytes);
    Vfs files;
    ASSERT_TRUE(files.mountArchive(path("a.pk3")));
    const Result<Bytes> content = files.read("x");
    ASSERT_FALSE(content);
    EXPECT_NE(content.error().message().find("a.pk3/x: cannot be read from the archive"), std::string::npos)
        << content.error().message();
}

TEST_F(VfsTest, MissingFoldersAndFilesAreErrors) {
    Vfs files;
    EXPECT_FALSE(files.mountFolder(path("nowhere")));
    EXPECT_FALSE(files.mountGame(path("nowhere")));
    EXPECT_FALSE(files.mountArchive(path("nowhere.pk3")));
    EXPECT_EQ(files.read("x").error().message(), "x: no such file in the folders and pk3 files of the level");
}

TEST_F(VfsTest, ManyThreadsReadTheSameArchive) {
    Files content;
    for (int i = 0; i < 64; ++i)
        content.emplace_back(fmt::format("f{}", i),
                             std::string(10000, static_cast<char>('a' + i % 26)) + std::to_string(i));
    writeZip(path("a.pk3"), content);
    (void)folder_.write("g/loose", "loose");
    Vfs files;
    ASSERT_TRUE(files.mountArchive(path("a.pk3")));
    ASSERT_TRUE(files.mountFolder(path("g")));
    std::atomic<int> wrong{0};
    std::vector<std::thread> readers;
    for (std::size_t reader = 0; reader < 8; ++reader)
        readers.emplace_back([&, reader] {
            for (std::size_t i = reader; i < 512; ++i) {
                const auto& [name, expected] = content[i % content.size()];
                if (text(files, name) != expected || text(files, "loose") != "loose") ++wrong;
            }
        });
    for (std::thread& reader : readers) reader.join();
    EXPECT_EQ(wrong, 0);
}
