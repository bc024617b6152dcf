// Numbers that must not break it, each with its stated behaviour.

#include "tests/photons/traced.h"
#include "tests/sampling/distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

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

double sumOf(const std::vector<Photon>& photons) {
    double sum = 0.0;
    for (const Photon& p : photons) sum += p.flux.x;
    return sum;
}

/// Indices count modulo 2^64: a counter that runs over goes on from 0, and nothing tears at the seam.
TEST(Extremes, IndicesWrapAround) {
    for (const sampling::Distribution distribution : test::allDistributions) {
        TracerOptions options = test::roulette(true, 60);
        options.lightDistribution = options.diffuseDistribution = distribution;
        options.photonsPerFrame = 1000;
        options.seed = 3;
        Traced traced(test::furnace(Rgb(0.5F)), {test::lamp(Vec3(50.0F), Rgb(1.0F))}, options);
        const std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
        const auto across = traced.trace(last - 1499, 3000);
        expectSane(across, traced.scene());
        EXPECT_NEAR(sumOf(across), 2.0, 0.1) << test::distributionName(distribution);
        auto parts = traced.trace(last - 1499, 1500);
        const auto rest = traced.trace(0, 1500);
        parts.insert(parts.end(), rest.begin(), rest.end());
        ASSERT_EQ(across.size(), parts.size()) << test::distributionName(distribution);
        for (std::size_t i = 0; i < parts.size(); ++i) {
            ASSERT_EQ(across[i].position, parts[i].position) << test::distributionName(distribution) << ' ' << i;
            ASSERT_EQ(across[i].direction, parts[i].direction);
        }
    }
}

/// The largest frame that the settings allow. A plate that catches its share of a point source's light: the share of a
/// disc seen under a cone is exact, that of the square comes from its corner's solid angle.
TEST(Extremes, TenMillionPhotons) {
    test::RoomBuilder room;
    const auto black = room.material(test::opaque(Rgb(0.0F)));
    room.quad({-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, black);
    constexpr double height = 3.0;
    Traced traced(room.build(), {test::lamp({0, 0, height}, Rgb(1.0F))}, test::roulette(true, 8));
    const auto photons = traced.trace(0, 10'000'000);
    EXPECT_EQ(traced.counts.emitted, 10'000'000U);
    EXPECT_EQ(traced.counts.emitted, traced.counts.escaped + traced.counts.absorbed);
    EXPECT_EQ(traced.counts.stored, photons.size());
    // A rectangle 2a by 2b at height h: solid angle 4 asin(a b / sqrt((a² + h²)(b² + h²))).
    const double share = 4.0 * std::asin(1.0 / (1.0 + height * height)) / (4.0 * std::numbers::pi);
    EXPECT_NEAR(static_cast<double>(photons.size()) / 1e7 / share, 1.0, 1e-3);
    EXPECT_NEAR(sumOf(photons) / share, 1.0, 1e-3) << "shares of 1e-7 add up";
    for (std::size_t i = 0; i < photons.size(); i += 997) ASSERT_EQ(photons[i].id, i);
}

/// Every kind of light in rooms from 0.001 to 10,000,000 units, in the middle and far from the origin: what enters a
/// closed room stays there, Φ / (1 − ρ) of it is stored.
TEST(Extremes, EveryLightAtEveryScale) {
    struct Case {
        float side;
        Vec3 at;
    };
    for (const Case& c :
         {Case{1e-3F, Vec3(0.0F)}, Case{1e7F, Vec3(-5e6F)}, Case{512.0F, Vec3(60000.0F, -60000.0F, 0.0F)}}) {
        const auto point = [&](float x, float y, float z) { return c.at + c.side * Vec3(x, y, z); };
        const auto panel = [&](float z) {
            return std::vector<Vec3>{point(0.3F, 0.3F, z), point(0.3F, 0.7F, z), point(0.7F, 0.7F, z),
                                     point(0.7F, 0.3F, z)};
        };
        lights::Falloff physical;
        physical.minDistance = 0;
        const float area = 0.16F * c.side * c.side;
        const std::array kinds{
            lights::Light(lights::PointLight{point(0.4F, 0.4F, 0.5F), Rgb(1.0F), physical}),
            lights::Light(lights::SphereLight{point(0.4F, 0.4F, 0.5F), Rgb(1.0F), 0.1F * c.side, physical}),
            lights::Light(lights::SpotLight{point(0.5F, 0.5F, 0.9F), {0, 0, -1}, Rgb(1.0F), 0.5F, 0.0F, physical}),
            lights::Light(lights::makeAreaLight(panel(1.0F), Rgb(1.0F / area))), // on the ceiling, facing down
            lights::Light(lights::makeAreaLight(panel(0.5F), Rgb(0.5F / area), true))};
        for (const lights::Light& light : kinds) {
            Traced traced(test::furnace(Rgb(0.6F), c.side, c.at), {light}, test::roulette(true, 100));
            const auto photons = traced.trace(0, 10'000);
            expectSane(photons, traced.scene());
            const double watts = traced.lights().totalPower().x;
            EXPECT_NEAR(sumOf(photons) / watts, 2.5, 0.05) << lights::kindName(light) << ' ' << c.side;
            EXPECT_LT(traced.counts.escaped + traced.counts.backHits, 5U) << lights::kindName(light) << ' ' << c.side;
        }
    }
}

/// Between the walls of two rooms, in what is solid, there are backs only: nothing is stored, nothing hangs, and the
/// watts are in the books.
TEST(Extremes, ALightInsideAWall) {
    test::RoomBuilder rooms;
    const auto wall = rooms.material(test::opaque(Rgb(0.9F)));
    rooms.inside({0, 0, 0}, {100, 100, 100}, {wall, wall, wall, wall, wall, wall});
    rooms.inside({116, 0, 0}, {200, 100, 100}, {wall, wall, wall, wall, wall, wall});
    Traced traced(rooms.build(), {test::lamp({108, 50, 50}, Rgb(7.0F))}, test::roulette(true, 8));
    EXPECT_TRUE(traced.trace(0, 5000).empty());
    EXPECT_GT(traced.counts.backHits, 4000U);
    EXPECT_EQ(traced.counts.rays, 5000U) << "a back ends a path";
    EXPECT_NEAR(traced.counts.absorbedFlux[0] + traced.counts.escapedFlux[0], 7.0, 1e-4);
}

/// Triangles without area, and area lights on them, are there and do nothing.
TEST(Extremes, NothingHasNoArea) {
    test::RoomBuilder room;
    const auto wall = room.material(test::opaque(Rgb(0.5F)));
    room.inside(Vec3(0.0F), Vec3(100.0F), {wall, wall, wall, wall, wall, wall});
    room.triangle(Vec3(50.0F), Vec3(50.0F), Vec3(50.0F), wall);    // a point
    room.triangle({10, 50, 50}, {50, 50, 50}, {90, 50, 50}, wall); // a line
    room.triangle({20, 20, 0}, {20, 20, 0}, {80, 20, 0}, wall);    // a line on the floor
    const auto scene = room.build();
    std::vector<lights::Light> list{test::lamp({30, 60, 45}, Rgb(1.0F))};
    list.emplace_back(lights::makeAreaLight({{10, 50, 50}, {50, 50, 50}, {90, 50, 50}}, Rgb(1e9F)));
    list.emplace_back(lights::makeAreaLight({}, Rgb(1e9F), true));
    Traced traced(scene, list, test::roulette(true, 100));
    const auto photons = traced.trace(0, 20'000);
    expectSane(photons, traced.scene());
    EXPECT_NEAR(traced.lights().totalPower().x, 1.0, 1e-6);
    EXPECT_NEAR(sumOf(photons), 2.0, 0.03);
    EXPECT_LT(traced.counts.escaped + traced.counts.backHits, 5U);
}

/// Lights that are not lights emit nothing, and leave the others theirs; a tiny one beside a huge one keeps its watts.
TEST(Extremes, LightsThatAreNone) {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    constexpr float infinite = std::numeric_limits<float>::infinity();
    const std::vector<lights::Light> none{test::lamp(Vec3(50.0F), Rgb(0.0F)),
                                          test::lamp(Vec3(50.0F), Rgb(nan)),
                                          test::lamp(Vec3(50.0F), Rgb(infinite)),
                                          lights::SunLight{Vec3(0.0F), Rgb(1.0F), 0.0F},
                                          lights::SunLight{{0, 0, 1}, Rgb(1.0F), 0.0F}, // no sky to come in by
                                          lights::SkyLight{{{0, 0, 1}}, Rgb(1.0F)},
                                          lights::SkyLight{{}, Rgb(1.0F)},
                                          lights::SpotLight{Vec3(50.0F), Vec3(0.0F), Rgb(1.0F), 0.5F, 32, {}},
                                          lights::SpotLight{Vec3(50.0F), {0, 0, -1}, Rgb(1.0F), 0.0F, 32, {}}};
    Traced dark(test::furnace(Rgb(0.5F)), none, test::roulette(true, 8));
    EXPECT_TRUE(dark.lights().empty());
    EXPECT_TRUE(dark.trace(0, 100).empty());
    EXPECT_EQ(dark.counts.rays, 0U);
    auto some = none;
    some.push_back(test::lamp(Vec3(50.0F), Rgb(3.0F)));
    Traced lit(test::furnace(Rgb(0.5F)), some, test::roulette(true, 60));
    EXPECT_NEAR(sumOf(lit.trace(0, 10'000)), 6.0, 0.1);
    Traced both(test::furnace(Rgb(0.0F)), {test::lamp(Vec3(50.0F), Rgb(1e-30F)), test::lamp(Vec3(20.0F), Rgb(1e30F))},
                test::roulette(true, 0));
    const auto photons = both.trace(0, 1000);
    expectSane(photons, both.scene());
    EXPECT_NEAR(sumOf(photons) / 1e30, 1.0, 1e-3);
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
