// The plug-in as osgDB sees it: options, errors, search path, streams, Valve's files, threads.

#include "pie/engine/settings.h"
#include "tests/level/make_level.h"
#include "tests/osg/scene_reading.h"

#include <gmock/gmock.h>

#include <osgDB/FileUtils>
#include <osgDB/Registry>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <functional>
#include <sstream>
#include <thread>

namespace {

using namespace pie;
using namespace pie::test;
using osgDB::ReaderWriter;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Status = ReaderWriter::ReadResult::ReadStatus;

level::Bsp room() {
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    builder.room({-128, -128, -64}, {128, 128, 64}, {wall, wall, wall, wall, wall, wall});
    builder.entity({{"classname", "light"}, {"origin", "0 0 32"}, {"light", "200"}});
    return builder.build();
}

void expectError(ReaderWriter::ReadResult result, const std::string& part) {
    EXPECT_EQ(result.status(), Status::ERROR_IN_READING_FILE);
    EXPECT_FALSE(result.validNode()) << "a damaged level is no empty scene";
    EXPECT_THAT(result.message(), AllOf(HasSubstr("[bsp] "), HasSubstr(part), Not(HasSubstr("\n"))));
}

/// An empty Valve level, as far as OSG's own reader looks at it: header of 64 lumps.
std::string valveLevel() {
    std::string file = "VBSP";
    const auto number = [&](std::int32_t value) {
        for (unsigned byte = 0; byte < 4; ++byte)
            file += static_cast<char>((static_cast<std::uint32_t>(value) >> (8 * byte)) & 255U);
    };
    constexpr int lumps = 64;
    constexpr int headerBytes = 8 + 16 * lumps + 4;
    number(20);
    for (int lump = 0; lump < lumps; ++lump)
        for (const int value : {headerBytes, 0, 0, 0}) number(value);
    number(1);
    return file;
}

std::vector<std::string> bspReaders() {
    std::vector<std::string> names;
    for (const auto& reader : osgDB::Registry::instance()->getReaderWriterList())
        if (reader->acceptsExtension("bsp")) names.emplace_back(reader->className());
    return names;
}

/// Another osgdb_bsp in OSG's folders than the one of this build.
bool stockPluginInstalled() {
    namespace fs = std::filesystem;
    usePlugin();
    const fs::path ours = osgDB::findLibraryFile(osgDB::Registry::instance()->createLibraryNameForExtension("bsp"));
    for (const std::string& path : osgDB::Registry::instance()->getLibraryFilePathList())
        for (const fs::path& file :
             {fs::path(path) / ours.filename(), fs::path(path) / ours.parent_path().filename() / ours.filename()})
            if (fs::is_regular_file(file) && !fs::equivalent(file, ours)) return true;
    return false;
}

} // namespace

TEST(PluginRead, EverySettingIsAnOption) {
    usePlugin();
    ReaderWriter* reader = osgDB::Registry::instance()->getReaderWriterForExtension("bsp");
    ASSERT_NE(reader, nullptr);
    EXPECT_STREQ(reader->libraryName(), "osgpie");
    const auto& options = reader->supportedOptions();
    EXPECT_EQ(options.size(), engine::describe().size());
    for (const engine::SettingInfo& info : engine::describe())
        EXPECT_TRUE(std::any_of(options.begin(), options.end(), [&](const auto& option) {
            return option.first.starts_with(std::string(info.key) + "=") && !option.second.empty();
        })) << info.key;
}

TEST(PluginRead, UnknownOptionsAreErrorsThatSuggest) {
    const Game game;
    const std::string level = game.addLevel("room", room());
    expectError(readLevel(level, "acumulation_frames=3"), "accumulation_frames");
    expectError(readLevel(level, "view=baked max_edges=3"), "max_edge");
    expectError(readLevel(level, "view=bakd"), "view");
    expectError(readLevel(level, "max_edge=soon"), "max_edge");
    expectError(readLevel(level, "config=/nonexistent.toml"), "/nonexistent.toml");
    EXPECT_TRUE(readLevel(level, "view=baked").validNode());
}

TEST(PluginRead, OptionsReachTheLevel) {
    const Game game;
    const std::string level = game.addLevel("room", room());
    const auto triangles = [&](const std::string& options) {
        const osg::ref_ptr<osg::Node> node = readNode(level, options);
        firstUpdate(*node);
        return trianglesOf(*node).size();
    };
    EXPECT_EQ(triangles("view=baked"), 12U);
    EXPECT_EQ(triangles("mesh_refinement=0"), 12U);
    EXPECT_GT(triangles("max_edge=16"), 1000U);
    const std::string file = game.folder().write("pie.toml", "max_edge = 16\n");
    EXPECT_EQ(triangles("config=" + file), triangles("max_edge=16"));
    EXPECT_EQ(triangles("mesh_refinement=0 config=" + file), 12U) << "the option string wins over the file";
}

TEST(PluginRead, MissingFilesAreNotFound) {
    const Game game;
    EXPECT_EQ(readLevel(game.path("maps/none.bsp")).status(), Status::FILE_NOT_FOUND);
    EXPECT_EQ(readLevel("none.bsp").status(), Status::FILE_NOT_FOUND);
    EXPECT_EQ(readLevel(game.path("none.pk3/maps/none.bsp")).status(), Status::FILE_NOT_FOUND);
    EXPECT_FALSE(readLevel("").validNode());
}

TEST(PluginRead, OtherExtensionsAreLeftToOthers) {
    usePlugin();
    ReaderWriter* reader = osgDB::Registry::instance()->getReaderWriterForExtension("bsp");
    ASSERT_NE(reader, nullptr);
    const Game game;
    EXPECT_EQ(reader->readNode(game.folder().write("level.obj", "v 0 0 0\n"), nullptr).status(),
              Status::FILE_NOT_HANDLED);
    EXPECT_TRUE(reader->readNode(game.addLevel("room", room()), nullptr).validNode()) << "without any options";
    EXPECT_TRUE(reader->readObject(game.addLevel("room", room()), nullptr).validNode());
}

/// A cube of 256 units seen from inside, as an editor writes it: six slabs around it.
std::string mapOfARoom() {
    std::string text = "{\n\"classname\" \"worldspawn\"\n";
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1}) {
            // Faces of the slab: p0 - p1 and p2 - p1 run along the two other axes.
            text += "{\n";
            for (int k = 0; k < 3; ++k)
                for (const int end : {-1, 1}) {
                    int at = 144 * end;
                    if (k == axis) at = end == side ? 144 * side : 128 * side;
                    std::array<std::array<int, 3>, 3> points{};
                    for (auto& point : points) point.at(static_cast<std::size_t>(k)) = at;
                    points[0].at(static_cast<std::size_t>((k + 1) % 3)) = 64;
                    points[2].at(static_cast<std::size_t>((k + 2) % 3)) = 64 * end;
                    for (const auto& point : points)
                        text += "( " + std::to_string(point[0]) + " " + std::to_string(point[1]) + " " +
                                std::to_string(point[2]) + " ) ";
                    text += "t/wall 0 0 0 0.5 0.5 0 0 0\n";
                }
            text += "}\n";
        }
    return text + "}\n{\n\"classname\" \"light\"\n\"origin\" \"0 0 0\"\n}\n";
}

TEST(PluginRead, MapTextIsReadByItsOwnPlugin) {
    const Game game;
    const std::string file = game.folder().write("maps/room.map", mapOfARoom());
    ReaderWriter::ReadResult result = readLevel(file, "view=light max_edge=64");
    ASSERT_TRUE(result.validNode()) << result.message();
    EXPECT_NEAR(areaOf(trianglesOf(*result.getNode())), 6 * 256.0 * 256, 1);
    ReaderWriter::ReadResult plain = readLevel(file, "view=baked");
    ASSERT_TRUE(plain.validNode());
    EXPECT_EQ(trianglesOf(*plain.getNode()).size(), 12U);
    ReaderWriter::ReadResult bad =
        readLevel(game.folder().write("maps/bad.map", "{\n\"classname\" \"worldspawn\"\n}\n"));
    EXPECT_EQ(bad.status(), Status::ERROR_IN_READING_FILE);
    EXPECT_THAT(bad.message(), AllOf(HasSubstr("[map] "), HasSubstr("bad.map"), HasSubstr("no worldspawn with brushes"),
                                     Not(HasSubstr("\n"))));
}

TEST(PluginRead, DamagedFilesAreOneClearLine) {
    const Game game;
    const std::string whole = fileOf(room());
    expectError(readLevel(game.folder().write("maps/empty.bsp", "")), "empty.bsp");
    expectError(readLevel(game.folder().write("maps/text.bsp", "this is no level")), "text.bsp");
    for (const char* magic :
         {"IBSP\x2f", "RBSP\x01", "FBSP\x01", "IBSP\x26"}) { // NOLINT(modernize-raw-string-literal): bytes
        std::string other = whole;
        other.replace(0, 5, magic);
        expectError(readLevel(game.folder().write("maps/other.bsp", other)), "other.bsp");
    }
    for (std::size_t size = 0; size < whole.size(); size += 997) {
        SCOPED_TRACE(size);
        expectError(readLevel(game.folder().write("maps/cut.bsp", whole.substr(0, size))), "cut.bsp");
    }
}

TEST(PluginRead, WildIndicesAreErrorsNotCrashes) {
    const auto damaged = [](const std::function<void(level::Bsp&)>& damage) {
        level::Bsp bsp = room();
        damage(bsp);
        return bsp;
    };
    const std::vector<level::Bsp> levels{damaged([](auto& b) { b.meshVertices[0] = 1 << 30; }),
                                         damaged([](auto& b) { b.meshVertices[0] = -5; }),
                                         damaged([](auto& b) { b.faces[0].firstVertex = 1 << 30; }),
                                         damaged([](auto& b) { b.faces[0].vertexCount = -1; }),
                                         damaged([](auto& b) { b.faces[0].shader = 77; }),
                                         damaged([](auto& b) {
                                             b.lightmaps.resize(1);
                                             b.faces[0].lightmap = 1000;
                                         }),
                                         damaged([](auto& b) { b.faces[0].meshVertexCount = 1 << 30; }),
                                         damaged([](auto& b) {
                                             b.faces[0].type = level::BspFaceType::Patch;
                                             b.faces[0].patchSize = {1 << 15, 1 << 15};
                                         }),
                                         damaged([](auto& b) { b.models[0].faceCount = 1 << 30; }),
                                         damaged([](auto& b) { b.nodes[0].plane = 1 << 30; })};
    const Game game;
    for (const level::Bsp& bsp : levels) expectError(readLevel(game.addLevel("bad", bsp)), "bad.bsp");
}

TEST(PluginRead, SearchPathOfTheOptionsIsUsed) {
    const Game game;
    static_cast<void>(game.addLevel("searched", room()));
    game.addPicture("t/wall", {10, 200, 30, 255});
    const osg::ref_ptr options = new osgDB::Options("view=baked");
    options->setObjectCacheHint(osgDB::Options::CACHE_NONE);
    options->getDatabasePathList().push_back(game.path("maps"));
    usePlugin();
    auto result = osgDB::Registry::instance()->readNode("searched.bsp", options);
    ASSERT_TRUE(result.validNode()) << result.message();
    EXPECT_EQ(trianglesOf(*result.getNode()).size(), 12U) << "found and not empty";
    const osg::Texture2D* texture = textureOf(*stateSet(*result.getNode(), "t/wall"));
    ASSERT_NE(texture, nullptr);
    EXPECT_NEAR(static_cast<double>(texture->getImage()->getColor(0U, 0U).g()), 200.0 / 255, 1e-3)
        << "textures beside the level that was found";
}

TEST(PluginRead, RegistrySearchPathIsUsed) {
    const Game game;
    static_cast<void>(game.addLevel("registered", room()));
    usePlugin();
    auto& paths = osgDB::Registry::instance()->getDataFilePathList();
    paths.push_front(game.path("maps"));
    const auto node = readNode("registered.bsp", "view=baked");
    paths.pop_front();
    ASSERT_TRUE(node);
    EXPECT_EQ(trianglesOf(*node).size(), 12U);
}

TEST(PluginRead, GameOptionNamesMapsByThemselves) {
    const Game game;
    static_cast<void>(game.addLevel("room", room()));
    const std::string options = "view=baked game=" + game.folder().path().string();
    EXPECT_EQ(trianglesOf(*readNode("room.bsp", options)).size(), 12U);
    EXPECT_EQ(trianglesOf(*readNode("maps/room.bsp", options)).size(), 12U);
    expectError(readLevel("hall.bsp", options), "hall");
}

TEST(PluginRead, StreamsAreRead) {
    usePlugin();
    ReaderWriter* reader = osgDB::Registry::instance()->getReaderWriterForExtension("bsp");
    ASSERT_NE(reader, nullptr);
    const std::string file = fileOf(room());
    const osg::ref_ptr options = new osgDB::Options("view=baked");
    std::istringstream stream(file);
    auto result = reader->readNode(stream, options);
    ASSERT_TRUE(result.validNode()) << result.message();
    EXPECT_EQ(trianglesOf(*result.getNode()).size(), 12U);
    std::istringstream again(file);
    EXPECT_TRUE(reader->readObject(again, nullptr).validNode());
    std::istringstream cut(file.substr(0, file.size() / 2));
    expectError(reader->readNode(cut, options), "");
    std::istringstream nothing;
    expectError(reader->readNode(nothing, options), "");
}

TEST(PluginRead, TwoReadsAreTwoEqualLevels) {
    const Game game;
    const std::string level = game.addLevel("room", room());
    const auto first = readNode(level);
    const auto second = readNode(level);
    ASSERT_TRUE(first && second);
    EXPECT_NE(first, second);
    const auto a = trianglesOf(*first);
    const auto b = trianglesOf(*second);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a[i].place, b[i].place);
        EXPECT_EQ(a[i].material, b[i].material);
    }
}

TEST(PluginRead, FourThreadsReadAtOnce) {
    const Game game;
    const std::string good = game.addLevel("room", room());
    const std::string bad = game.folder().write("maps/bad.bsp", fileOf(room()).substr(0, 900));
    const std::size_t wanted = trianglesOf(*readNode(good)).size();
    std::atomic<int> whole{0};
    std::atomic<int> refused{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < 5; ++i) {
                auto result = readLevel(good, t % 2 == 0 ? "threads=1" : "");
                if (result.validNode() && trianglesOf(*result.getNode()).size() == wanted) ++whole;
                if (readLevel(bad).status() == Status::ERROR_IN_READING_FILE) ++refused;
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(whole, 20);
    EXPECT_EQ(refused, 20);
}

TEST(PluginRead, ValveLevelsReachOsgsOwnReader) {
    if (!stockPluginInstalled()) GTEST_SKIP() << "needs OSG's own bsp plug-in: apt-get install openscenegraph";
    const Game game;
    const std::string valve = game.folder().write("maps/valve.bsp", valveLevel());
    auto result = readLevel(valve, "noRotation"); // options are the other reader's business
    EXPECT_TRUE(result.validNode()) << result.message();
    // What the stock reader refuses is refused with its answer: here a version it does not know.
    std::string newer = valveLevel();
    newer[4] = 21;
    EXPECT_EQ(readLevel(game.folder().write("maps/newer.bsp", newer)).status(), Status::FILE_NOT_HANDLED);

    ReaderWriter* ours = osgDB::Registry::instance()->getReaderWriterForExtension("bsp");
    ASSERT_NE(ours, nullptr);
    EXPECT_STREQ(ours->libraryName(), "osgpie");
    std::istringstream stream(valveLevel());
    EXPECT_NE(ours->readNode(stream, nullptr).status(), Status::ERROR_IN_READING_FILE)
        << "streams are handed on as well, whatever the other reader makes of them";
}

TEST(PluginRead, OsgsOwnReaderNeverSeesQuakeLevels) {
    if (!stockPluginInstalled()) GTEST_SKIP() << "needs OSG's own bsp plug-in: apt-get install openscenegraph";
    const Game game;
    ASSERT_TRUE(readLevel(game.folder().write("maps/valve.bsp", valveLevel())).validNode());
    // The registry asks every reader it has; the stock one makes a crash or an empty scene of these.
    EXPECT_THAT(bspReaders(), testing::SizeIs(1));
    expectError(readLevel(game.folder().write("maps/cut.bsp", fileOf(room()).substr(0, 600))), "cut.bsp");
    EXPECT_EQ(readLevel(game.path("maps/none.bsp")).status(), Status::FILE_NOT_FOUND);
    EXPECT_TRUE(readLevel(game.addLevel("room", room())).validNode());
    ASSERT_TRUE(readLevel(game.path("maps/valve.bsp")).validNode()) << "and Valve's still work";
}
