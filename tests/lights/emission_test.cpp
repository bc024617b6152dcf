// emit and illuminate describe the same light: photons that fall through a plane, against the integral of illuminate
// over it. A plane is cut into cells, both sides are estimated at random and compared cell by cell: |z| < 5 in every
// cell (false alarm 6e-7 each, below 1e-3 for this file).

#include "pie/lights/light_set.h"
#include "tests/lights/rooms.h"
#include "tests/sampling/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace pie::lights {
namespace {

constexpr int cells = 6; // a side
constexpr std::size_t photons = 400'000;
constexpr std::size_t samplesPerCell = 4'000;

/// A square receiver, seen from the side of its normal or, two-sided, from both.
struct Plane {
    Vec3 origin, side, up, normal;
    bool twoSided = false;
};
const Plane floorBelow{{-128, -128, 0}, {256, 0, 0}, {0, 256, 0}, {0, 0, 1}, false};

class EmissionTest : public testing::Test {
protected:
    static Plane tilted() {
        const Vec3 side = glm::normalize(Vec3(1.0F, 0.3F, 0.5F));
        const Vec3 up = glm::normalize(glm::cross(Vec3(0.0F, 0.0F, 1.0F), side));
        return {Vec3(-60, -40, -30), 120.0F * side, 120.0F * up, glm::cross(side, up), false};
    }

    /// `open`: whether light that reaches the point from `towards` comes in (sun and sky).
    void compare(const Light& light, const Plane& plane, const scene::Scene& scene = {},
                 const std::function<bool(const Vec3&, const Vec3&)>& open = {}) {
        std::mt19937 random(99);
        std::uniform_real_distribution<float> u(0.0F, 0x1.fffffep-1F);
        const SkyPortals portals = skyPortals(scene);
        std::array<test::Moments, std::size_t{cells} * cells> fallen;
        test::Moments total;
        for (std::size_t i = 0; i < photons; ++i) {
            const Emission e = emit(light, scene, portals, {u(random), u(random), u(random), u(random)});
            total.add(e.flux.y);
            ASSERT_NEAR(glm::length(e.direction), 1.0F, 1e-5F);
            std::array<double, std::size_t{cells} * cells> deposit{};
            const float cosine = -glm::dot(e.direction, plane.normal);
            const float t = glm::dot(e.origin - plane.origin, plane.normal) / cosine;
            if (t > 0.0F && std::isfinite(t) && (cosine > 0.0F || plane.twoSided)) {
                const Vec3 p = e.origin + t * e.direction - plane.origin;
                const float x = glm::dot(p, plane.side) / glm::dot(plane.side, plane.side);
                const float y = glm::dot(p, plane.up) / glm::dot(plane.up, plane.up);
                if (x >= 0.0F && x < 1.0F && y >= 0.0F && y < 1.0F)
                    deposit[static_cast<std::size_t>(static_cast<int>(x * cells) * cells +
                                                     static_cast<int>(y * cells))] =
                        e.flux.y * arrivalFactor(e, t, std::abs(cosine));
            }
            for (std::size_t k = 0; k < fallen.size(); ++k) fallen[k].add(deposit[k]);
        }
        const double stated = power(light, scene, portals).y;
        EXPECT_LT(std::abs(test::zScore(total.mean(), stated, total.squaredError())), 5.0)
            << kindName(light) << ": mean flux " << total.mean() << ", power " << stated;

        const double area = glm::length(plane.side) * glm::length(plane.up) / (cells * cells);
        double lit = 0.0;
        for (int x = 0; x < cells; ++x)
            for (int y = 0; y < cells; ++y) {
                test::Moments received;
                for (std::size_t i = 0; i < samplesPerCell; ++i) {
                    const Vec3 point = plane.origin + plane.side * ((static_cast<float>(x) + u(random)) / cells) +
                                       plane.up * ((static_cast<float>(y) + u(random)) / cells);
                    const Illumination got =
                        illuminate(light, point, plane.normal, plane.twoSided, {u(random), u(random)});
                    ASSERT_GE(got.irradiance.y, 0.0F);
                    received.add(!open || got.irradiance.y == 0.0F || open(point, got.towards) ? got.irradiance.y * area
                                                                                               : 0.0);
                }
                const auto& photonsHere = fallen[static_cast<std::size_t>(x * cells + y)];
                lit += received.mean();
                EXPECT_LT(std::abs(test::zScore(photonsHere.mean(), received.mean(),
                                                photonsHere.squaredError() + received.squaredError())),
                          5.0)
                    << kindName(light) << " cell " << x << ' ' << y << ": photons " << photonsHere.mean()
                    << ", illuminate " << received.mean();
            }
        EXPECT_GT(lit, 0.0) << "a test without light shows nothing";
    }
};

PointLight point(const Falloff& falloff) { return {{20, -30, 90}, Rgb(3e5F, 2e5F, 1e5F), falloff}; }
Falloff physical() {
    Falloff falloff;
    falloff.minDistance = 0;
    return falloff;
}

TEST_F(EmissionTest, Point) { compare(point(physical()), floorBelow); }
TEST_F(EmissionTest, PointOnTiltedPlane) { compare(PointLight{{0, 0, 60}, Rgb(1e5F), physical()}, tilted()); }
TEST_F(EmissionTest, PointNearerThanTheSmallestDistance) { compare(PointLight{{5, 5, 6}, Rgb(1e5F), {}}, floorBelow); }
TEST_F(EmissionTest, PointWithExtraDistance) {
    Falloff falloff;
    falloff.extraDistance = 80;
    compare(point(falloff), floorBelow);
}
TEST_F(EmissionTest, PointWithAngleScale) {
    Falloff falloff;
    falloff.angleScale = 0.6F;
    compare(point(falloff), floorBelow);
}
TEST_F(EmissionTest, PointWithoutCosine) {
    Falloff falloff;
    falloff.noCosine = true;
    compare(point(falloff), floorBelow);
}
TEST_F(EmissionTest, PointWithLinearFalloff) {
    Falloff falloff;
    falloff.linear = true;
    falloff.linearIntensity = 200;
    falloff.fade = 1;
    compare(point(falloff), floorBelow);
}
TEST_F(EmissionTest, PointOnTwoSidedPlane) {
    Plane plane = tilted();
    plane.twoSided = true;
    compare(PointLight{{0, 0, -70}, Rgb(1e5F), physical()}, plane);
}
TEST_F(EmissionTest, Sphere) { compare(SphereLight{{20, -30, 90}, Rgb(1e5F), 30, physical()}, floorBelow); }
TEST_F(EmissionTest, SphereThatReachesThroughThePlane) {
    compare(SphereLight{{0, 0, 10}, Rgb(1e5F), 24, {}}, floorBelow);
}
TEST_F(EmissionTest, Spot) {
    compare(SpotLight{{10, 0, 120}, glm::normalize(Vec3(0.2F, 0.3F, -1.0F)), Rgb(1e5F), 0.7F, 32, physical()},
            floorBelow);
}
TEST_F(EmissionTest, SpotWithSharpRim) {
    compare(SpotLight{{10, 0, 120}, Vec3(0, 0, -1), Rgb(1e5F), 0.5F, 0, physical()}, floorBelow);
}
TEST_F(EmissionTest, SpotWithinItsRimOnly) {
    compare(SpotLight{{0, 0, 40}, Vec3(0, 0, -1), Rgb(1e5F), 0.6F, 32, physical()}, floorBelow);
}

std::vector<Vec3> pentagon(float height) {
    std::vector<Vec3> corners; // counter-clockwise from below
    for (int i = 0; i < 5; ++i) {
        const double angle = -2.0 * std::numbers::pi * i / 5.0;
        corners.emplace_back(60.0 * std::cos(angle) + 20.0, 40.0 * std::sin(angle), height);
    }
    return corners;
}
TEST_F(EmissionTest, Area) { compare(makeAreaLight(pentagon(50), Rgb(100.0F)), floorBelow); }
TEST_F(EmissionTest, AreaFarAway) { compare(makeAreaLight(pentagon(900), Rgb(10000.0F)), floorBelow); }
TEST_F(EmissionTest, AreaAcrossTheHorizon) {
    // An upright wall panel that reaches below the plane.
    compare(makeAreaLight({{-100, -50, -40}, {-100, 50, -40}, {-100, 50, 60}, {-100, -50, 60}}, Rgb(100.0F)),
            floorBelow);
}
TEST_F(EmissionTest, AreaOfBothSides) {
    compare(makeAreaLight({{0, -50, 1}, {0, 50, 1}, {0, 50, 60}, {0, -50, 60}}, Rgb(100.0F), true), floorBelow);
}
TEST_F(EmissionTest, AreaThroughTwoSidedPlane) {
    Plane plane = tilted();
    plane.twoSided = true;
    compare(makeAreaLight({{70, -50, -60}, {70, -50, 60}, {70, 50, 60}, {70, 50, -60}}, Rgb(100.0F)), plane);
}

/// A hole of sky in a ceiling, made of uneven triangles.
std::shared_ptr<const scene::Scene> skylight() {
    test::RoomBuilder room;
    const auto m = room.material(test::sky());
    room.triangle({-80, -60, 100}, {-80, 60, 100}, {90, 60, 100}, m);
    room.triangle({-80, -60, 100}, {90, 60, 100}, {90, -60, 100}, m);
    return room.build();
}
bool throughSkylight(const Vec3& point, const Vec3& towards) {
    const Vec3 at = point + towards * ((100.0F - point.z) / towards.z);
    return towards.z > 0.0F && std::abs(at.y) < 60.0F && at.x > -80.0F && at.x < 90.0F;
}
TEST_F(EmissionTest, Sun) {
    compare(SunLight{glm::normalize(Vec3(0.5F, 0.2F, 1.0F)), Rgb(100.0F)}, floorBelow, *skylight(), throughSkylight);
}
TEST_F(EmissionTest, SunWithDisc) {
    compare(SunLight{glm::normalize(Vec3(0.5F, 0.2F, 1.0F)), Rgb(100.0F), 0.2F}, floorBelow, *skylight(),
            throughSkylight);
}
TEST_F(EmissionTest, SunWithDiscThatSetsBehindThePortal) {
    compare(SunLight{glm::normalize(Vec3(1.0F, 0.0F, 0.05F)), Rgb(100.0F), 0.2F},
            {{-700, -128, 0}, {600, 0, 0}, {0, 256, 0}, {0, 0, 1}, false}, *skylight(), throughSkylight);
}
TEST_F(EmissionTest, Sky) {
    SkyLight light;
    light.irradiance = Rgb(5.0F);
    for (int i = 0; i < 12; ++i)
        light.towards.push_back(
            glm::normalize(Vec3(std::cos(i * 0.52F), std::sin(i * 0.52F), 0.1F + 0.2F * static_cast<float>(i % 3))));
    light.towards.emplace_back(0.0F, 0.0F, 1.0F);
    light.towards.push_back(glm::normalize(Vec3(0.3F, 0.0F, -1.0F))); // from below: the portal faces away
    compare(light, floorBelow, *skylight(), throughSkylight);
}

TEST(SkyPortals, LightEntersOnTheFrontOnly) {
    const auto scene = skylight();
    const SkyPortals portals = skyPortals(*scene);
    EXPECT_EQ(portals.groups.size(), 1U);
    EXPECT_NEAR(projectedArea(portals, Vec3(0, 0, 1)), 170.0 * 120.0, 1e-2);
    EXPECT_NEAR(projectedArea(portals, Vec3(0.6F, 0, 0.8F)), 0.8 * 170.0 * 120.0, 1e-2);
    EXPECT_EQ(projectedArea(portals, Vec3(0, 0, -1)), 0.0);
}

TEST(SkyPortals, SunWithoutSkyHasNoPower) {
    const scene::Scene scene;
    EXPECT_EQ(power(SunLight{Vec3(0, 0, 1), Rgb(100.0F)}, scene, skyPortals(scene)), Rgb(0.0F));
    EXPECT_EQ(emit(SunLight{Vec3(0, 0, 1), Rgb(100.0F)}, scene, skyPortals(scene), {}).flux, Rgb(0.0F));
    EXPECT_EQ(emit(SkyLight{{Vec3(0, 0, 1)}, Rgb(1.0F)}, scene, skyPortals(scene), {}).flux, Rgb(0.0F));
}

} // namespace
} // namespace pie::lights
