#include "pie/gather/form_factor.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace pie::gather {
namespace {

constexpr double pi = std::numbers::pi;
const Vec3 up(0.0F, 0.0F, 1.0F);

/// A rectangle a × b, parallel, `height` above the point, which lies under one of its corners.
double parallelCorner(double a, double b, double height) {
    const double x = a / height;
    const double y = b / height;
    return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
            y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
           (2 * pi);
}

std::array<Vec3, 4> rectangle(const Vec3& origin, const Vec3& u, const Vec3& v) {
    return {origin, origin + u, origin + u + v, origin + v};
}

TEST(FormFactor, ParallelRectangle) {
    for (const float height : {0.01F, 1.0F, 7.0F, 300.0F}) {
        const auto lamp = rectangle({0.0F, 0.0F, height}, {3.0F, 0.0F, 0.0F}, {0.0F, 5.0F, 0.0F});
        EXPECT_NEAR(formFactor(lamp, Vec3(0.0F), up), parallelCorner(3, 5, static_cast<double>(height)), 1e-9);
        EXPECT_EQ(formFactor(lamp, Vec3(0.0F), -up), 0.0);
    }
}

TEST(FormFactor, PerpendicularRectangle) {
    // The wall y in [0, b], z in [0, c] at distance a: F = (atan(b/a) − a/√(a²+c²) atan(b/√(a²+c²))) / 2π.
    const double a = 2;
    const double b = 3;
    const double c = 4;
    const auto wall = rectangle({2.0F, 0.0F, 0.0F}, {0.0F, 3.0F, 0.0F}, {0.0F, 0.0F, 4.0F});
    const double s = std::sqrt(a * a + c * c);
    EXPECT_NEAR(formFactor(wall, Vec3(0.0F), up), (std::atan(b / a) - a / s * std::atan(b / s)) / (2 * pi), 1e-9);
    // What lies below the horizon does not count.
    const auto sunk = rectangle({2.0F, 0.0F, -9.0F}, {0.0F, 3.0F, 0.0F}, {0.0F, 0.0F, 13.0F});
    EXPECT_NEAR(formFactor(sunk, Vec3(0.0F), up), formFactor(wall, Vec3(0.0F), up), 1e-9);
}

TEST(FormFactor, ASkyIsAll) {
    const auto sky = rectangle({-1e6F, -1e6F, 1.0F}, {2e6F, 0.0F, 0.0F}, {0.0F, 2e6F, 0.0F});
    EXPECT_NEAR(formFactor(sky, Vec3(0.0F), up), 1.0, 1e-5);
    EXPECT_NEAR(formFactor(sky, Vec3(0.0F), {1.0F, 0.0F, 0.0F}), 0.5, 1e-5);
}

TEST(FormFactor, FarAwayItIsTheInverseSquare) {
    const auto lamp = rectangle({300.0F, 400.0F, 1200.0F}, {1.0F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F});
    const double distance = 1300;
    const double cosine = 1200 / distance;
    EXPECT_NEAR(formFactor(lamp, Vec3(0.0F), up) / (cosine * cosine / (pi * distance * distance)), 1.0, 2e-3);
}

TEST(FormFactor, DoesNotDependOnTheOrderOfCorners) {
    std::mt19937 random(2);
    for (int i = 0; i < 500; ++i) {
        const Vec3 a = 10.0F * test::unit3(random);
        const auto lamp = rectangle(a, 3.0F * test::direction(random), 3.0F * test::direction(random));
        const std::array<Vec3, 4> reversed{lamp[3], lamp[2], lamp[1], lamp[0]};
        const std::array<Vec3, 4> turned{lamp[2], lamp[3], lamp[0], lamp[1]};
        const Vec3 normal = test::direction(random);
        const Vec3 point = 10.0F * test::unit3(random);
        const double expected = formFactor(lamp, point, normal);
        EXPECT_NEAR(formFactor(reversed, point, normal), expected, 1e-9);
        EXPECT_NEAR(formFactor(turned, point, normal), expected, 1e-9);
        EXPECT_GE(expected, 0.0);
        EXPECT_LE(expected, 1.0);
    }
}

TEST(FormFactor, StaysFiniteWhereItIsSingular) {
    const auto lamp = rectangle({0.0F, 0.0F, 0.0F}, {3.0F, 0.0F, 0.0F}, {0.0F, 5.0F, 0.0F});
    for (const Vec3& point :
         {lamp[0], lamp[2], Vec3(1.0F, 0.0F, 0.0F), Vec3(1.0F, 1.0F, 0.0F), Vec3(1.0F, 1.0F, 1e-30F)})
        for (const Vec3& normal : {up, -up, Vec3(0.0F, 1.0F, 0.0F), Vec3(0.0F)}) {
            const double share = formFactor(lamp, point, normal);
            EXPECT_GE(share, 0.0);
            EXPECT_LE(share, 1.0);
        }
    const std::array<Vec3, 3> line{Vec3(0.0F, 0.0F, 1.0F), Vec3(1.0F, 0.0F, 1.0F), Vec3(2.0F, 0.0F, 1.0F)};
    EXPECT_NEAR(formFactor(line, Vec3(0.0F), up), 0.0, 1e-9);
    EXPECT_EQ(formFactor({}, Vec3(0.0F), up), 0.0);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::array<Vec3, 3> bad{Vec3(nan), Vec3(1.0F, 0.0F, 1.0F), Vec3(2.0F, 0.0F, 1.0F)};
    EXPECT_EQ(formFactor(bad, Vec3(0.0F), up), 0.0);
}

} // namespace
} // namespace pie::gather
