// Irradiance against closed forms.

#include "pie/lights/light.h"
#include "tests/sampling/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace pie::lights {
namespace {

using glm::dvec3;
constexpr double pi = std::numbers::pi;

Rgb at(const Light& light, const Vec3& point, const Vec3& normal = {0, 0, 1}) {
    return illuminate(light, point, normal, false, {0.4F, 0.7F}).irradiance;
}

TEST(Illumination, EntityFormulasOfTheLevelCompiler) {
    const auto watts = static_cast<float>(4.0 * pi * 7500.0 * 300.0);
    Falloff falloff;
    PointLight light{{0, 0, 100}, Rgb(watts), falloff};
    EXPECT_NEAR(at(light, {0, 0, 0}).x, 7500.0 * 300.0 / 1e4, 1e-2);
    EXPECT_NEAR(at(light, {100, 0, 0}).x, 7500.0 * 300.0 / 2e4 * std::sqrt(0.5), 1e-2);
    EXPECT_EQ(at(light, {0, 0, 0}, {0, 0, -1}), Rgb(0.0F));
    EXPECT_NEAR(at(light, {0, 0, 96}).x, 7500.0 * 300.0 / 256.0, 1e-1) << "at least 16 units";
    light.falloff.extraDistance = 100;
    EXPECT_NEAR(at(light, {0, 0, 0}).x, 7500.0 * 300.0 / 2e4, 1e-2);
    light.falloff = falloff;
    light.falloff.noCosine = true;
    EXPECT_NEAR(at(light, {100, 0, 0}).x, 7500.0 * 300.0 / 2e4, 1e-2);
    light.falloff = falloff;
    light.falloff.angleScale = 0.5F;
    EXPECT_NEAR(at(light, {100, 0, 0}).x, 7500.0 * 300.0 / 2e4, 1e-2) << "cos 0.707 / 0.5 is cut at 1";
    EXPECT_NEAR(at(light, {400, 0, 0}).x, 7500.0 * 300.0 / 1.7e5 * 100.0 / std::sqrt(1.7e5) / 0.5, 1e-2);
}

TEST(Illumination, SpotFadesOverItsRim) {
    SpotLight light{{0, 0, 100}, {0, 0, -1}, Rgb(static_cast<float>(4.0 * pi * 1e4)), 0.8F, 32, {}};
    const auto unshaded = [](double r) { return 1e4 / (1e4 + r * r) * 100.0 / std::sqrt(1e4 + r * r); };
    EXPECT_NEAR(at(light, {48, 0, 0}).x, unshaded(48), 1e-3);
    EXPECT_NEAR(at(light, {64, 0, 0}).x, 0.5 * unshaded(64), 1e-3);
    EXPECT_NEAR(at(light, {0, 72, 0}).x, 0.25 * unshaded(72), 1e-3);
    EXPECT_EQ(at(light, {81, 0, 0}), Rgb(0.0F));
    EXPECT_EQ(at(light, {0, 0, 200}, {0, 0, -1}), Rgb(0.0F)) << "behind";
}

/// Newton: outside a shell the field is that of its centre.
TEST(Illumination, SphereAboveTheHorizonEqualsAPoint) {
    Falloff physical;
    physical.minDistance = 0;
    const SphereLight sphere{{30, 0, 100}, Rgb(1e5F), 60, physical};
    const double expected = at(PointLight{sphere.position, sphere.power, physical}, Vec3(0.0F)).x;
    double sum = 0.0;
    constexpr int steps = 400;
    for (int i = 0; i < steps; ++i)
        for (int k = 0; k < steps; ++k)
            sum += illuminate(sphere, Vec3(0.0F), {0, 0, 1}, false,
                              {(static_cast<float>(i) + 0.5F) / steps, (static_cast<float>(k) + 0.5F) / steps})
                       .irradiance.x;
    EXPECT_NEAR(sum / (steps * steps) / expected, 1.0, 1e-4);
}

/// Irradiance of a Lambertian polygon by brute force over its area.
double bruteForce(const AreaLight& light, const dvec3& point, const dvec3& normal, bool twoSided) {
    constexpr int steps = 500;
    double sum = 0.0;
    for (std::size_t f = 0; f + 2 < light.corners.size(); ++f) {
        const dvec3 a(light.corners[0]);
        const dvec3 ab = dvec3(light.corners[f + 1]) - a;
        const dvec3 ac = dvec3(light.corners[f + 2]) - a;
        const double area = 0.5 * glm::length(glm::cross(ab, ac));
        for (int i = 0; i < steps; ++i)
            for (int k = 0; k < steps - i; ++k)
                for (int upper = 0; upper < (k + 1 < steps - i ? 2 : 1); ++upper) {
                    const double s = (i + (upper != 0 ? 2.0 / 3.0 : 1.0 / 3.0)) / steps;
                    const double t = (k + (upper != 0 ? 2.0 / 3.0 : 1.0 / 3.0)) / steps;
                    const dvec3 way = a + s * ab + t * ac - point;
                    const double d2 = glm::dot(way, way);
                    double c = glm::dot(way, normal) / std::sqrt(d2);
                    double e = -glm::dot(way, dvec3(light.normal)) / std::sqrt(d2);
                    c = twoSided ? std::abs(c) : std::max(0.0, c);
                    e = light.twoSided ? std::abs(e) : std::max(0.0, e);
                    sum += c * e / d2 * area / (steps * steps);
                }
    }
    return sum * light.radiosity.x / pi;
}

/// Of a rectangle parallel to the receiver at height h over it, from x0 to x1 and y0 to y1: four corner rectangles.
double parallelRectangle(double x0, double x1, double y0, double y1, double h) {
    const auto corner = [h](double x, double y) {
        x /= h;
        y /= h;
        const double rx = std::sqrt(1.0 + x * x);
        const double ry = std::sqrt(1.0 + y * y);
        return (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry)) / (2.0 * pi);
    };
    return corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0);
}

TEST(Illumination, BruteForceAgreesWithTheClosedForm) {
    const AreaLight light = makeAreaLight({{-30, -20, 40}, {-30, 50, 40}, {60, 50, 40}, {60, -20, 40}}, Rgb(100.0F));
    EXPECT_NEAR(bruteForce(light, dvec3(0.0), dvec3(0, 0, 1), false), 100.0 * parallelRectangle(-30, 60, -20, 50, 40),
                1e-3);
}

struct AreaCase {
    const char* name;
    std::vector<Vec3> corners;
    Vec3 normal;
    bool lightBoth = false, receiverBoth = false;
    double noise = 0.0; ///< largest relative standard deviation of one sample
    double exact = 0.0; ///< 0: by brute force
};

std::vector<AreaCase> areaCases() {
    const std::vector<Vec3> above{{-30, -20, 40}, {-30, 50, 40}, {60, 50, 40}, {60, -20, 40}};
    const std::vector<Vec3> beside{{-20, -40, 0}, {-20, 40, 0}, {-20, 40, 80}, {-20, -40, 80}};
    const std::vector<Vec3> across{{-20, -40, -60}, {-20, 40, -60}, {-20, 40, 80}, {-20, -40, 80}};
    const std::vector<Vec3> near{{-300, -300, 1}, {-300, 300, 1}, {300, 300, 1}, {300, -300, 1}};
    const std::vector<Vec3> strip{{-400, 10, 30}, {-400, 12, 30}, {400, 12, 30}, {400, 10, 30}};
    std::vector<Vec3> hexagon;
    for (int i = 0; i < 6; ++i) hexagon.emplace_back(40.0 * std::cos(-i * pi / 3), 40.0 * std::sin(-i * pi / 3), 25.0);
    const Vec3 up(0, 0, 1);
    const Vec3 slant = glm::normalize(Vec3(-0.8F, 0.3F, 0.5F));
    return {{"above", above, up, false, false, 0.06},
            {"above, slanted", above, slant, false, false, 0.08},
            {"beside", beside, up, false, false, 0.1},
            {"across the horizon", across, up, false, false, 0.1},
            {"across, receiver two-sided", across, up, false, true, 0.1},
            {"both sides", above, up, true, false, 0.06},
            {"very near", near, up, false, false, 0.15, 100.0 * parallelRectangle(-300, 300, -300, 300, 1)},
            {"strip", strip, up, false, false, 0.12},
            {"hexagon", hexagon, up, false, false, 0.06}};
}

/// The mean over u is the exact form factor, and a sample strays little from it.
TEST(Illumination, AreaLightIsItsFormFactor) {
    for (const AreaCase& c : areaCases()) {
        const AreaLight light = makeAreaLight(c.corners, Rgb(100.0F), c.lightBoth);
        const double expected =
            c.exact > 0.0 ? c.exact : bruteForce(light, dvec3(0.0), dvec3(c.normal), c.receiverBoth);
        test::Moments samples;
        constexpr int steps = 200;
        for (int i = 0; i < steps; ++i)
            for (int k = 0; k < steps; ++k) {
                const Illumination got =
                    illuminate(light, Vec3(0.0F), c.normal, c.receiverBoth,
                               {(static_cast<float>(i) + 0.5F) / steps, (static_cast<float>(k) + 0.5F) / steps});
                samples.add(got.irradiance.x);
                ASSERT_NEAR(glm::length(got.towards), 1.0F, 1e-5F);
                const Vec3 hit = got.distance * got.towards;
                ASSERT_LT(std::abs(glm::dot(hit - light.corners[0], light.normal)), 1e-3F * (1.0F + got.distance))
                    << c.name;
            }
        EXPECT_NEAR(samples.mean() / expected, 1.0, 2e-3) << c.name;
        EXPECT_LT(std::sqrt(samples.variance()) / expected, c.noise) << c.name;
    }
}

/// What is half covered is lit by what is left: samples fall by their share of the form factor, not by area.
TEST(Illumination, AreaLightSamplesFollowTheIntegrand) {
    for (const AreaCase& c : areaCases()) {
        const AreaLight whole = makeAreaLight(c.corners, Rgb(100.0F), c.lightBoth);
        // Cover all with x > 5 (for upright panels: y > 5).
        const auto covered = [&](const Vec3& p) { return std::abs(whole.normal.x) > 0.5F ? p.y > 5.0F : p.x > 5.0F; };
        test::Moments left;
        test::Moments brute;
        std::mt19937 random(5);
        std::uniform_real_distribution<float> u(0.0F, 0x1.fffffep-1F);
        for (int i = 0; i < 40'000; ++i) {
            const Illumination got = illuminate(whole, Vec3(0.0F), c.normal, c.receiverBoth, {u(random), u(random)});
            left.add(covered(got.distance * got.towards) ? 0.0 : got.irradiance.x);
        }
        // The same by area sampling written out, random.
        std::uniform_real_distribution<double> d(0.0, 1.0);
        for (int i = 0; i < 400'000; ++i) {
            const std::size_t fans = whole.corners.size() - 2;
            const auto f = static_cast<std::size_t>(d(random) * static_cast<double>(fans));
            double s = d(random);
            double t = d(random);
            if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
            const dvec3 a(whole.corners[0]);
            const dvec3 ab = dvec3(whole.corners[f + 1]) - a;
            const dvec3 ac = dvec3(whole.corners[f + 2]) - a;
            const dvec3 p = a + s * ab + t * ac;
            double cosine = glm::dot(glm::normalize(p), dvec3(c.normal));
            double emitted = -glm::dot(glm::normalize(p), dvec3(whole.normal));
            cosine = c.receiverBoth ? std::abs(cosine) : std::max(0.0, cosine);
            emitted = c.lightBoth ? std::abs(emitted) : std::max(0.0, emitted);
            brute.add(covered(Vec3(p)) ? 0.0
                                       : 100.0 / pi * cosine * emitted / glm::dot(p, p) * 0.5 *
                                             glm::length(glm::cross(ab, ac)) * static_cast<double>(fans));
        }
        EXPECT_LT(std::abs(test::zScore(left.mean(), brute.mean(), left.squaredError() + brute.squaredError())), 5.0)
            << c.name << ": " << left.mean() << ' ' << brute.mean();
    }
}

TEST(Illumination, AreaLightGivesNothingBehindAndInItsPlane) {
    const AreaLight light = makeAreaLight({{-30, -20, 40}, {-30, 50, 40}, {60, 50, 40}, {60, -20, 40}}, Rgb(100.0F));
    EXPECT_EQ(light.normal, Vec3(0, 0, -1));
    for (const Vec3& p : {Vec3(0, 0, 50), Vec3(0, 0, 40), Vec3(-30, -20, 40), Vec3(500, 0, 40)})
        for (const Vec3& n : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0)}) EXPECT_EQ(at(light, p, n), Rgb(0.0F));
    EXPECT_GT(at(light, {0, 0, 39.9F}).x, 90.0F) << "just below: nearly all of the hemisphere";
}

TEST(Illumination, DegeneratePolygonsGiveNothing) {
    for (const auto& corners : {std::vector<Vec3>{},
                                {{0, 0, 1}},
                                {{0, 0, 1}, {1, 0, 1}},
                                {{0, 0, 1}, {1, 0, 1}, {2, 0, 1}},
                                {{3, 3, 3}, {3, 3, 3}, {3, 3, 3}}}) {
        const AreaLight light = makeAreaLight(corners, Rgb(100.0F));
        EXPECT_EQ(at(light, Vec3(0.0F)), Rgb(0.0F));
        EXPECT_EQ(power(light, {}, {}), Rgb(0.0F));
        EXPECT_EQ(emit(light, {}, {}, {}).flux, Rgb(0.0F));
    }
}

TEST(Illumination, ScalesFromTinyToHuge) {
    for (const float scale : {1e-3F, 1.0F, 1e7F}) {
        const AreaLight light = makeAreaLight({{-3 * scale, -2 * scale, 4 * scale},
                                               {-3 * scale, 5 * scale, 4 * scale},
                                               {6 * scale, 5 * scale, 4 * scale},
                                               {6 * scale, -2 * scale, 4 * scale}},
                                              Rgb(100.0F));
        double sum = 0.0;
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x)
                sum += illuminate(light, Vec3(0.0F), {0, 0, 1}, false,
                                  {(static_cast<float>(x) + 0.5F) / 32, (static_cast<float>(y) + 0.5F) / 32})
                           .irradiance.x;
        EXPECT_NEAR(sum / 1024.0, bruteForce(light, dvec3(0.0), dvec3(0, 0, 1), false), 0.1) << scale;
    }
}

TEST(Illumination, FiniteAtTheSourceAndForExtremePowers) {
    Falloff physical;
    physical.minDistance = 0;
    for (const float watts : {0.0F, 1e-30F, 1e30F})
        for (const Vec3& p : {Vec3(0.0F), Vec3(1e-20F, 0, 0), Vec3(1e18F, 0, 1)}) {
            for (const Light& light :
                 {Light(PointLight{{0, 0, 0}, Rgb(watts), {}}), Light(SphereLight{{0, 0, 0}, Rgb(watts), 5, {}}),
                  Light(SpotLight{{0, 0, 0}, {1, 0, 0}, Rgb(watts), 1, 32, {}}),
                  Light(SunLight{{0, 0, 1}, Rgb(watts)})}) {
                const Illumination got = illuminate(light, p, {-1, 0, 0}, true, {0.3F, 0.6F});
                for (int i = 0; i < 3; ++i) EXPECT_TRUE(std::isfinite(got.irradiance[i])) << kindName(light);
            }
        }
    EXPECT_EQ(at(PointLight{{0, 0, 0}, Rgb(1.0F), physical}, Vec3(0.0F)), Rgb(0.0F))
        << "in the source: no direction, no light";
}

TEST(Illumination, LightsWithoutDirectionGiveNothing) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const Vec3& direction : {Vec3(0.0F), Vec3(0, 0, 2), Vec3(nan)}) {
        const SpotLight spot{{0, 0, 10}, direction, Rgb(100.0F), 1, 32, {}};
        EXPECT_EQ(at(spot, Vec3(0.0F)), Rgb(0.0F));
        EXPECT_EQ(power(spot, {}, {}), Rgb(0.0F));
        EXPECT_EQ(at(SunLight{direction, Rgb(100.0F), 0.1F}, Vec3(0.0F)), Rgb(0.0F));
    }
}

TEST(Illumination, SunAndSkyAskForSky) {
    const Illumination sun = illuminate(SunLight{{0, 0.6F, 0.8F}, Rgb(10.0F)}, Vec3(0.0F), {0, 0, 1}, false, {});
    EXPECT_TRUE(sun.needsSky);
    EXPECT_TRUE(std::isinf(sun.distance));
    EXPECT_NEAR(sun.irradiance.x, 8.0, 1e-5);
    SkyLight sky{{{0, 0, 1}, {0, 1, 0}, {0, 0.6F, 0.8F}}, Rgb(2.0F)};
    ASSERT_EQ(sampleCount(sky), 3U);
    double sum = 0.0;
    for (int i = 0; i < 3; ++i)
        sum += illuminate(sky, Vec3(0.0F), {0, 0, 1}, false, {(static_cast<float>(i) + 0.5F) / 3, 0.5F}).irradiance.x /
               3.0;
    EXPECT_NEAR(sum, 2.0 * (1.0 + 0.0 + 0.8), 1e-5);
}

} // namespace
} // namespace pie::lights
