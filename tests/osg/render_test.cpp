// Pictures of a small level of our own, drawn through the plug-in: known pixels, threads, threading models, contexts,
// renderers, OSG's Optimizer.

#include "tests/level/make_level.h"
#include "tests/osg/offscreen.h"
#include "tests/osg/scene_reading.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace {

using namespace pie;
using namespace pie::test;
using Viewer = osgViewer::ViewerBase;

constexpr Rgba8 floorColour{200, 100, 50, 255};
constexpr float half = 256;
constexpr float lightHeight = 128;
constexpr double lightIntensity = 300;

/// A room with a pillar, a coloured floor, a grating and a light; the lightmap has one value everywhere.
class RenderedRoom : public ::testing::Test {
protected:
    static constexpr const char* few = " photons_from_light=2000 accumulation_frames=4 max_edge=64 animate=false";

    void SetUp() override {
        PIE_NEED_DISPLAY();
        game_.addPicture("t/floor", floorColour);
        game_.addPicture("t/red", {180, 60, 50, 255});
        game_.addPicture("t/plain", {160, 160, 160, 255});
        game_.addPicture("t/grating", {250, 250, 250, 128});
        game_.addScript(
            "t/grating\n{\ncull none\nsurfaceparm trans\n{\nmap t/grating.tga\nblendFunc blend\nrgbGen vertex\n}\n}\n");
    }
    [[nodiscard]] std::string level(std::uint8_t lightmapByte = 40) const {
        LevelBuilder builder;
        const int red = builder.shader("t/red");
        const int plain = builder.shader("t/plain");
        builder.room({-half, -half, -half}, {half, half, half},
                     {red, plain, plain, plain, builder.shader("t/floor"), plain}, 0);
        // The pillar: four sides that look outwards.
        const std::array<Vec3, 4> corners{Vec3(96, 96, -half), Vec3(160, 96, -half), Vec3(160, 160, -half),
                                          Vec3(96, 160, -half)};
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const Vec3& a = corners.at(i);
            const Vec3& b = corners.at((i + 1) % corners.size());
            builder.polygon(plain, {a, b, {b.x, b.y, half}, {a.x, a.y, half}}, 0);
        }
        builder.polygon(builder.shader("t/grating"), {{-192, 64, -half}, {-64, 64, -half}, {-64, 64, 0}, {-192, 64, 0}},
                        -3);
        builder.entity({{"classname", "light"}, {"origin", "0 0 128"}, {"light", "300"}});
        builder.entity({{"classname", "info_player_start"}, {"origin", "0 -200 0"}, {"angle", "90"}});
        level::BspLightmap page;
        page.fill(lightmapByte);
        builder.raw().lightmaps = {page};
        return game_.addLevel("room", builder.build());
    }
    [[nodiscard]] static Shot inside() { return lookingAt({0, -240, 0}, {0, 0, -40}); }
    [[nodiscard]] Picture shoot(const std::string& options, const Shot& shot = inside()) const {
        const osg::ref_ptr<osg::Node> node = readNode(level(), options);
        return node ? render(*node, shot) : Picture{};
    }
    [[nodiscard]] const Game& game() const { return game_; }

private:
    Game game_;
};

std::array<int, 3> pixel(const Picture& picture, double x, double y) {
    if (picture.empty()) return {-1, -1, -1};
    const auto column = static_cast<std::size_t>(x * (picture.width - 1));
    const auto row = static_cast<std::size_t>(y * (picture.height - 1));
    const std::uint8_t* p = &picture.rgb[3 * (row * static_cast<std::size_t>(picture.width) + column)];
    return {p[0], p[1], p[2]};
}

void expectPixel(const std::array<int, 3>& seen, const std::array<double, 3>& expected, double tolerance) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(seen.at(c), expected.at(c), tolerance) << "channel " << c;
}

std::array<double, 3> times(const Rgba8& colour, double light) {
    const auto channel = [&](int value) { return std::min(255.0, value * light); };
    return {channel(colour.r), channel(colour.g), channel(colour.b)};
}

int spread(const Picture& picture) {
    const auto [least, most] = std::minmax_element(picture.rgb.begin(), picture.rgb.end());
    return picture.empty() ? 0 : *most - *least;
}

/// The floor from above, from below the ceiling.
Shot floorOnly() {
    Shot shot = fromAbove(-64, 64, -48, 48);
    shot.view = osg::Matrixd::lookAt(osg::Vec3d(0, 0, 0), osg::Vec3d(0, 0, -1), osg::Vec3d(0, 1, 0));
    return shot;
}

class ThreadingModels : public RenderedRoom, public ::testing::WithParamInterface<Viewer::ThreadingModel> {};
INSTANTIATE_TEST_SUITE_P(Models, ThreadingModels,
                         ::testing::Values(Viewer::SingleThreaded, Viewer::CullDrawThreadPerContext,
                                           Viewer::DrawThreadPerContext,
                                           Viewer::CullThreadPerCameraDrawThreadPerContext));

} // namespace

TEST_F(RenderedRoom, BakedIsTheGamesOverbrightFormula) {
    for (const int byte : {0, 40, 64, 100, 255})
        for (const double clamp : {1.0, 2.0})
            for (const char* renderer : {"glsl", "fixed"}) {
                const std::string options =
                    "view=baked renderer=" + std::string(renderer) + " overbright_clamp=" + std::to_string(clamp);
                SCOPED_TRACE(std::to_string(byte) + " " + options);
                const osg::ref_ptr<osg::Node> node = readNode(level(static_cast<std::uint8_t>(byte)), options);
                ASSERT_TRUE(node);
                const double light = std::min(4.0 * byte / 255, clamp);
                // A byte of the lightmap is worth clamp / 255 of a texture's 200; two factors are rounded to bytes.
                const double tolerance = 1.0 + clamp * 200 / 255;
                expectPixel(pixel(render(*node, floorOnly()), 0.4, 0.6), times(floorColour, light), tolerance);
            }
}

TEST_F(RenderedRoom, FullbrightIsTheTexture) {
    for (const char* options :
         {"view=fullbright", "view=fullbright overbright_clamp=2", "view=fullbright renderer=fixed",
          "view=fullbright renderer=fixed overbright_clamp=2"}) {
        SCOPED_TRACE(options);
        expectPixel(pixel(shoot(options, floorOnly()), 0.4, 0.6), times(floorColour, 1), 1);
    }
}

TEST_F(RenderedRoom, LitShowsDirectLightByTheFormula) {
    // Below the light: E = 7500 I / d², 64 U show the texture as it is.
    const double distance = lightHeight + half;
    const double light = 7500 * lightIntensity / (distance * distance) / 64;
    for (const double exposure : {1.0, 3.0}) {
        Shot shot = floorOnly();
        shot.frames = 3;
        const Picture picture = shoot("recursion_depth=0 max_edge=16 exposure=" + std::to_string(exposure), shot);
        SCOPED_TRACE(exposure);
        expectPixel(pixel(picture, 0.5, 0.5), times(floorColour, light * exposure), 2);
    }
}

TEST_F(RenderedRoom, LitIsLightTimesTexture) {
    Shot shot = inside();
    shot.frames = 6;
    const Picture texture = shoot("view=fullbright", shot);
    const Picture light = shoot("view=light" + std::string(few), shot);
    const Picture lit = shoot("view=lit" + std::string(few), shot);
    ASSERT_FALSE(lit.empty() || light.empty() || texture.empty());
    EXPECT_GT(spread(light), 30) << "there is light and shade";
    // The grating blends: there the product is another one.
    std::size_t off = 0;
    for (std::size_t i = 0; i < lit.rgb.size(); ++i)
        off += std::abs(lit.rgb[i] - light.rgb[i] * texture.rgb[i] / 255.0) > 2.5 ? 1U : 0U;
    EXPECT_LT(off, lit.rgb.size() / 5);
    const Picture below = shoot("view=light" + std::string(few), floorOnly());
    const auto p = pixel(below, 0.5, 0.5);
    EXPECT_GT(p[0], 0);
}

TEST_F(RenderedRoom, SeedThreadsAndRunsDoNotChangeAPixel) {
    Shot shot = inside();
    shot.frames = 6;
    const std::string options = "seed=7" + std::string(few);
    const Picture one = shoot(options + " threads=1", shot);
    ASSERT_GT(spread(one), 30);
    EXPECT_EQ(one.rgb, shoot(options + " threads=2", shot).rgb);
    EXPECT_EQ(one.rgb, shoot(options + " threads=1", shot).rgb) << "a second run";
    EXPECT_NE(one.rgb, shoot("seed=8" + std::string(few), shot).rgb) << "another seed has other noise";
}

TEST_P(ThreadingModels, EveryFrameIsTheSame) {
    // Light changes in each of the first frames: a draw that overlaps the next update would show.
    const std::string options = "photons_from_light=1000 accumulation_frames=12 max_edge=32 animate=false";
    Shot shot = inside();
    shot.frames = 10;
    const osg::ref_ptr<osg::Node> node = readNode(level(), options);
    ASSERT_TRUE(node);
    const auto reference = renderFrames(*node, shot);
    ASSERT_EQ(reference.size(), 1U);
    ASSERT_EQ(reference[0].size(), 10U);
    EXPECT_NE(reference[0][2].rgb, reference[0][8].rgb) << "photons arrive meanwhile";
    shot.threading = GetParam();
    const osg::ref_ptr<osg::Node> again = readNode(level(), options);
    ASSERT_TRUE(again);
    const auto frames = renderFrames(*again, shot);
    ASSERT_EQ(frames.size(), 1U);
    ASSERT_EQ(frames[0].size(), 10U);
    for (std::size_t i = 0; i < 10; ++i)
        EXPECT_TRUE(frames[0][i].rgb == reference[0][i].rgb)
            << "frame " << i << ": mean difference " << difference(frames[0][i], reference[0][i]).mean;
}

TEST_P(ThreadingModels, TwoContextsShowTheSame) {
    Shot shot = inside();
    shot.frames = 6;
    shot.contexts = 2;
    shot.threading = GetParam();
    const osg::ref_ptr<osg::Node> node =
        readNode(level(), "photons_from_light=1000 accumulation_frames=12 max_edge=32 animate=false");
    ASSERT_TRUE(node);
    const auto pictures = renderFrames(*node, shot);
    ASSERT_EQ(pictures.size(), 2U);
    ASSERT_EQ(pictures[0].size(), 6U);
    ASSERT_EQ(pictures[1].size(), 6U);
    EXPECT_GT(spread(pictures[0][5]), 30);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_TRUE(pictures[0][i].rgb == pictures[1][i].rgb) << "frame " << i;
}

TEST_F(RenderedRoom, OptimizerChangesNothing) {
    for (const char* view : {"view=lit", "view=baked", "view=fullbright", "view=light"}) {
        Shot shot = inside();
        shot.frames = 6;
        const Picture plain = shoot(view + std::string(few), shot);
        shot.optimize = true;
        EXPECT_TRUE(similar(shoot(view + std::string(few), shot), plain, 0.01, std::string("optimized-") + (view + 5)));
        EXPECT_GT(spread(plain), 30);
    }
}

TEST_F(RenderedRoom, FixedFunctionLooksLikeThePrograms) {
    for (const char* view : {"view=lit", "view=baked", "view=light"})
        for (const char* clamp : {" overbright_clamp=1", " overbright_clamp=2"}) {
            Shot shot = inside();
            shot.frames = 6;
            // Fixed function cuts light off at vertices, programs at pixels: little may be cut off.
            const std::string options = std::string(view) + few + clamp + " exposure=0.7";
            const Picture programs = shoot(options, shot);
            EXPECT_TRUE(similar(shoot(options + " renderer=fixed", shot), programs, 1.05,
                                std::string("fixed-") + (view + 5) + (clamp + 18)));
        }
}

TEST_F(RenderedRoom, SkyFillsWhatIsOpen) {
    game().addScript("t/sky\n{\nsurfaceparm sky\nskyParms env/box 512 -\n}\n", "sky");
    const std::array<std::pair<const char*, Rgba8>, 6> sides{{{"rt", {250, 0, 0, 255}},
                                                              {"lf", {0, 250, 0, 255}},
                                                              {"bk", {0, 0, 250, 255}},
                                                              {"ft", {250, 250, 0, 255}},
                                                              {"up", {0, 250, 250, 255}},
                                                              {"dn", {250, 0, 250, 255}}}};
    for (const auto& [side, colour] : sides) game().addPicture(std::string("env/box_") + side, colour);
    LevelBuilder builder;
    const int sky = builder.shader("t/sky");
    builder.room({-half, -half, -half}, {half, half, half}, {sky, sky, sky, sky, sky, sky});
    builder.polygon(builder.shader("t/floor"), {{-32, -32, -200}, {32, -32, -200}, {32, 32, -200}, {-32, 32, -200}});
    const osg::ref_ptr<osg::Node> node = readNode(game().addLevel("open", builder.build()), "view=baked");
    ASSERT_TRUE(node);
    const std::array<osg::Vec3d, 6> ahead{osg::Vec3d(1, 0, 0),  osg::Vec3d(-1, 0, 0),   osg::Vec3d(0, 1, 0),
                                          osg::Vec3d(0, -1, 0), osg::Vec3d(0.01, 0, 1), osg::Vec3d(0.01, 0, -1)};
    for (std::size_t i = 0; i < ahead.size(); ++i) {
        SCOPED_TRACE(sides.at(i).first);
        const osg::Vec3d eye(100, 50, 20); // no place is nearer to the sky than another
        const Picture picture = render(*node, lookingAt(eye, eye + ahead.at(i)));
        const Rgba8 colour = sides.at(i).second;
        expectPixel(pixel(picture, 0.5, 0.5), {double(colour.r), double(colour.g), double(colour.b)}, 1);
    }
}

TEST_F(RenderedRoom, MirroredPicturesWouldShow) {
    // From the south wall looking north, the red wall (west) is on the left.
    Shot shot = lookingAt({0, -200, 0}, {0, 0, 0});
    const Picture picture = shoot("view=fullbright", shot);
    expectPixel(pixel(picture, 0.02, 0.3), {180, 60, 50}, 1);
    expectPixel(pixel(picture, 0.98, 0.3), {160, 160, 160}, 1);
    expectPixel(pixel(picture, 0.5, 0.97), times(floorColour, 1), 1);
}
