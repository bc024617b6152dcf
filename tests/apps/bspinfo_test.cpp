#include "tests/support/command.h"
#include "tests/support/files.h"
#include "tests/support/room.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace {

using pie::test::CommandResult;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::json;

CommandResult bspinfo(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), BSPINFO);
    return pie::test::run(arguments);
}

/// A room with a textured, an untextured and a flare-only shader.
class Bspinfo : public ::testing::Test {
protected:
    Bspinfo() {
        pie::test::Room room;
        room.shaders[0] = "textures/room/gone";
        pie::test::writeGame(folder_, "room", pie::test::makeRoom(room));
    }
    [[nodiscard]] std::string game() const { return folder_.path().string(); }
    [[nodiscard]] std::string level() const { return game() + "/maps/room.bsp"; }
    [[nodiscard]] const pie::test::TemporaryFolder& folder() const { return folder_; }

private:
    pie::test::TemporaryFolder folder_;
};

TEST_F(Bspinfo, JsonSaysWhatTheRoomIs) {
    const CommandResult result = bspinfo({level(), "--json"});
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_THAT(result.err, IsEmpty());
    const Json json = Json::parse(result.out);
    EXPECT_EQ(json["level"], "room");
    EXPECT_EQ(json["file"], level());
    EXPECT_THAT(json["dialect"].get<std::string>(), HasSubstr("IBSP 46"));
    EXPECT_EQ(json["lumps"]["faces"], 6);
    EXPECT_EQ(json["lumps"]["vertices"], 24);
    EXPECT_EQ(json["lumps"].size(), 17U);
    EXPECT_EQ(json["faces"], Json({{"polygons", 6}, {"patches", 0}, {"models", 0}, {"flares", 0}}));
    EXPECT_EQ(json["drawn"]["triangles"], 12);
    EXPECT_DOUBLE_EQ(json["drawn"]["area"].get<double>(), 6.0 * 512 * 512);
    EXPECT_EQ(json["drawn"]["bounds"], Json({{-256, -256, -256}, {256, 256, 256}}));
    EXPECT_EQ(json["lightmaps"], Json({{"count", 1}, {"external", 0}}));
    EXPECT_EQ(json["lights"]["count"]["point"], 1);
    EXPECT_EQ(json["lights"]["count"]["area"], 0);
    EXPECT_FALSE(json["lights"]["fallback"].get<bool>());
    // 4 pi * 7500 * 300 watts in every channel.
    for (const Json& channel : json["lights"]["power_watts"]["point"])
        EXPECT_NEAR(channel.get<double>(), 28'274'334.0, 1e3);
    EXPECT_EQ(json["textures"]["found"]["textures/room/plain"], "textures/room/plain.png");
    EXPECT_EQ(json["textures"]["missing"], Json({"textures/room/gone"}));
    EXPECT_GT(json["milliseconds"]["total"].get<double>(), 0.0);
}

TEST_F(Bspinfo, TextSaysTheSame) {
    const CommandResult result = bspinfo({"--game", game(), "--map", "room"});
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_THAT(result.out, AllOf(HasSubstr("6: 6 polygons, 0 patches, 0 models, 0 flares"),
                                  HasSubstr("12 triangles, 1572864 square units, (-256 -256 -256) to (256 256 256)"),
                                  HasSubstr("1 point; from entities"), HasSubstr("missing: textures/room/gone")));
}

TEST_F(Bspinfo, FindsTexturesInMoreDirectories) {
    const pie::test::TemporaryFolder base;
    pie::test::writeGame(base, "other", pie::test::makeRoom(), {{"textures/room/gone", {9, 9, 9, 255}}});
    const CommandResult result = bspinfo({level(), "--textures", base.path().string(), "--json"});
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(Json::parse(result.out)["textures"]["missing"], Json::array());
}

TEST_F(Bspinfo, UnreadableLevelsAreOneLineAndStatusOne) {
    const std::string whole = pie::test::readText(level());
    for (const std::string& path : {game() + "/maps/none.bsp", folder().write("maps/empty.bsp", ""),
                                    folder().write("maps/text.bsp", "not a level"),
                                    folder().write("maps/half.bsp", whole.substr(0, whole.size() / 2))}) {
        const CommandResult result = bspinfo({path, "--json"});
        EXPECT_EQ(result.status, 1) << path;
        EXPECT_THAT(result.out, IsEmpty()) << path;
        EXPECT_TRUE(result.err.starts_with("bspinfo: ")) << result.err;
        EXPECT_THAT(result.err, HasSubstr(path));
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    }
}

TEST_F(Bspinfo, WrongArgumentsAreOneLineAndStatusTwo) {
    const std::vector<std::vector<std::string>> wrong{
        {}, {"--jsn", level()}, {level(), "--map", "room"}, {level(), level()}, {"--game"}};
    for (const std::vector<std::string>& arguments : wrong) {
        const CommandResult result = bspinfo(arguments);
        EXPECT_EQ(result.status, 2) << result.err;
        EXPECT_THAT(result.out, IsEmpty());
        EXPECT_TRUE(result.err.starts_with("bspinfo: ")) << result.err;
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    }
}

TEST(BspinfoHelp, HasExamplesAndExitStatus) {
    const CommandResult result = bspinfo({"--help"});
    EXPECT_EQ(result.status, 0);
    EXPECT_THAT(result.out, AllOf(HasSubstr("Examples:"), HasSubstr("--map oa_dm1"), HasSubstr("Exit status")));
}

} // namespace
