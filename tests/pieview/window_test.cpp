// The window as its user has it: keys, mouse and saves go in, pixels and files come out.

#include "tests/pieview/x_client.h"
#include "tests/support/display.h"
#include "tests/support/files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

namespace {

namespace fs = std::filesystem;
using namespace pie::test;

constexpr int width = 400;
constexpr int height = 300;

using Colour = std::array<int, 3>;

Colour at(const Picture& picture, int x, int y) {
    const auto first =
        3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x));
    return {picture.rgb.at(first), picture.rgb.at(first + 1), picture.rgb.at(first + 2)};
}
Colour middle(const Picture& picture) { return at(picture, width / 2, height / 2 - 20); }
bool like(const Colour& a, const Colour& b, int tolerance = 6) {
    for (std::size_t i = 0; i < 3; ++i)
        if (std::abs(a.at(i) - b.at(i)) > tolerance) return false;
    return true;
}

/// A closed room of six brushes, 512 wide, a lamp in its middle and a player who looks along +y.
std::string roomText(const std::string& texture, int light = 300) {
    const auto brush = [&](std::array<int, 3> lower, std::array<int, 3> upper) {
        const auto [x, y, z] = lower;
        const auto [X, Y, Z] = upper;
        const auto face = [&](std::array<int, 9> p) {
            return fmt::format("( {} {} {} ) ( {} {} {} ) ( {} {} {} ) {} 0 0 0 1 1 0 0 0\n", p[0], p[1], p[2], p[3],
                               p[4], p[5], p[6], p[7], p[8], texture);
        };
        return "{\n" + face({x, Y, z, x, y, Z, x, y, z}) + face({X, y, z, X, y, Z, X, Y, z}) +
               face({x, y, z, x, y, Z, X, y, z}) + face({X, Y, z, x, Y, Z, x, Y, z}) +
               face({x, y, z, X, y, z, x, Y, z}) + face({x, Y, Z, X, y, Z, x, y, Z}) + "}\n";
    };
    std::string text = "{\n\"classname\" \"worldspawn\"\n";
    text += brush({-272, -272, -272}, {272, 272, -256}) + brush({-272, -272, 256}, {272, 272, 272});
    text += brush({-272, -272, -256}, {-256, 272, 256}) + brush({256, -272, -256}, {272, 272, 256});
    text += brush({-256, -272, -256}, {256, -256, 256}) + brush({-256, 256, -256}, {256, 272, 256});
    return text +
           fmt::format("}}\n{{\n\"classname\" \"info_player_start\"\n\"origin\" \"0 -128 0\"\n\"angle\" "
                       "\"90\"\n}}\n{{\n\"classname\" \"light\"\n\"origin\" \"0 100 26\"\n\"light\" \"{}\"\n}}\n",
                       light);
}

const Colour red{200, 60, 40};
const Colour blue{40, 60, 200};

class PieviewWindow : public ::testing::Test {
protected:
    void SetUp() override {
        display_ = VirtualDisplay::start(width, height);
        if (!display_) GTEST_SKIP() << "needs a virtual display: apt-get install xvfb libgl1-mesa-dri";
        client_ = std::make_unique<XClient>(display_->name());
        ASSERT_TRUE(client_->works());
        for (const auto& [name, colour] : {std::pair{"red", red}, std::pair{"blue", blue}}) {
            Picture picture{16, 16, {}};
            for (int i = 0; i < 256; ++i)
                for (const int channel : colour) picture.rgb.push_back(static_cast<std::uint8_t>(channel));
            const fs::path file = folder_.path() / "textures/t" / (std::string(name) + ".png");
            fs::create_directories(file.parent_path());
            ASSERT_TRUE(writePicture(file, picture));
        }
        (void)folder_.write("maps/room.map", roomText("t/red"));
        fs::create_directories(folder_.path() / "work");
    }

    /// Opens the level with textures alone and without the panel, and waits until it is there.
    void open(const std::string& mode = "fullbright", std::vector<std::string> more = {}) {
        std::vector<std::string> command{PIEVIEW,  level(),
                                         "--size", fmt::format("{}x{}", width, height),
                                         "--mode", mode,
                                         "--set",  "photons_from_light=500",
                                         "--set",  "still_frames=2",
                                         "--set",  "gather_rays=4"};
        command.insert(command.end(), more.begin(), more.end());
        program_ = std::make_unique<Program>(
            command,
            std::vector<std::pair<std::string, std::string>>{{"DISPLAY", display_->name()},
                                                             {"XDG_CONFIG_HOME", folder_.path() / "config"}},
            folder_.path() / "work");
        client_->moveTo(width / 4, height * 3 / 4);
        (void)see([](const Colour& c) { return c != Colour{0, 0, 0}; });
        client_->press("Tab");
        client_->press("i");
    }
    Colour see(const std::function<bool(const Colour&)>& wanted) const {
        return middle(client_->screenOnce([&](const Picture& p) { return wanted(middle(p)); }));
    }
    void expectSeen(const Colour& colour, const std::string& what) const {
        const Colour seen = see([&](const Colour& c) { return like(c, colour); });
        EXPECT_TRUE(like(seen, colour)) << what << ": " << seen[0] << ' ' << seen[1] << ' ' << seen[2];
    }
    [[nodiscard]] std::string level() const { return folder_.path() / "maps/room.map"; }
    /// What a bookmark says the camera is: x y z yaw pitch.
    std::array<double, 5> camera() {
        std::error_code removed;
        fs::remove_all(folder_.path() / "config/pie/levels", removed); // what comes is new
        const std::string key = "1";
        client_->press("Control_L+" + key);
        for (int i = 0; i < 200; ++i) {
            std::error_code error;
            for (const auto& entry : fs::directory_iterator(folder_.path() / "config/pie/levels", error)) {
                const std::string text = readText(entry.path());
                const std::size_t at = text.find("\n" + key + " = \"");
                std::array<double, 5> c{};
                if (at != std::string::npos && std::sscanf(text.c_str() + at + 6, "%lf %lf %lf %lf %lf", c.data(),
                                                           &c[1], &c[2], &c[3], &c[4]) == 5)
                    return c;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        ADD_FAILURE() << "no bookmark " << key;
        return {};
    }

    TemporaryFolder folder_;
    std::unique_ptr<VirtualDisplay> display_;
    std::unique_ptr<XClient> client_;
    std::unique_ptr<Program> program_;
};

TEST_F(PieviewWindow, FollowsEveryKindOfSaveAndShowsWhatIsBroken) {
    open();
    expectSeen(red, "as opened");
    std::ofstream(level(), std::ios::trunc) << roomText("t/blue");
    expectSeen(blue, "written over");
    const std::string beside = folder_.write("maps/room.map.new", roomText("t/red"));
    fs::rename(beside, level());
    expectSeen(red, "renamed over");
    fs::remove(level());
    (void)folder_.write("maps/room.map", roomText("t/blue"));
    expectSeen(blue, "removed and written anew");

    std::ofstream(level(), std::ios::trunc) << "{\n\"classname\" \"worldspawn\"\n{\n";
    const auto banner = [](const Picture& p) {
        const std::size_t first = 3 * (14 * static_cast<std::size_t>(p.width) + 12);
        return p.rgb.at(first) > 90 && p.rgb.at(first + 1) < 40;
    };
    const Picture broken = client_->screenOnce(banner);
    EXPECT_TRUE(banner(broken)) << "the error in the upper left corner";
    EXPECT_TRUE(like(at(broken, width - 30, height - 60), blue)) << "the last good level stays";
    const std::string mended = folder_.write("maps/room.map.new", roomText("t/red"));
    fs::rename(mended, level());
    expectSeen(red, "mended");
    EXPECT_FALSE(banner(client_->screenOnce([&](const Picture& p) { return !banner(p); })));

    client_->press("Control_L+q");
    EXPECT_EQ(program_->wait(10), 0);
}

TEST_F(PieviewWindow, KeysChangeViewsAndLights) {
    open();
    client_->press("F8");
    expectSeen({128, 0, 128}, "normals: the wall ahead faces -y");
    client_->press("F1");
    const Colour lit = see([](const Colour& c) { return c[0] > c[2] + 20 && c[0] > 60; });
    EXPECT_GT(lit[0], 60);
    client_->press("n");
    client_->press("x");
    expectSeen({0, 0, 0}, "the only light is off");
    client_->press("l");
    const Colour flashlight = see([](const Colour& c) { return c[0] > 60; });
    EXPECT_GT(flashlight[0], 60) << "flashlight";
    client_->press("Shift_L+question");
    const Colour help = see([](const Colour& c) { return std::abs(c[0] - c[2]) < 12; });
    EXPECT_LT(std::abs(help[0] - help[2]), 12) << "the keys cover the red wall";
}

TEST_F(PieviewWindow, KeysAndMouseMoveTheCamera) {
    open();
    client_->press("Control_L+0");
    const auto start = camera();
    EXPECT_NEAR(start[1], -128, 0.5);
    client_->hold("w", true);
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    client_->hold("w", false);
    const auto ahead = camera();
    EXPECT_GT(ahead[1], start[1] + 40);
    EXPECT_NEAR(ahead[0], start[0], 1);
    client_->moveTo(100, 150);
    client_->button(3, true);
    client_->moveTo(150, 130);
    client_->button(3, false);
    const auto looked = camera();
    EXPECT_NEAR(looked[3], ahead[3] - 10, 0.2) << "a fifth of a degree a pixel";
    EXPECT_NEAR(looked[4], ahead[4] - 4, 0.2);
    client_->press("g");
    std::array<double, 5> standing{};
    for (int i = 0; i < 40 && std::abs(standing[2] + 206) > 0.5; ++i) standing = camera();
    EXPECT_NEAR(standing[2], -256 + 50, 0.5) << "walking, on the floor";
    client_->press("0");
    EXPECT_NEAR(camera()[1], start[1], 0.5);
}

TEST_F(PieviewWindow, LightsAreChosenAndDraggedInTheView) {
    open("light");
    client_->press("i"); // marks again
    // The lamp is in the middle of the picture.
    (void)client_->screenOnce([](const Picture&) { return false; }, 0.5);
    const Picture before = client_->screen();
    client_->moveTo(width / 2, height / 2);
    client_->button(1, true);
    for (int x = width / 2; x >= 60; x -= 20) client_->moveTo(x, height / 2);
    client_->button(1, false);
    // Green: red is full all over.
    const auto leftness = [](const Picture& p) {
        double sum = 0;
        for (int x = 0; x < width; ++x) sum += (x < width / 2 ? 1 : -1) * at(p, x, height / 2 + 40)[1];
        return sum / width;
    };
    const double even = leftness(before);
    const double left = leftness(client_->screenOnce([&](const Picture& p) { return leftness(p) > even + 15; }, 10));
    EXPECT_GT(left, even + 15) << "the light went to the left";
}

TEST_F(PieviewWindow, TakesPicturesOfTheLevelAlone) {
    open();
    expectSeen(red, "as opened");
    client_->press("F12");
    client_->press("Shift_L+F12");
    const fs::path png = folder_.path() / "work/room-001.png";
    const fs::path exr = folder_.path() / "work/room-001.exr";
    for (int i = 0; i < 300 && !(fs::exists(png) && fs::exists(exr)); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const Picture picture = readPicture(png);
    ASSERT_EQ(picture.width, width);
    ASSERT_EQ(picture.height, height);
    EXPECT_TRUE(like(middle(picture), red, 1));
    EXPECT_TRUE(like({picture.rgb[0], picture.rgb[1], picture.rgb[2]}, red, 1)) << "no panel, no note";
    EXPECT_TRUE(fs::exists(exr));
}

/// Against the same window while textures move, so that it does not matter how fast the machine is.
TEST_F(PieviewWindow, CostsNextToNothingWhenItStandsStill) {
    open("lit");
    (void)client_->screenOnce([](const Picture&) { return false; }, 6); // settled, and the note is gone
    const auto cost = [&] {
        const double before = program_->processorSeconds();
        std::this_thread::sleep_for(std::chrono::milliseconds(1500));
        return program_->processorSeconds() - before;
    };
    const double still = cost();
    client_->press("t");
    const double moving = cost();
    EXPECT_GT(moving, 0);
    EXPECT_LT(still, 0.5 * moving);
    EXPECT_TRUE(program_->runs());
}

} // namespace
