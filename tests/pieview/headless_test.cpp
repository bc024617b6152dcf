// Pictures and statistics without a window, and what the exit status says.

#include "tests/support/command.h"
#include "tests/support/picture.h"
#include "tests/support/room.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <sstream>

namespace {

using namespace pie::test;
using ::testing::HasSubstr;

/// Without what the level's reader says of its lights.
int ownLines(const std::string& text) {
    int count = 0;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (line.rfind("[bsp] ", 0) != 0) ++count;
    return count;
}

class PieviewHeadless : public ::testing::Test {
protected:
    void SetUp() override {
        writeGame(folder_, "room", makeRoom({}, 64), {{"textures/room/plain", {200, 100, 50, 255}}});
    }
    [[nodiscard]] CommandResult pieview(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), PIEVIEW);
        return run(arguments,
                   {{{"DISPLAY", ""}, {"OSG_NOTIFY_LEVEL", ""}, {"XDG_CONFIG_HOME", path("config")}}, "", 120});
    }
    [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }
    [[nodiscard]] std::string level() const { return path("maps/room.bsp"); }
    TemporaryFolder folder_;
};

TEST_F(PieviewHeadless, TakesAPictureInBytesAndInFloats) {
    const std::vector<std::string> common{level(), "--size", "64x48", "--mode", "fullbright", "--camera", "0 0 0 90 0"};
    auto png = common;
    png.insert(png.end(), {"--screenshot", path("out.png"), "--frames", "1"});
    const CommandResult result = pieview(png);
    ASSERT_EQ(result.status, 0) << result.err;
    const Picture picture = readPicture(path("out.png"));
    ASSERT_EQ(picture.width, 64);
    EXPECT_EQ(picture.rgb[0], 200);
    EXPECT_EQ(picture.rgb[2], 50);

    auto exr = common;
    exr.insert(exr.end(), {"--screenshot", path("out.exr"), "--mode", "baked", "--set", "overbright_clamp=4"});
    exr.erase(std::find(exr.begin(), exr.end(), "fullbright") - 1, std::find(exr.begin(), exr.end(), "fullbright") + 1);
    ASSERT_EQ(pieview(exr).status, 0);
    const auto input = OIIO::ImageInput::open(path("out.exr"));
    ASSERT_TRUE(input);
    const OIIO::ImageSpec& spec = input->spec();
    ASSERT_EQ(spec.width, 64);
    ASSERT_EQ(spec.height, 48);
    EXPECT_EQ(spec.channelnames, (std::vector<std::string>{"R", "G", "B"}));
    std::vector<float> pixels(std::size_t{3} * 64 * 48);
    ASSERT_TRUE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, pixels.data()));
    // Byte 64 of a lightmap is 1.004 times the texture.
    EXPECT_NEAR(pixels[0], 200 / 255.0 * 64 * 4 / 255, 0.01);
    EXPECT_NEAR(pixels[2], 50 / 255.0 * 64 * 4 / 255, 0.01);
}

TEST_F(PieviewHeadless, PrintsStatisticsAndNothingElse) {
    const CommandResult result =
        pieview({level(), "--stats", "json", "--set", "photons_from_light=1000", "--set", "still_frames=3"});
    ASSERT_EQ(result.status, 0) << result.err;
    const auto statistics = nlohmann::json::parse(result.out);
    EXPECT_EQ(statistics["photons_emitted"], 3000);
    EXPECT_EQ(statistics["unfinished"], 0);
    EXPECT_TRUE(statistics["still"].get<bool>());
    EXPECT_GT(statistics["load_ms"].get<double>(), 0);
}

TEST_F(PieviewHeadless, StatusSaysWhatHappened) {
    const std::string whole = readText(level());
    const std::string half = folder_.write("maps/half.bsp", whole.substr(0, whole.size() / 2));
    const std::string out = path("no.png");
    struct Case {
        std::vector<std::string> arguments;
        int status;
        std::string words;
    };
    const std::vector<Case> cases{
        {{path("maps/none.bsp"), "--screenshot", out}, 1, "none.bsp"},
        {{half, "--screenshot", out}, 1, "half.bsp"},
        {{level(), "--screenshot", path("missing/out.png"), "--frames", "1"}, 1, "out.png"},
        {{level(), "--screenshot", out, "--path", "3"}, 1, "no path is recorded"},
        {{level(), "--screenshot", path("out.gif")}, 2, ".png or .exr"},
        {{level(), "--screenshot", out, "--set", "exposre=2"}, 2, "did you mean exposure?"},
        {{level(), "--screenshot", out, "--mode", "pretty"}, 2, "split"},
        {{level(), "--screenshot", out, "--camera", "1 2"}, 2, "--camera"},
        {{level(), "--screenshot", out, "--size", "10x"}, 2, "--size"},
        {{"x.txt", "--screenshot", out}, 2, ".bsp and .map"},
        {{}, 2, "--help"},
        {{level()}, 1, "--screenshot"},
    };
    for (const Case& c : cases) {
        const CommandResult result = pieview(c.arguments);
        EXPECT_EQ(result.status, c.status) << c.words << ": " << result.err;
        EXPECT_THAT(result.err, HasSubstr(c.words));
        EXPECT_EQ(ownLines(result.err), 1) << result.err;
        EXPECT_FALSE(std::filesystem::exists(out)) << c.words;
    }
    EXPECT_EQ(pieview({"--help"}).status, 0);
}

} // namespace
