// Walking in rooms of planes whose every collision is known.

#include "apps/pieview/walk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace {

using apps::Camera;
using pie::Vec3;
using pieview::Obstacle;
using pieview::Walker;

/// Axis-aligned boxes that are solid.
struct Solids {
    std::vector<pie::Box> boxes;

    std::optional<Obstacle> operator()(const Vec3& origin, const Vec3& direction, float reach) const {
        std::optional<Obstacle> nearest;
        for (const pie::Box& box : boxes) {
            float enter = 0;
            float leave = reach;
            Vec3 normal(0.0F);
            bool meets = true;
            for (int i = 0; i < 3 && meets; ++i) {
                if (direction[i] == 0.0F) {
                    meets = origin[i] > box.lower[i] && origin[i] < box.upper[i];
                    continue;
                }
                const float a = (box.lower[i] - origin[i]) / direction[i];
                const float b = (box.upper[i] - origin[i]) / direction[i];
                if (std::min(a, b) > enter) {
                    enter = std::min(a, b);
                    normal = Vec3(0.0F);
                    normal[i] = direction[i] > 0 ? -1.0F : 1.0F;
                }
                leave = std::min(leave, std::max(a, b));
                meets = enter <= leave;
            }
            if (meets && normal != Vec3(0.0F) && (!nearest || enter < nearest->distance))
                nearest = Obstacle{enter, normal};
        }
        return nearest;
    }
};

/// A floor at 0, a wall at x = 200, a step of 16 from y = 200 on, one of 32 from y = 400 on, a ceiling at 100.
const Solids room{{{{-1000, -1000, -50}, {1000, 1000, 0}},
                   {{200, -1000, 0}, {250, 1000, 100}},
                   {{-1000, 200, 0}, {1000, 1000, 16}},
                   {{-1000, 400, 16}, {1000, 1000, 48}},
                   {{-1000, -1000, 100}, {1000, 1000, 150}}}};

class Walking : public ::testing::Test {
protected:
    void walk(const Vec3& push, float seconds, float speed = 320) {
        constexpr float step = 1.0F / 60;
        for (float t = 0; t < seconds; t += step) {
            camera_ = pieview::walked(camera_, walker_, room, push, speed, step);
            lowest_ = std::min(lowest_, camera_.eye.z);
            highest_ = std::max(highest_, camera_.eye.z);
        }
    }
    [[nodiscard]] float feet() const { return camera_.eye.z - Walker::eyeHeight; }

    Camera camera_{{0, 0, 80}, 0, 0};
    Walker walker_;
    float lowest_ = 1e9F, highest_ = -1e9F;
};

TEST_F(Walking, FallsToTheFloorAndStands) {
    walk({}, 1);
    EXPECT_NEAR(feet(), 0, 0.3F);
    EXPECT_TRUE(walker_.onGround);
    EXPECT_GT(lowest_, Walker::eyeHeight - 0.5F) << "never below";
}

TEST_F(Walking, StopsBeforeAWallAndSlidesAlongIt) {
    walk({}, 1);
    walk({0, 1, 0}, 2);
    EXPECT_NEAR(camera_.eye.x, 200 - Walker::halfWidth, 1);
    camera_.yaw = -45; // ahead is half along the wall
    const float before = camera_.eye.y;
    walk({0, 1, 0}, 0.5F);
    EXPECT_NEAR(camera_.eye.x, 200 - Walker::halfWidth, 1);
    EXPECT_NEAR(before - camera_.eye.y, 0.5F * 320 * std::sqrt(0.5F), 8);
}

TEST_F(Walking, NoSpeedPassesThroughAWall) {
    walk({}, 1);
    walk({0, 1, 0}, 0.5F, 50'000);
    EXPECT_LT(camera_.eye.x, 200);
}

TEST_F(Walking, ClimbsAStepButNotTwo) {
    walk({}, 1);
    camera_.yaw = 90;
    walk({0, 1, 0}, 3);
    EXPECT_NEAR(feet(), 16, 0.3F);
    EXPECT_NEAR(camera_.eye.y, 400 - Walker::halfWidth, 1);
}

TEST_F(Walking, StepsDownWithoutFalling) {
    walk({}, 1);
    camera_ = {{0, 300, 16 + Walker::eyeHeight}, -90, 0};
    walker_.onGround = true;
    walk({0, 1, 0}, 1);
    EXPECT_NEAR(feet(), 0, 0.3F);
    EXPECT_TRUE(walker_.onGround);
}

TEST_F(Walking, JumpsAsHighAsTheGameAndStaysBelowTheCeiling) {
    walk({}, 1);
    pieview::jump(walker_);
    highest_ = 0;
    walk({}, 1);
    // 270²/1600 = 45.6 units, and the ceiling leaves 44.
    EXPECT_NEAR(highest_, 100 - Walker::headroom, 2);
    EXPECT_LE(highest_, 100 - Walker::headroom + 0.01F);
    EXPECT_TRUE(walker_.onGround);
}

TEST_F(Walking, LooksUpWithoutLosingSpeed) {
    walk({}, 1);
    camera_.pitch = -80;
    camera_.yaw = 180;
    walk({0, 1, 0}, 0.5F);
    EXPECT_NEAR(camera_.eye.x, -160, 8);
}

} // namespace
