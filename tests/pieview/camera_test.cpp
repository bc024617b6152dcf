// Camera: directions, pixels, orbits, and the path.

#include "apps/pieview/camera_path.h"
#include "apps/support/camera.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using apps::Camera;
using apps::Lens;
using pie::Vec2;
using pie::Vec3;

void expectNear(const Vec3& a, const Vec3& b, float tolerance) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "channel " << i;
}

TEST(PieviewCamera, LooksAsTheGamePrints) {
    expectNear(apps::ahead({{}, 90, 0}), {0, 1, 0}, 1e-6F);
    expectNear(apps::right({{}, 90, 0}), {1, 0, 0}, 1e-6F);
    expectNear(apps::ahead({{}, 0, 30}), {std::cos(0.5236F), 0, -0.5F}, 1e-4F);
    expectNear(apps::above({{}, 0, 30}), {0.5F, 0, std::cos(0.5236F)}, 1e-4F);
}

TEST(PieviewCamera, NeverTurnsOverAndKeepsYawSmall) {
    EXPECT_FLOAT_EQ(apps::turned({{}, 0, 0}, 0, 500).pitch, 89);
    EXPECT_FLOAT_EQ(apps::turned({{}, 170, 0}, 20, 0).yaw, -170);
}

TEST(PieviewCamera, FliesAsFastInEveryDirection) {
    const Camera camera{{1, 2, 3}, 30, 20};
    EXPECT_NEAR(glm::length(apps::flown(camera, {1, 1, 0}, 10).eye - camera.eye), 10, 1e-4F);
    EXPECT_NEAR(glm::length(apps::flown(camera, {0, 1, 0}, 10).eye - camera.eye), 10, 1e-4F);
    EXPECT_EQ(apps::flown(camera, {0, 0, 0}, 10), camera);
}

TEST(PieviewCamera, OrbitKeepsThePointAhead) {
    const Camera camera{{10, -4, 7}, 33, 12};
    const Camera moved = apps::orbited(camera, 100, 40, -25);
    expectNear(camera.eye + 100.0F * apps::ahead(camera), moved.eye + 100.0F * apps::ahead(moved), 1e-3F);
}

TEST(PieviewCamera, PixelsAndRaysAreInverse) {
    const Camera camera{{10, 20, 30}, 40, -15};
    const Lens lens{75, 640, 360};
    for (const Vec2& pixel : {Vec2(0, 0), Vec2(320, 180), Vec2(600, 40)}) {
        const auto back = apps::pixelOf(camera, lens, camera.eye + 57.0F * apps::rayThrough(camera, lens, pixel));
        ASSERT_TRUE(back);
        EXPECT_NEAR(back->x, pixel.x, 0.01F);
        EXPECT_NEAR(back->y, pixel.y, 0.01F);
    }
    EXPECT_FALSE(apps::pixelOf(camera, lens, camera.eye - apps::ahead(camera)));
}

TEST(PieviewCamera, TextGoesAndComes) {
    const auto camera = apps::parseCamera(apps::cameraText({{1.5F, -2, 3}, 45, -10}));
    ASSERT_TRUE(camera);
    EXPECT_EQ(*camera, (Camera{{1.5F, -2, 3}, 45, -10}));
    for (const char* wrong : {"", "1 2", "1 2 x", "1 2 3 4 5 6", "nan 0 0"}) EXPECT_FALSE(apps::parseCamera(wrong));
    EXPECT_TRUE(apps::parseCamera("1 2 3"));
}

TEST(PieviewPath, GoesThroughItsKeysAtAnEvenPace) {
    // Keys far apart and close together: the pace does not follow them.
    const pieview::CameraPath path({{{0, 0, 0}, 0, 0}, {{900, 0, 0}, 0, 0}, {{1000, 0, 0}, 0, 0}});
    EXPECT_NEAR(path.length(), 1000, 5);
    expectNear(path.at(0).eye, {0, 0, 0}, 1e-3F);
    expectNear(path.at(path.length()).eye, {1000, 0, 0}, 1e-3F);
    for (float at = 0; at < 950; at += 50)
        EXPECT_NEAR(glm::length(path.at(at + 50).eye - path.at(at).eye), 50, 1.5F) << at;
    expectNear(path.at(-5).eye, {0, 0, 0}, 1e-3F);
    expectNear(path.at(1e9F).eye, {1000, 0, 0}, 1e-3F);
}

TEST(PieviewPath, TurnsTheShortWayRound) {
    const pieview::CameraPath path({{{0, 0, 0}, 170, 0}, {{0, 0, 0}, -170, 0}});
    EXPECT_NEAR(path.length(), 20, 0.5F);
    EXPECT_NEAR(std::abs(path.at(path.length() / 2).yaw), 180, 0.5F);
}

TEST(PieviewPath, OfOneKeyStands) {
    const pieview::CameraPath path({{{7, 8, 9}, 10, 11}});
    EXPECT_EQ(path.length(), 0);
    EXPECT_EQ(path.at(3), (Camera{{7, 8, 9}, 10, 11}));
    EXPECT_TRUE(pieview::CameraPath({}).empty());
}

} // namespace
