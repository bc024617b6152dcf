// Views that change while the level is shown: each looks as it does when the level is read with it, and those that look
// inside show what is known of a plain room.

#include "osgPlugins/osgpie/load.h"
#include "tests/osg/offscreen.h"
#include "tests/support/room.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>

namespace {

using namespace pie;
using namespace pie::test;
using pie::engine::Settings;
using pie::engine::View;

class Views : public ::testing::Test {
protected:
    void SetUp() override {
        PIE_NEED_DISPLAY();
        writeGame(folder_, "room", makeRoom({}, 32), {{"textures/room/plain", {200, 120, 80, 255}}});
    }

    [[nodiscard]] osg::ref_ptr<osgpie::LevelNode> read(View view, bool switches) const {
        Settings settings;
        settings.view = view;
        settings.switchViews = switches;
        settings.photonsFromLight = 2000;
        settings.stillFrames = 4;
        settings.gatherRays = 16;
        settings.directTolerance = 0.05F;
        auto node = osgpie::loadLevelNode((folder_.path() / "maps/room.bsp").string(), settings);
        EXPECT_TRUE(node) << node.error().message();
        return node ? *node : nullptr;
    }
    static Picture shoot(osg::Node& node) {
        Shot shot = lookingAt({0, 0, 0}, {0, 256, 0}); // at the wall that faces −y, which it fills
        shot.frames = 12;
        return render(node, shot);
    }
    static std::array<int, 3> at(const Picture& picture, int x, int y) {
        const auto first = 3 * static_cast<std::size_t>(y * picture.width + x);
        return {picture.rgb.at(first), picture.rgb.at(first + 1), picture.rgb.at(first + 2)};
    }

    TemporaryFolder folder_;
};

TEST_F(Views, SwitchedToLookAsReadWith) {
    const auto node = read(View::Lit, true);
    ASSERT_TRUE(node && node->views());
    for (const View view : {View::Lit, View::Baked, View::Fullbright, View::Light, View::Lit}) {
        node->views()->setView(view);
        const auto alone = read(view, false);
        EXPECT_EQ(alone->views(), nullptr);
        EXPECT_TRUE(similar(shoot(*node), shoot(*alone), 0.6, "view" + std::to_string(static_cast<int>(view))));
    }
}

TEST_F(Views, SplitIsBakedOnTheLeftAndLitOnTheRight) {
    const auto node = read(View::Split, false);
    ASSERT_TRUE(node && node->views());
    node->views()->setSplit(0.5F);
    const Picture split = shoot(*node);
    node->views()->setView(View::Baked);
    const Picture baked = shoot(*node);
    node->views()->setView(View::Lit);
    const Picture lit = shoot(*node);
    ASSERT_GT(std::abs(at(baked, 40, 60)[0] - at(lit, 40, 60)[0]), 20) << "else there is nothing to see";
    EXPECT_EQ(at(split, 40, 60), at(baked, 40, 60));
    EXPECT_EQ(at(split, 110, 60), at(baked, 110, 60)) << "the divider stands at three quarters";
    EXPECT_EQ(at(split, 130, 60), at(lit, 130, 60));
}

TEST_F(Views, LightmapAloneIsItsBytes) {
    const auto node = read(View::Lightmap, false);
    const int shown = 32 * 4 * 255 / 255;
    for (const int channel : at(shoot(*node), 80, 60)) EXPECT_NEAR(channel, shown, 1);
}

TEST_F(Views, DifferenceIsRedWhereOursIsBrighterAndBlueWhereItIsDarker) {
    const auto node = read(View::Difference, false);
    node->views()->setExposure(0.01F);
    const auto darker = at(shoot(*node), 80, 60);
    EXPECT_GT(darker[2], darker[0] + 30);
    node->views()->setExposure(40);
    const auto brighter = at(shoot(*node), 80, 60);
    EXPECT_GT(brighter[0], brighter[2] + 10) << "cut at white with its hue kept, it is not much brighter";
}

TEST_F(Views, NormalsAreColours) {
    const auto node = read(View::Normals, false);
    const auto wall = at(shoot(*node), 80, 60);
    EXPECT_NEAR(wall[0], 128, 1);
    EXPECT_NEAR(wall[1], 0, 1);
    EXPECT_NEAR(wall[2], 128, 1);
}

TEST_F(Views, SamplesEndAtAsManyRaysAsAsked) {
    const auto node = read(View::Samples, false);
    const Rgb all = osgpie::sampleColour(16, 16);
    const auto wall = at(shoot(*node), 80, 60);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(wall[static_cast<std::size_t>(c)], all[c] * 255, 1);
}

int pixelsUnlike(const Picture& a, const Picture& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.rgb.size(); i += 3)
        if (std::abs(a.rgb[i] - b.rgb[i]) + std::abs(a.rgb[i + 1] - b.rgb[i + 1]) > 60) ++count;
    return count;
}

TEST_F(Views, EdgesAndPhotonsAreDrawnOverAndGoAgain) {
    const auto node = read(View::Light, true);
    const Picture plain = shoot(*node);
    std::array<int, 3> drawn{};
    std::size_t i = 0;
    node->views()->setExposure(0); // what is drawn over the level alone
    node->views()->setPhotonCount(2000);
    const Picture dark = shoot(*node);
    for (const View view : {View::Triangles, View::CoarseTriangles, View::Photons}) {
        node->views()->setView(view);
        drawn.at(i++) = pixelsUnlike(shoot(*node), dark);
    }
    // The wall has one diagonal as it is in the file, and many edges of 64 units.
    EXPECT_GT(drawn[1], 60);
    EXPECT_GT(drawn[0], 4 * drawn[1]);
    EXPECT_GT(drawn[2], 100);
    node->views()->setExposure(1);
    node->views()->setView(View::Light);
    EXPECT_EQ(shoot(*node).rgb, plain.rgb);
}

TEST_F(Views, WhatAViewDoesNotNeedIsNotTraced) {
    const auto node = read(View::Baked, true);
    (void)shoot(*node);
    EXPECT_EQ(node->engine().statistics().photonsEmitted, 0U);
    node->views()->setView(View::Lit);
    (void)shoot(*node);
    EXPECT_GT(node->engine().statistics().photonsEmitted, 0U);
}

} // namespace
