// Brushes as solids: volumes and areas against closed forms, at extremes of shape and place.

#include "pie/brushes/brush.h"
#include "pie/brushes/visible.h"
#include "tests/brushes/make_map.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

namespace {

using namespace pie;
using namespace pie::brushes;
using ::testing::HasSubstr;

/// Keeps the text that brushes point to.
struct Made {
    std::unique_ptr<MapText> text;
    PlaneSet planes;
    std::vector<Brush> brushes;
    std::string reason;

    explicit Made(const std::string& brushTexts) {
        Result<MapText> map = parseMap("{\n" + brushTexts + "}\n", "x.map");
        text = std::make_unique<MapText>(map ? std::move(*map) : MapText{});
        if (text->entities.empty()) return;
        for (const BrushText& brush : text->entities[0].brushes)
            if (std::optional<Brush> made = makeBrush(brush, planes, reason)) {
                made->hides = made->structural = true;
                brushes.push_back(std::move(*made));
            }
    }
    [[nodiscard]] double area() const {
        double sum = 0;
        for (const Brush& brush : brushes)
            for (const Side& side : brush.sides) sum += brushes::area(side.polygon);
        return sum;
    }
    [[nodiscard]] double visibleArea() const {
        double sum = 0;
        for (const Fragment& fragment : visibleFragments(brushes, planes, {1})) sum += brushes::area(fragment.polygon);
        return sum;
    }
};

glm::dmat3 turned(double degrees, const glm::dvec3& axis) {
    return {glm::rotate(glm::dmat4(1), glm::radians(degrees), axis)};
}

TEST(Brush, BoxesOfEverySizeAndPlace) {
    for (const glm::dvec3& size :
         {glm::dvec3(64), glm::dvec3(1, 2, 3), glm::dvec3(0.125, 4096, 8), glm::dvec3(16384, 16384, 0.25)})
        for (const glm::dvec3& at :
             {glm::dvec3(0), glm::dvec3(-65536, 65536 - 16384.0, 3), glm::dvec3(0.5, 1000.25, -4000.125)}) {
            const Made made(test::boxText(at, at + size));
            ASSERT_EQ(made.brushes.size(), 1U) << made.reason;
            EXPECT_NEAR(volume(made.brushes[0], made.planes) / (size.x * size.y * size.z), 1, 1e-9);
            EXPECT_NEAR(made.area() / (2 * (size.x * size.y + size.y * size.z + size.z * size.x)), 1, 1e-9);
            // Neighbouring faces share corners bit by bit.
            std::set<std::array<double, 3>> corners;
            for (const Side& side : made.brushes[0].sides)
                for (const glm::dvec3& p : side.polygon) corners.insert({p.x, p.y, p.z});
            EXPECT_EQ(corners.size(), 8U);
        }
}

TEST(Brush, TurnedBoxesKeepVolumeAreaAndCorners) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int i = 0; i < 300; ++i) {
        const glm::dmat3 rotation =
            turned(180 * any(random), glm::normalize(glm::dvec3(any(random), any(random), any(random)) + 1e-3));
        const glm::dvec3 size = glm::dvec3(2) + 200.0 * glm::abs(glm::dvec3(any(random), any(random), any(random)));
        const glm::dvec3 at = 30000.0 * glm::dvec3(any(random), any(random), any(random));
        const Made made(test::boxText(-0.5 * size, 0.5 * size, "t/wall", rotation, at));
        ASSERT_EQ(made.brushes.size(), 1U) << made.reason;
        EXPECT_NEAR(volume(made.brushes[0], made.planes) / (size.x * size.y * size.z), 1, 3e-3);
        std::set<std::array<double, 3>> corners;
        for (const Side& side : made.brushes[0].sides) {
            EXPECT_EQ(side.polygon.size(), 4U);
            for (const glm::dvec3& p : side.polygon) corners.insert({p.x, p.y, p.z});
        }
        EXPECT_EQ(corners.size(), 8U);
    }
}

/// A prism over a regular polygon: area n r² sin(2π/n) / 2. With many sides neighbouring planes are nearly parallel.
TEST(Brush, PrismsWithNearlyParallelSides) {
    for (const int n : {3, 5, 8, 32, 90}) {
        constexpr double radius = 512;
        constexpr double height = 96;
        const double step = 2 * std::numbers::pi / n;
        std::string text = "{\n" + test::faceText({0, 0, 1}, {0, 0, height}) + test::faceText({0, 0, -1}, {0, 0, 0});
        for (int i = 0; i < n; ++i) {
            const glm::dvec3 out(std::cos(step * (i + 0.5)), std::sin(step * (i + 0.5)), 0);
            text += test::faceText(out, radius * std::cos(step / 2) * out);
        }
        const Made made(text + "}\n");
        ASSERT_EQ(made.brushes.size(), 1U) << made.reason;
        EXPECT_EQ(made.brushes[0].sides.size(), static_cast<std::size_t>(n) + 2);
        EXPECT_NEAR(volume(made.brushes[0], made.planes) / (0.5 * n * radius * radius * std::sin(step) * height), 1,
                    1e-5)
            << n;
    }
}

TEST(Brush, SliversKeepTheirVolume) {
    for (const double thick : {8.0, 0.5, 0.05}) {
        // A wedge: a square of side 256, from nothing to `thick`.
        const double slope = thick / 256;
        const Made made("{\n" + test::faceText({0, 0, -1}, {0, 0, 0}) + test::faceText({-slope, 0, 1}, {0, 0, 0}) +
                        test::faceText({1, 0, 0}, {256, 0, 0}) + test::faceText({0, -1, 0}, {0, 0, 0}) +
                        test::faceText({0, 1, 0}, {0, 256, 0}) + "}\n");
        ASSERT_EQ(made.brushes.size(), 1U) << made.reason;
        EXPECT_NEAR(volume(made.brushes[0], made.planes) / (0.5 * 256 * 256 * thick), 1, 0.05) << thick;
    }
}

TEST(Brush, WhatHasNoVolumeIsRefusedWithAReason) {
    const auto reasonOf = [](const std::string& text) {
        const Made made(text);
        EXPECT_TRUE(made.brushes.empty());
        return made.reason;
    };
    EXPECT_THAT(reasonOf(test::boxText({0, 0, 0}, {64, 64, 0})), HasSubstr("no volume"));
    EXPECT_THAT(reasonOf(test::boxText({0, 0, 8}, {64, 64, 0})), HasSubstr("no volume"));
    EXPECT_THAT(reasonOf("{\n" + test::faceText({0, 0, 1}, {0, 0, 0}) + "}\n"), HasSubstr("open"));
    EXPECT_THAT(reasonOf("{\n}\n"), HasSubstr("no volume"));
    EXPECT_THAT(reasonOf(test::boxText({0, 0, 0}, {64, 64, 200000})), HasSubstr("beyond the world"));
    // Three points on a line bound nothing.
    EXPECT_THAT(reasonOf("{\n( 0 0 0 ) ( 1 0 0 ) ( 2 0 0 ) a 0 0 0 1 1\n}\n"), HasSubstr("no volume"));
}

/// Whatever the distance, and whichever side of a bucket's border it is on: the plane that was there is found.
TEST(Planes, AreFoundWithinTheToleranceAndNotBeyond) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> any(-1, 1);
    PlaneSet planes;
    for (int i = 0; i < 20000; ++i) {
        const glm::dvec3 normal = glm::normalize(glm::dvec3(any(random), any(random), any(random)) + 1e-3);
        const Plane plane{normal, 60000 * any(random)};
        const std::uint32_t number = planes.find(plane);
        EXPECT_EQ(planes.find({normal, plane.distance + 0.0099 * any(random)}), number);
        EXPECT_EQ(planes.find({-normal, -plane.distance + 0.0099 * any(random)}), number ^ 1U);
        EXPECT_NE(planes.find({normal, plane.distance + 0.0101}) & ~1U, number & ~1U);
        const glm::dvec3 across = glm::normalize(glm::cross(normal, glm::dvec3(0.3, -0.2, 0.9)));
        EXPECT_NE(planes.find({glm::normalize(normal + 1e-4 * across), plane.distance}) & ~1U, number & ~1U);
    }
}

TEST(Polygons, OfManyCornersAreCutLikeThoseOfFew) {
    constexpr int corners = 40;
    Polygon round;
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * i / corners;
        round.add({100 * std::cos(angle), 100 * std::sin(angle), 5});
    }
    const double whole = area(round);
    EXPECT_NEAR(whole, 0.5 * corners * 1e4 * std::sin(2 * std::numbers::pi / corners), 1e-6);
    Polygon front;
    Polygon back;
    ASSERT_EQ(split(round, {{1, 0, 0}, 30}, front, back), Place::Both);
    EXPECT_NEAR(area(front) + area(back), whole, 1e-6);
    for (const glm::dvec3& p : front) EXPECT_GE(p.x, 30 - onPlane);
    const Polygon copy = front;
    const Polygon moved = std::move(front);
    EXPECT_TRUE(std::equal(moved.begin(), moved.end(), copy.begin(), copy.end()));
    Polygon few = round;
    few.shorten(5);
    EXPECT_TRUE(std::equal(few.begin(), few.end(), round.begin(), round.begin() + 5));
    EXPECT_EQ(split(round, {{0, 0, 1}, 5}, front, back), Place::On);
    EXPECT_EQ(split(round, {{0, 0, 1}, 6}, front, back), Place::Back);
    EXPECT_EQ(split(round, {{0, 0, 1}, 4}, front, back), Place::Front);
}

// What the union of solids shows.

TEST(Visible, BoxesThatDoNotTouchKeepEverything) {
    const Made made(test::boxText({0, 0, 0}, {64, 64, 64}) + test::boxText({65, 0, 0}, {128, 64, 64}));
    EXPECT_NEAR(made.visibleArea(), made.area(), 1e-6);
}

TEST(Visible, TouchingFacesVanishOnBothSides) {
    const Made made(test::boxText({0, 0, 0}, {64, 64, 64}) + test::boxText({64, 0, 0}, {128, 64, 64}));
    EXPECT_NEAR(made.visibleArea(), made.area() - 2 * 64 * 64, 1e-6);
    // A small one on a large one: the large face keeps the rest.
    const Made stacked(test::boxText({0, 0, 0}, {64, 64, 64}) + test::boxText({16, 16, 64}, {32, 32, 80}));
    EXPECT_NEAR(stacked.visibleArea(), stacked.area() - 2 * 16 * 16, 1e-6);
}

TEST(Visible, OverlapsAreTheSurfaceOfTheUnion) {
    // Two cubes of side 64 shifted by 32 in x: a box of 96 x 64 x 64. Coplanar faces count once.
    const Made shifted(test::boxText({0, 0, 0}, {64, 64, 64}) + test::boxText({32, 0, 0}, {96, 64, 64}));
    EXPECT_NEAR(shifted.visibleArea(), 2 * (96 * 64 + 96 * 64 + 64 * 64), 1e-6);
    // The same box twice, or one in the other: one remains.
    const Made twice(test::boxText({0, 0, 0}, {64, 64, 64}) + test::boxText({0, 0, 0}, {64, 64, 64}));
    EXPECT_NEAR(twice.visibleArea(), 6 * 64 * 64, 1e-6);
    const Made inside(test::boxText({0, 0, 0}, {64, 64, 64}) + test::boxText({8, 8, 8}, {16, 16, 16}));
    EXPECT_NEAR(inside.visibleArea(), 6 * 64 * 64, 1e-6);
    // Corner in corner: both cubes lose what lies in the common 32-cube: 3 faces of it each.
    const Made corner(test::boxText({0, 0, 0}, {64, 64, 64}) + test::boxText({32, 32, 32}, {96, 96, 96}));
    EXPECT_NEAR(corner.visibleArea(), 12 * 64 * 64 - 6 * 32 * 32, 1e-6);
}

/// The union of two turned boxes that cross: what each loses is what of its surface lies in the other, counted by
/// points.
TEST(Visible, TurnedBoxesLoseWhatLiesInside) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int i = 0; i < 20; ++i) {
        const glm::dmat3 rotation =
            turned(90 * any(random), glm::normalize(glm::dvec3(any(random), any(random), any(random)) + 1e-3));
        const glm::dvec3 offset = 40.0 * glm::dvec3(any(random), any(random), any(random));
        const Made made(test::boxText(glm::dvec3(-64), glm::dvec3(64)) +
                        test::boxText(glm::dvec3(-48), glm::dvec3(48), "t/wall", rotation, offset));
        const auto lost = [&](double half, double otherHalf, const glm::dmat3& toWorld, const glm::dvec3& at,
                              const glm::dmat3& toOther, const glm::dvec3& otherAt) {
            constexpr int n = 200;
            int inside = 0;
            for (int face = 0; face < 6; ++face)
                for (int k = 0; k < n * n; ++k) {
                    glm::dvec3 p;
                    p[face / 2] = face % 2 == 0 ? half : -half;
                    const int row = k / n;
                    p[(face / 2 + 1) % 3] = half * ((k % n + 0.5) / n * 2 - 1);
                    p[(face / 2 + 2) % 3] = half * ((row + 0.5) / n * 2 - 1);
                    const glm::dvec3 q = glm::abs(toOther * (toWorld * p + at - otherAt));
                    if (q.x < otherHalf && q.y < otherHalf && q.z < otherHalf) ++inside;
                }
            return static_cast<double>(inside) * 4 * half * half / (n * n);
        };
        const double expected = made.area() -
                                lost(64, 48, glm::dmat3(1), glm::dvec3(0), glm::transpose(rotation), offset) -
                                lost(48, 64, rotation, offset, glm::dmat3(1), glm::dvec3(0));
        EXPECT_NEAR(made.visibleArea() / expected, 1, 2e-3) << i;
    }
}

} // namespace
