// Numbers that must not break it, each with its stated behaviour.

#include "tests/photons/traced.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pie::photons {
namespace {

using test::Traced;

void expectSane(const std::vector<Photon>& photons, const scene::Scene& scene) {
    for (const Photon& p : photons) {
        for (int i = 0; i < 3; ++i) {
            ASSERT_TRUE(std::isfinite(p.position[i]));
            ASSERT_TRUE(std::isfinite(p.flux[i]));
            ASSERT_GE(p.flux[i], 0.0F);
        }
        ASSERT_NEAR(glm::length(p.direction), 1.0F, 1e-4F);
        ASSERT_LT(p.triangle, scene.triangles.size());
    }
}

TEST(Extremes, NoPhotonsAndOne) {
    Traced traced(test::furnace(Rgb(0.5F)), {test::lamp(Vec3(50.0F), Rgb(100.0F))}, test::roulette(true, 8));
    EXPECT_TRUE(traced.trace(0, 0).empty());
    EXPECT_EQ(traced.counts.emitted, 0U);
    const auto one = traced.trace(5, 1);
    ASSERT_FALSE(one.empty());
    EXPECT_EQ(traced.counts.emitted, 1U);
    EXPECT_NEAR(one[0].flux.x, 100.0F, 1e-3F);
}

TEST(Extremes, NoLightsNoSceneNoPower) {
    Traced dark(test::furnace(Rgb(0.5F)), {}, test::roulette(true, 8));
    EXPECT_TRUE(dark.trace(0, 100).empty());
    EXPECT_EQ(dark.counts.rays, 0U);
    EXPECT_EQ(dark.counts.emitted, 0U);
    Traced off(test::furnace(Rgb(0.5F)), {test::lamp(Vec3(50.0F), Rgb(0.0F))}, test::roulette(true, 8));
    EXPECT_TRUE(off.trace(0, 100).empty());
    Traced empty(std::make_shared<scene::Scene>(), {test::lamp(Vec3(50.0F), Rgb(7.0F))}, test::roulette(true, 8));
    EXPECT_TRUE(empty.trace(0, 100).empty());
    EXPECT_EQ(empty.counts.escaped, 100U);
    EXPECT_NEAR(empty.counts.escapedFlux[1], 7.0, 1e-5);
}

TEST(Extremes, PowersFromTinyToHuge) {
    for (const float watts : {1e-30F, 1e30F}) {
        Traced traced(test::furnace(Rgb(0.5F)), {test::lamp(Vec3(50.0F), Rgb(watts))}, test::roulette(true, 60));
        const auto photons = traced.trace(0, 5000);
        expectSane(photons, traced.scene());
        double sum = 0.0;
        for (const Photon& p : photons) sum += p.flux.x;
        EXPECT_NEAR(sum / watts, 2.0, 0.05);
    }
}

TEST(Extremes, LargeIndices) {
    Traced traced(test::furnace(Rgb(0.5F)), {test::lamp(Vec3(50.0F), Rgb(1.0F))}, test::roulette(true, 60));
    for (const std::uint64_t first :
         {std::uint64_t{1} << 32U, std::uint64_t{1} << 60U, std::numeric_limits<std::uint64_t>::max() - 5000}) {
        const auto photons = traced.trace(first, 4000);
        expectSane(photons, traced.scene());
        double sum = 0.0;
        for (const Photon& p : photons) sum += p.flux.x;
        EXPECT_NEAR(sum, 2.0, 0.06) << first;
    }
}

TEST(Extremes, ReflectanceZeroAndOne) {
    Traced black(test::furnace(Rgb(0.0F)), {test::lamp(Vec3(50.0F), Rgb(1.0F))}, test::roulette(true, 8));
    EXPECT_EQ(black.trace(0, 100).size(), 100U);
    EXPECT_EQ(black.counts.absorbed, 100U);
    Traced white(test::furnace(Rgb(1.0F)), {test::lamp(Vec3(50.0F), Rgb(1.0F))}, test::roulette(true, 500));
    const auto photons = white.trace(0, 20);
    EXPECT_EQ(photons.size(), 20U * 501) << "recursionDepth bounds what nothing absorbs";
    expectSane(photons, white.scene());
    EXPECT_EQ(photons.back().bounce, 255) << "the stored bounce saturates";
    EXPECT_NEAR(white.counts.cutFlux[0], 1.0, 1e-5);
}

/// Furnaces 0.001 and 10,000,000 units wide, and one far from the origin: closed, and with the right sum.
TEST(Extremes, ScalesAndPlaces) {
    struct Case {
        float side;
        Vec3 at;
    };
    for (const Case& c : {Case{1e-3F, Vec3(0.0F)}, Case{1e7F, Vec3(0.0F)}, Case{1e7F, Vec3(-5e6F)},
                          Case{512.0F, Vec3(60000.0F, -60000.0F, 0.0F)}, Case{1.0F, Vec3(-0.5F)}}) {
        Traced traced(test::furnace(Rgb(0.6F), c.side, c.at), {test::lamp(c.at + 0.4F * Vec3(c.side), Rgb(1.0F))},
                      test::roulette(true, 100));
        const auto photons = traced.trace(0, 20'000);
        expectSane(photons, traced.scene());
        double sum = 0.0;
        for (const Photon& p : photons) sum += p.flux.x;
        EXPECT_NEAR(sum, 2.5, 0.03) << c.side;
        EXPECT_LT(traced.counts.escaped + traced.counts.backHits, 5U) << c.side << ' ' << c.at.x;
    }
}

/// On a surface a light shines to both sides; in a corner to what is open; inside a wall or outside it lights what it
/// sees from there, which is backs.
TEST(Extremes, LightsInOddPlaces) {
    const auto room = test::furnace(Rgb(0.5F), 64.0F);
    const auto total = [&](const Vec3& at, TraceCounts& counts) {
        Traced traced(room, {test::lamp(at, Rgb(1.0F))}, test::roulette(true, 0));
        const auto photons = traced.trace(0, 20'000);
        expectSane(photons, traced.scene());
        counts = traced.counts;
        double sum = 0.0;
        for (const Photon& p : photons) sum += p.flux.x;
        return sum;
    };
    TraceCounts counts;
    EXPECT_NEAR(total({32, 32, 64}, counts), 0.5, 0.01) << "on the ceiling";
    EXPECT_NEAR(counts.escapedFlux[0], 0.5, 0.01);
    EXPECT_NEAR(total({64, 64, 32}, counts), 0.25, 0.01) << "on an edge";
    EXPECT_NEAR(total({0, 0, 0}, counts), 0.125, 0.01) << "in a corner";
    EXPECT_EQ(total({200, 32, 32}, counts), 0.0) << "outside";
    EXPECT_GT(counts.backHits, 100U);
    EXPECT_EQ(total({1e30F, 0, 0}, counts), 0.0) << "far outside";
    for (int axis = 0; axis < 3; ++axis) {
        Vec3 nowhere(32.0F);
        nowhere[axis] = std::numeric_limits<float>::quiet_NaN();
        EXPECT_EQ(total(nowhere, counts), 0.0);
    }
}

TEST(Extremes, SliversDuplicatesAndCoplanarFaces) {
    test::RoomBuilder room;
    const auto wall = room.material(test::opaque(Rgb(0.5F)));
    room.inside(Vec3(0.0F), Vec3(100.0F), {wall, wall, wall, wall, wall, wall});
    room.inside(Vec3(0.0F), Vec3(100.0F), {wall, wall, wall, wall, wall, wall}); // all twice
    room.triangle({10, 10, 0}, {50, 10, 0}, {10, 50, 0}, wall);                  // on the floor
    room.triangle({10, 10, 50}, {90, 10, 50}, {50, 10.000001F, 50}, wall);       // a sliver
    Traced traced(room.build(), {test::lamp({30, 60, 45}, Rgb(1.0F))}, test::roulette(true, 100));
    const auto photons = traced.trace(0, 20'000);
    expectSane(photons, traced.scene());
    double sum = 0.0;
    for (const Photon& p : photons) sum += p.flux.x;
    EXPECT_NEAR(sum, 2.0, 0.02);
    EXPECT_LT(traced.counts.backHits + traced.counts.escaped, 5U);
}

TEST(Extremes, ManyPhotonsOfOneFrameStayInOrder) {
    // More than one batch of chunks.
    Traced traced(test::furnace(Rgb(0.0F), 8.0F), {test::lamp(Vec3(4.0F), Rgb(1.0F))}, test::roulette(true, 0));
    const auto photons = traced.trace(0, 600'000);
    ASSERT_EQ(photons.size(), 600'000U);
    for (std::size_t i = 0; i < photons.size(); ++i) ASSERT_EQ(photons[i].id, i);
    const auto later = traced.trace(550'000, 100);
    for (std::size_t i = 0; i < later.size(); ++i) ASSERT_EQ(later[i].position, photons[550'000 + i].position);
}

} // namespace
} // namespace pie::photons
