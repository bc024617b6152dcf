// Programs that users run: OSG's own osgviewer and osgconv with nothing but our plug-in, and pieshot.

#include "tests/level/make_level.h"
#include "tests/osg/offscreen.h"
#include "tests/osg/scene_reading.h"
#include "tests/support/command.h"
#include "tests/support/picture.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <osgDB/ReadFile>
#include <osgGA/TrackballManipulator>

#include <algorithm>
#include <filesystem>

namespace {

using namespace pie;
using namespace pie::test;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr int notInstalled = 127;

class Tools : public ::testing::Test {
protected:
    void SetUp() override {
        game_.addPicture("t/floor", {200, 100, 50, 255});
        game_.addPicture("t/plain", {160, 160, 160, 255});
        game_.addScript("t/sky\n{\nsurfaceparm sky\nskyParms - 512 -\n{\nmap t/plain.tga\ntcMod scroll 0.1 0\n}\n}\n"
                        "t/lamp\n{\nq3map_surfacelight 900\n{\nanimMap 2 t/plain.tga t/floor.tga\n}\n}\n"
                        "t/flare\n{\ndeformVertexes autosprite\n{\nmap t/plain.tga\nblendFunc add\n}\n}\n"
                        "t/fence\n{\ncull none\n{\nmap t/plain.tga\nalphaFunc GE128\n}\n{\nmap $lightmap\nblendFunc "
                        "filter\n}\n}\n");
        LevelBuilder builder;
        const int plain = builder.shader("t/plain");
        builder.room({-256, -256, -128}, {256, 256, 128},
                     {plain, plain, plain, builder.shader("t/sky"), builder.shader("t/floor"), plain}, 0);
        builder.polygon(builder.shader("t/lamp"), {{-32, 32, 127}, {32, 32, 127}, {32, -32, 127}, {-32, -32, 127}});
        builder.polygon(builder.shader("t/flare"), {{64, 60, 0}, {80, 60, 0}, {80, 60, 16}, {64, 60, 16}});
        builder.polygon(builder.shader("t/fence"), {{-96, 60, -64}, {-32, 60, -64}, {-32, 60, 0}, {-96, 60, 0}}, 0);
        builder.entity({{"classname", "light"}, {"origin", "0 -64 64"}, {"light", "300"}});
        builder.entity({{"classname", "info_player_start"}, {"origin", "0 -200 -60"}, {"angle", "90"}});
        builder.raw().lightmaps.emplace_back().fill(48);
        level_ = game_.addLevel("room", builder.build());
    }
    [[nodiscard]] const std::string& level() const { return level_; }
    [[nodiscard]] const Game& game() const { return game_; }
    [[nodiscard]] std::string path(const std::string& name) const { return game_.path(name); }
    /// pieshot at a small size with few photons.
    [[nodiscard]] CommandResult pieshot(std::vector<std::string> arguments, const std::string& display = {}) const {
        arguments.insert(arguments.begin(), PIESHOT);
        for (const char* more : {"--width", "160", "--height", "120", "--set", "photons_from_light=1000", "--set",
                                 "accumulation_frames=3"})
            arguments.emplace_back(more);
        return run(arguments, {pluginEnvironment(display), "", 120});
    }

private:
    Game game_;
    std::string level_;
};

const std::vector<std::string> threadingModels{"SingleThreaded", "CullDrawThreadPerContext", "DrawThreadPerContext",
                                               "CullThreadPerCameraDrawThreadPerContext"};

int spread(const Picture& picture) {
    const auto [least, most] = std::minmax_element(picture.rgb.begin(), picture.rgb.end());
    return picture.empty() ? 0 : *most - *least;
}

std::ptrdiff_t lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

} // namespace

TEST_F(Tools, OsgconvListsTheOptions) {
    const CommandResult result = run({"osgconv", "--formats", "bsp"}, {pluginEnvironment(), "", 60});
    if (result.status == notInstalled) GTEST_SKIP() << "needs osgconv: apt-get install openscenegraph";
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_THAT(result.out, AllOf(HasSubstr("view=lit|baked|fullbright|light"),
                                  HasSubstr("photons_from_light=<integer>"), HasSubstr("max_edge=<number>")));
}

TEST_F(Tools, CompiledMapsAreReadByOsgsOwnReader) {
    for (const char* name : {"small", "normal", "curves"}) {
        SCOPED_TRACE(name);
        const std::string bsp = path(std::string(name) + ".bsp");
        const std::string map = std::string(PIE_LEVELS) + "/maps/" + name + ".map";
        const CommandResult compiled = run({MAPLEVEL, map, bsp}, {{}, "", 60});
        ASSERT_EQ(compiled.status, 0) << compiled.err;
        EXPECT_EQ(compiled.err, "");
        const CommandResult result = run({"osgconv", bsp, path("stock.osgb")}, {{{"OSG_LIBRARY_PATH", ""}}, "", 60});
        if (result.status == notInstalled) GTEST_SKIP() << "needs osgconv: apt-get install openscenegraph";
        EXPECT_EQ(result.status, 0) << result.err;
        EXPECT_THAT(readText(path("stock.osgb")), HasSubstr("osg::Geometry"));
        const CommandResult again = run({MAPLEVEL, map, path("none/x.bsp")}, {{}, "", 60});
        EXPECT_EQ(again.status, 1);
        EXPECT_THAT(again.err, HasSubstr("cannot be written"));
    }
}

TEST_F(Tools, OsgconvWritesAStaticSceneWithoutWarnings) {
    const double area = areaOf(trianglesOf(*readNode(level(), "view=baked")));
    for (const char* options : {"settle=true photons_from_light=500", "view=baked", "view=lit"})
        for (const char* extension : {"osgt", "osgb", "ive"}) {
            SCOPED_TRACE(std::string(options) + " ." + extension);
            const std::string out = path(std::string("out.") + extension);
            const CommandResult result = run({"osgconv", "-O", options, level(), out}, {pluginEnvironment(), "", 120});
            if (result.status == notInstalled) GTEST_SKIP() << "needs osgconv: apt-get install openscenegraph";
            EXPECT_EQ(result.status, 0);
            EXPECT_EQ(result.out, "Data written to '" + out + "'.\n");
            EXPECT_THAT(result.err, IsEmpty());
            const osg::ref_ptr<osg::Node> node = osgDB::readRefNodeFile(out);
            ASSERT_TRUE(node);
            EXPECT_NEAR(areaOf(trianglesOf(*node)), area, 1e-3 * area);
            EXPECT_NE(textureOf(*stateSet(*node, "t/floor"))->getImage(), nullptr) << "pictures are in the file";
            std::filesystem::remove(out);
        }
}

TEST_F(Tools, ConvertedLevelsLookLikeTheLevel) {
    PIE_NEED_DISPLAY();
    const Shot shot = lookingAt({0, -200, 0}, {0, 0, -20});
    for (const char* options : {"view=baked animate=false", "settle=true animate=false photons_from_light=1000"}) {
        const std::string out = path("out.osgb");
        const CommandResult result = run({"osgconv", "-O", options, level(), out}, {pluginEnvironment(), "", 120});
        if (result.status == notInstalled) GTEST_SKIP() << "needs osgconv: apt-get install openscenegraph";
        const osg::ref_ptr<osg::Node> converted = osgDB::readRefNodeFile(out);
        ASSERT_TRUE(converted);
        const Picture direct = render(*readNode(level(), options), shot);
        EXPECT_GT(spread(direct), 30);
        EXPECT_TRUE(similar(render(*converted, shot), direct, 0.1, "converted"));
    }
}

TEST_F(Tools, OsgviewerShowsALevelWithoutWarnings) {
    PIE_NEED_DISPLAY();
    for (const std::string& threading : threadingModels) {
        auto environment = pluginEnvironment(ownDisplay());
        environment.insert(
            environment.end(),
            {{"OSG_RUN_FRAME_COUNT", "20"}, {"OSG_WINDOW", "0 0 160 120"}, {"OSG_THREADING", threading}});
        const CommandResult result = run({"osgviewer", level()}, {environment, "", 120});
        if (result.status == notInstalled) GTEST_SKIP() << "needs osgviewer: apt-get install openscenegraph";
        EXPECT_EQ(result.status, 0) << threading;
        // What was found is printed; nothing else.
        EXPECT_THAT(result.out + result.err, StartsWith("[bsp] room: light: 1 point, "));
        EXPECT_EQ(lines(result.out + result.err), 1) << result.out << result.err;
    }
}

TEST_F(Tools, OsgviewerSaysInOneLineWhatIsWrong) {
    const std::string cut = game().folder().write("maps/cut.bsp", readText(level()).substr(0, 3000));
    const CommandResult result = run({"osgviewer", cut}, {pluginEnvironment(), "", 60});
    if (result.status == notInstalled) GTEST_SKIP() << "needs osgviewer: apt-get install openscenegraph";
    EXPECT_NE(result.status, 0);
    const std::string said = result.out + result.err;
    EXPECT_THAT(said, AllOf(HasSubstr("[bsp] "), HasSubstr("cut.bsp")));
    const CommandResult wrong = run({"osgviewer", "-O", "veiw=lit", level()}, {pluginEnvironment(), "", 60});
    EXPECT_NE(wrong.status, 0);
    EXPECT_THAT(wrong.out + wrong.err, HasSubstr("view"));
}

TEST_F(Tools, AViewersHomeIsTheFirstPlayerStart) {
    PIE_NEED_DISPLAY();
    osgViewer::Viewer viewer;
    viewer.setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
    viewer.getCamera()->setGraphicsContext(makeContext(64, 64));
    viewer.getCamera()->setViewport(new osg::Viewport(0, 0, 64, 64));
    const osg::ref_ptr manipulator = new osgGA::TrackballManipulator;
    viewer.setCameraManipulator(manipulator);
    viewer.setSceneData(readNode(level(), "view=baked"));
    for (int i = 0; i < 3; ++i) viewer.frame();
    osg::Vec3d eye;
    osg::Vec3d centre;
    osg::Vec3d up;
    viewer.getCamera()->getViewMatrixAsLookAt(eye, centre, up);
    EXPECT_NEAR(eye.x(), 0, 1);
    EXPECT_NEAR(eye.y(), -200, 1);
    EXPECT_NEAR(eye.z(), -60, 40) << "at the height of eyes";
    osg::Vec3d ahead = centre - eye;
    ahead.normalize();
    EXPECT_GT(ahead.y(), 0.99);
    // An application that has set a home of its own keeps it.
    const osg::ref_ptr own = new osgGA::TrackballManipulator;
    own->setHomePosition({10, 20, 30}, {40, 20, 30}, {0, 0, 1});
    own->setAutoComputeHomePosition(false);
    viewer.setCameraManipulator(own);
    viewer.setSceneData(readNode(level(), "view=baked"));
    for (int i = 0; i < 3; ++i) viewer.frame();
    viewer.getCamera()->getViewMatrixAsLookAt(eye, centre, up);
    EXPECT_NEAR(eye.x(), 10, 1);
}

TEST_F(Tools, PieshotStartsItsOwnDisplay) {
    const CommandResult result = pieshot({level(), path("shot.png"), "--stats"});
    if (result.err.find("Xvfb") != std::string::npos) GTEST_SKIP() << noDisplay;
    ASSERT_EQ(result.status, 0) << result.err;
    const Picture picture = readPicture(path("shot.png"));
    EXPECT_EQ(picture.width, 160);
    EXPECT_EQ(picture.height, 120);
    EXPECT_GT(spread(picture), 30);
    const std::size_t brace = result.out.find('{');
    ASSERT_NE(brace, std::string::npos) << result.out;
    const auto statistics = nlohmann::json::parse(result.out.substr(brace), nullptr, false);
    ASSERT_FALSE(statistics.is_discarded()) << result.out;
    EXPECT_EQ(statistics["photons_emitted"], 100'000) << "still_frames of them";
    EXPECT_GT(statistics["estimates_made"].get<int>(), 0);
    EXPECT_EQ(lines(result.out.substr(brace)), 1) << "one line of JSON";
}

TEST_F(Tools, PieshotDrawsTheSameUnderEveryThreadingModel) {
    PIE_NEED_DISPLAY();
    Picture reference;
    for (const std::string& threading : threadingModels)
        for (const bool optimize : {false, true}) {
            const std::string out = path("shot.png");
            std::vector<std::string> arguments{level(), out, "--set", "animate=false", "--threading", threading};
            if (optimize) arguments.emplace_back("--optimize");
            const CommandResult result = pieshot(arguments, ownDisplay());
            ASSERT_EQ(result.status, 0) << result.err;
            const Picture picture = readPicture(out);
            ASSERT_FALSE(picture.empty());
            if (reference.empty()) reference = picture;
            const PictureDifference off = difference(picture, reference);
            EXPECT_LE(off.largest, 1) << threading << (optimize ? ", optimized" : "");
        }
    EXPECT_GT(spread(reference), 30);
}

TEST_F(Tools, PieshotCameraLooksWhereItIsTold) {
    PIE_NEED_DISPLAY();
    const std::string out = path("shot.png");
    const auto middle = [&](const std::string& camera) {
        const CommandResult result =
            pieshot({level(), out, "--set", "view=fullbright", "--camera", camera, "--fov", "60"}, ownDisplay());
        EXPECT_EQ(result.status, 0) << result.err;
        const Picture picture = readPicture(out);
        if (picture.empty()) return std::array<int, 3>{};
        const std::uint8_t* p = &picture.rgb[std::size_t{3} * (60 * 160 + 80)];
        return std::array<int, 3>{p[0], p[1], p[2]};
    };
    EXPECT_EQ(middle("100 0 0 0 90"), (std::array<int, 3>{200, 100, 50})) << "pitch is positive downwards";
    EXPECT_EQ(middle("-200 -100 0 180 0"), (std::array<int, 3>{160, 160, 160}));
}

TEST_F(Tools, PieshotRefusesInOneLine) {
    const std::string out = path("none.png");
    const std::vector<std::vector<std::string>> wrong{{path("maps/none.bsp"), out},
                                                      {level(), path("none.jpg")},
                                                      {level(), out, "--set", "veiw=lit"},
                                                      {level(), out, "--set", "view=lti"},
                                                      {level(), out, "--camera", "1 2"},
                                                      {level(), path("no/folder/none.png")},
                                                      {game().folder().write("maps/empty.bsp", ""), out}};
    for (const auto& arguments : wrong) {
        const CommandResult result = pieshot(arguments);
        EXPECT_NE(result.status, 0) << result.out;
        EXPECT_LT(result.status, 128) << result.err;
        EXPECT_THAT(result.err, StartsWith("pieshot: "));
        EXPECT_EQ(lines(result.err), 1) << result.err;
        EXPECT_FALSE(std::filesystem::exists(arguments[1]));
    }
}
