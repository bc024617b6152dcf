// Pictures through the plug-in, of rooms whose every pixel is known.

#include "tests/support/command.h"
#include "tests/support/files.h"
#include "tests/support/picture.h"
#include "tests/support/room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace {

using pie::test::CommandResult;
using pie::test::Picture;
using ::testing::HasSubstr;
using Colour = std::array<int, 3>;

constexpr int width = 160;
constexpr int height = 120;

/// Without DISPLAY, so that the program starts a virtual display of its own.
CommandResult pieshot(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), PIESHOT);
    return pie::test::run(arguments, {{{"DISPLAY", ""}, {"OSG_NOTIFY_LEVEL", ""}}, "", 120});
}

/// OSG's messages go to standard output too, before the statistics.
std::string lastLine(const std::string& text) {
    const std::size_t end = text.find_last_not_of('\n');
    if (end == std::string::npos) return {};
    const std::size_t start = text.rfind('\n', end);
    return text.substr(start == std::string::npos ? 0 : start + 1);
}

Colour at(const Picture& picture, double x, double y) {
    const auto column = static_cast<std::size_t>(x * picture.width);
    const auto row = static_cast<std::size_t>(y * picture.height);
    const std::size_t first = 3 * (row * static_cast<std::size_t>(picture.width) + column);
    return {picture.rgb.at(first), picture.rgb.at(first + 1), picture.rgb.at(first + 2)};
}

void expectColour(const Colour& seen, const Colour& wanted, int tolerance, const std::string& what) {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(seen.at(i), wanted.at(i), tolerance) << what << ", channel " << i;
}

/// A room with a colour of its own on every wall.
class Pieshot : public ::testing::Test {
protected:
    explicit Pieshot(std::uint8_t lightmapByte = 64) {
        pie::test::Room room;
        std::vector<std::pair<std::string, pie::Rgba8>> textures;
        for (std::size_t i = 0; i < room.shaders.size(); ++i) {
            room.shaders.at(i) = "textures/room/wall" + std::to_string(i);
            const Colour& c = colours.at(i);
            textures.emplace_back(room.shaders.at(i), pie::Rgba8(c[0], c[1], c[2], 255));
        }
        pie::test::writeGame(folder_, "room", pie::test::makeRoom(room, lightmapByte), textures);
    }

    /// Takes a picture from the middle of the room, looking along +y.
    Picture shoot(std::vector<std::string> more, CommandResult* said = nullptr, int pitch = 0) {
        const std::string file = folder_.path() / "shot.png";
        std::vector<std::string> arguments{level(),    file,
                                           "--camera", "0 0 0 90 " + std::to_string(pitch),
                                           "--width",  std::to_string(width),
                                           "--height", std::to_string(height),
                                           "--fov",    "120"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const CommandResult result = pieshot(arguments);
        EXPECT_EQ(result.status, 0) << result.err;
        if (said != nullptr) *said = result;
        Picture picture = pie::test::readPicture(file);
        EXPECT_EQ(picture.width, width);
        EXPECT_EQ(picture.height, height);
        if (picture.empty()) picture = {1, 1, {0, 0, 0}};
        return picture;
    }
    /// Left, right, ahead, below and above of the middle.
    static void expectWalls(const Picture& picture, double factor, int tolerance) {
        const auto scaled = [&](std::size_t wall) {
            Colour c = colours.at(wall);
            for (int& channel : c) channel = static_cast<int>(std::lround(channel * factor));
            return c;
        };
        expectColour(at(picture, 0.05, 0.5), scaled(0), tolerance, "left: the -x wall");
        expectColour(at(picture, 0.95, 0.5), scaled(1), tolerance, "right: the +x wall");
        expectColour(at(picture, 0.5, 0.5), scaled(3), tolerance, "ahead: the +y wall");
    }

    [[nodiscard]] std::string level() const { return folder_.path() / "maps/room.bsp"; }
    [[nodiscard]] const pie::test::TemporaryFolder& folder() const { return folder_; }

    static constexpr std::array<Colour, 6> colours{
        {{200, 40, 40}, {40, 200, 40}, {120, 120, 120}, {40, 40, 200}, {160, 160, 40}, {160, 40, 160}}};

private:
    pie::test::TemporaryFolder folder_;
};

class PieshotHalfLit : public Pieshot {
protected:
    PieshotHalfLit() : Pieshot(32) {}
};

TEST_F(Pieshot, FullbrightShowsTheTexturesAndIsNotMirrored) {
    expectWalls(shoot({"--set", "view=fullbright"}), 1.0, 1);
}

TEST_F(Pieshot, PitchPointsDownwards) {
    const Picture down = shoot({"--set", "view=fullbright"}, nullptr, 80);
    expectColour(at(down, 0.5, 0.5), colours[4], 1, "below: the -z wall");
    const Picture up = shoot({"--set", "view=fullbright"}, nullptr, -80);
    expectColour(at(up, 0.5, 0.5), colours[5], 1, "above: the +z wall");
}

// Byte 64 of a lightmap shows the texture as it is, 32 half of it.
TEST_F(Pieshot, BakedByte64ShowsTheTexture) { expectWalls(shoot({"--set", "view=baked"}), 64 * 4 / 255.0, 2); }
TEST_F(PieshotHalfLit, BakedByte32ShowsHalfTheTexture) {
    expectWalls(shoot({"--set", "view=baked"}), 32 * 4 / 255.0, 2);
}

TEST_F(Pieshot, LitIsOurLightAndTheStatisticsSayHow) {
    CommandResult said;
    const Picture lit = shoot({"--stats", "--set", "photons_from_light=1000", "--set", "max_edge=64"}, &said);
    const Colour ahead = at(lit, 0.5, 0.5);
    EXPECT_GT(ahead[2], 20);
    EXPECT_GT(ahead[2], 2 * ahead[0]);
    const auto statistics = nlohmann::json::parse(lastLine(said.out));
    EXPECT_EQ(statistics["photons_emitted"], 100'000) << "still_frames of them";
    EXPECT_EQ(statistics["unfinished"], 0);
    EXPECT_EQ(statistics["lights"], 1);
    EXPECT_GT(statistics["photons_stored"].get<int>(), 0);
    EXPECT_EQ(statistics["photons_escaped"], 0) << "the room is closed";
    EXPECT_GT(statistics["direct_rays"].get<int>(), 0);
    EXPECT_THAT(said.out + said.err, HasSubstr("1 point; from entities"));
}

TEST_F(Pieshot, SameSeedSamePicture) {
    const std::vector<std::string> arguments{"--set", "photons_from_light=2000", "--set", "seed=5"};
    std::vector<std::string> oneThread = arguments;
    oneThread.insert(oneThread.end(), {"--set", "threads=1"});
    std::vector<std::string> otherSeed = arguments;
    otherSeed.back() = "seed=6";
    const Picture first = shoot(arguments);
    EXPECT_EQ(first.rgb, shoot(oneThread).rgb);
    EXPECT_NE(first.rgb, shoot(otherSeed).rgb);
}

TEST_F(Pieshot, FailuresAreOneLineAndLeaveNoPicture) {
    const std::string out = folder().path() / "out.png";
    const std::string whole = pie::test::readText(level());
    const std::string half = folder().write("maps/half.bsp", whole.substr(0, whole.size() / 2));
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
        {{(folder().path() / "maps/none.bsp").string(), out}, "none.bsp"},
        {{half, out}, "half.bsp"},
        {{level(), out, "--set", "view=bakd"}, "lit|baked|fullbright|light"},
        {{level(), out, "--set", "exposre=2"}, "did you mean exposure?"},
        {{level(), out, "--camera", "1 2"}, "--camera"},
    };
    for (const auto& [arguments, words] : cases) {
        const CommandResult result = pieshot(arguments);
        EXPECT_EQ(result.status, 1) << words << ": " << result.err;
        EXPECT_THAT(result.err, HasSubstr(words));
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
        EXPECT_FALSE(std::filesystem::exists(out)) << words;
    }
}

TEST_F(Pieshot, TakesALevelByGameAndName) {
    const std::string file = folder().path() / "named.png";
    const CommandResult result = pieshot({"--game", folder().path().string(), "--map", "room", file, "--set",
                                          "view=fullbright", "--width", "64", "--height", "48"});
    ASSERT_EQ(result.status, 0) << result.err;
    // The player start looks along +y.
    expectColour(at(pie::test::readPicture(file), 0.5, 0.5), colours[3], 1, "ahead");
}

} // namespace
