// What `cmake --install` leaves: a plug-in that OSG finds, programs, and a package that another project builds against.

#include "tests/level/make_level.h"
#include "tests/osg/scene_reading.h"
#include "tests/support/command.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

namespace {

using namespace pie;
using namespace pie::test;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr double patience = 300; // for a compiler on a busy machine

class Installed : public ::testing::Test {
protected:
    void SetUp() override {
        const CommandResult installed = run({CMAKE, "--install", PIE_BUILD, "--prefix", prefix()}, {{}, "", patience});
        ASSERT_EQ(installed.status, 0) << installed.out << installed.err;
        LevelBuilder builder;
        const int wall = builder.shader("t/wall");
        builder.room({-256, -256, -128}, {256, 256, 128}, {wall, wall, wall, wall, wall, wall});
        builder.entity({{"classname", "light"}, {"origin", "0 0 0"}, {"light", "300"}});
        level_ = game_.addLevel("room", builder.build());
    }
    [[nodiscard]] std::string prefix() const { return folder_.path() / "prefix"; }
    [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }
    [[nodiscard]] const std::string& level() const { return level_; }

private:
    TemporaryFolder folder_;
    Game game_;
    std::string level_;
};

/// The number behind "name: " in a program's output.
double numberAfter(const std::string& text, const std::string& name) {
    const std::size_t at = text.find(name + ": ");
    return at == std::string::npos ? -1 : std::strtod(text.c_str() + at + name.size() + 2, nullptr);
}

} // namespace

TEST_F(Installed, PluginLoadsFromItsPlace) {
    const fs::path plugin = fs::path(prefix()) / "lib" / PIE_PLUGIN_FOLDER / "osgdb_bsp.so";
    ASSERT_TRUE(fs::is_regular_file(plugin)) << plugin;
    // Not the one of the build tree: the environment names the installation only.
    const CommandOptions options{{{"OSG_LIBRARY_PATH", prefix() + "/lib"}, {"DISPLAY", ""}}, "", 60};
    const CommandResult formats = run({"osgconv", "--formats", "bsp"}, options);
    if (formats.status == 127) GTEST_SKIP() << "needs osgconv: apt-get install openscenegraph";
    EXPECT_THAT(formats.out, HasSubstr(plugin.string()));
    EXPECT_THAT(formats.out, HasSubstr("photon"));
    const CommandResult converted = run({"osgconv", "-O", "view=baked", level(), path("out.osgt")}, options);
    EXPECT_EQ(converted.status, 0) << converted.err;
    EXPECT_THAT(readText(path("out.osgt")), HasSubstr("t/wall"));
}

TEST_F(Installed, ProgramsRun) {
    const CommandOptions options{{{"OSG_LIBRARY_PATH", ""}, {"DISPLAY", ""}}, "", 60};
    for (const char* name : {"bspinfo", "pieshot"}) {
        const CommandResult help = run({prefix() + "/bin/" + name, "--help"}, options);
        EXPECT_EQ(help.status, 0) << name << ": " << help.err;
    }
    const CommandResult info = run({prefix() + "/bin/bspinfo", level()}, options);
    EXPECT_EQ(info.status, 0) << info.err;
}

TEST_F(Installed, AnotherProjectBuildsAgainstThePackage) {
    const CommandOptions options{{{"OSG_LIBRARY_PATH", ""}, {"DISPLAY", ""}}, "", patience};
    const CommandResult configured =
        run({CMAKE, "-S", PIE_CONSUMER, "-B", path("build"), "-DCMAKE_PREFIX_PATH=" + prefix(),
             "-DCMAKE_BUILD_TYPE=Debug", std::string("-DCMAKE_CXX_COMPILER=") + PIE_COMPILER},
            options);
    ASSERT_EQ(configured.status, 0) << configured.out << configured.err;
    const CommandResult built = run({CMAKE, "--build", path("build")}, options);
    ASSERT_EQ(built.status, 0) << built.out << built.err;
    const CommandResult ran = run({path("build/consumer"), level()}, options);
    ASSERT_EQ(ran.status, 0) << ran.err;
    EXPECT_THAT(ran.out, HasSubstr("light: 1 point"));
    EXPECT_GT(numberAfter(ran.out, "receivers"), 200);
    // All flux ends on 1,048,576 square units: direct light alone is 94,248 · 300 over that, 27 U in the mean.
    constexpr double direct = 94'248.0 * 300 / (2.0 * (512 * 512 + 2 * 512 * 256));
    EXPECT_GT(numberAfter(ran.out, "mean"), 0.5 * direct);
    EXPECT_LT(numberAfter(ran.out, "mean"), 4 * direct);
    EXPECT_NEAR(numberAfter(ran.out, "radius"), 384, 2) << "half of the room's diagonal";
    const CommandResult refused = run({path("build/consumer"), path("none.bsp")}, options);
    EXPECT_EQ(refused.status, 1);
    EXPECT_THAT(refused.err, HasSubstr("none.bsp"));
}
