// Direct light: the formulas of the level compiler where nothing is in the way, shadows where something is, and levels
// with more lights than anyone wants to test.

#include "pie/core/parallel.h"
#include "pie/gather/direct.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace pie::gather {
namespace {

using lights::AreaLight;
using lights::Light;
using lights::PointLight;
using lights::SkyLight;
using lights::SphereLight;
using lights::SpotLight;
using lights::SunLight;
using test::all;
using test::receiverAt;
using test::receiversAt;
using test::SceneBuilder;

constexpr float pi = std::numbers::pi_v<float>;
const Vec3 up(0.0F, 0.0F, 1.0F);
constexpr float intensity300 = 300;

/// A floor of 2048 units about the origin.
SceneBuilder floorScene() {
    SceneBuilder builder;
    builder.grey(0.5F);
    builder.quad({-1024.0F, -1024.0F, 0.0F}, {2048.0F, 0.0F, 0.0F}, {0.0F, 2048.0F, 0.0F});
    return builder;
}

std::uint32_t addSky(SceneBuilder& builder, float height) {
    scene::Material sky;
    sky.interaction = scene::Interaction::Sky;
    const std::uint32_t number = builder.material(sky);
    builder.quad({-1024.0F, -1024.0F, height}, {0.0F, 2048.0F, 0.0F}, {2048.0F, 0.0F, 0.0F}, number);
    return number;
}

PointLight point(const Vec3& position, float intensity = intensity300) {
    PointLight light;
    light.position = position;
    light.power = Rgb(4.0F * pi * 7500.0F * intensity);
    return light;
}

AreaLight lamp(const Vec3& origin, const Vec3& u, const Vec3& v, float radiosity) {
    AreaLight light;
    light.corners = {origin, origin + u, origin + u + v, origin + v};
    light.normal = glm::normalize(glm::cross(u, v));
    light.area = static_cast<double>(glm::length(glm::cross(u, v)));
    light.radiosity = Rgb(radiosity);
    return light;
}

struct Lit {
    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<intersect::Intersector> intersector;
    lights::LightSet lights;
    scene::Receivers receivers;
    DirectOptions options;

    Lit(const SceneBuilder& builder, std::vector<Light> sources, std::vector<scene::Receiver> points,
        intersect::Kind kind = intersect::Kind::BruteForce)
        : scene(builder.make()), intersector(intersect::makeIntersector(kind, *scene, {})),
          lights(std::move(sources), scene), receivers(receiversAt(std::move(points))) {}
    [[nodiscard]] std::vector<Rgb> irradiance(std::uint64_t* rays = nullptr) const {
        const DirectLight direct(*scene, lights, *intersector, receivers, options);
        std::vector<Rgb> result(receivers.points.size(), Rgb(-1.0F));
        direct.estimate(all(receivers), result);
        if (rays != nullptr) *rays = direct.raysTraced();
        return result;
    }
    [[nodiscard]] float first() const { return irradiance()[0].x; }
};

float first(const SceneBuilder& builder, const Light& light, const scene::Receiver& receiver) {
    return Lit(builder, {light}, {receiver}).first();
}

// ---- formulas, nothing in the way (half a per cent) ----

TEST(DirectLight, PointLights) {
    const SceneBuilder floor = floorScene();
    const scene::Receiver at = receiverAt({300.0F, 0.0F, 0.0F}, up);
    const float d = 500;
    const float cosine = 0.8F;
    EXPECT_NEAR(first(floor, point({0.0F, 0.0F, 400.0F}), at), 7500.0F * 300.0F * cosine / (d * d), 0.005F * 7.2F);
    EXPECT_EQ(first(floor, point({0.0F, 0.0F, -400.0F}), at), 0.0F);

    PointLight light = point({0.0F, 0.0F, 400.0F});
    light.falloff.extraDistance = 250.0F;
    EXPECT_NEAR(first(floor, light, at), 7500.0F * 300.0F * cosine / (d * d + 250.0F * 250.0F), 0.005F * 5.76F);
    light.falloff = {};
    light.falloff.noCosine = true;
    EXPECT_NEAR(first(floor, light, at), 9.0F, 0.005F * 9.0F);
    light.falloff = {};
    light.falloff.angleScale = 0.5F;
    EXPECT_NEAR(first(floor, light, at), 9.0F, 0.005F * 9.0F);
    light.falloff = {};
    light.falloff.linear = true;
    light.falloff.linearIntensity = 800.0F;
    light.falloff.fade = 0.5F;
    light.power = lights::power(light, *floor.make(), {});
    // E = 0.9375 I − fade d' times its colour; the colour's scale is that of the power, so compare two distances.
    const float near = first(floor, light, receiverAt({0.0F, 0.0F, 0.0F}, up));
    const float far = first(floor, light, at);
    EXPECT_NEAR(far / near, (750.0F - 250.0F) / (750.0F - 200.0F), 0.005F);
    // Within 16 units the fall-off stands still.
    light = point({0.0F, 0.0F, 8.0F});
    EXPECT_NEAR(first(floor, light, receiverAt(Vec3(0.0F), up)), 7500.0F * 300.0F / 256.0F, 0.005F * 8789.0F);
}

TEST(DirectLight, SpheresAndSpots) {
    const SceneBuilder floor = floorScene();
    SphereLight sphere;
    sphere.position = {0.0F, 0.0F, 400.0F};
    sphere.radius = 20.0F;
    sphere.power = Rgb(4.0F * pi * 7500.0F * 300.0F);
    const float centre = 7500.0F * 300.0F * 0.8F / 250'000.0F;
    EXPECT_NEAR(first(floor, sphere, receiverAt({300.0F, 0.0F, 0.0F}, up)), centre, 0.005F * centre);

    SpotLight spot;
    spot.position = {0.0F, 0.0F, 400.0F};
    spot.direction = -up;
    spot.power = sphere.power;
    spot.slope = 0.5F; // 200 units wide on the floor, the outer 32 dimmed
    const float peak = 7500.0F * 300.0F / 160'000.0F;
    EXPECT_NEAR(first(floor, spot, receiverAt(Vec3(0.0F), up)), peak, 0.005F * peak);
    EXPECT_EQ(first(floor, spot, receiverAt({210.0F, 0.0F, 0.0F}, up)), 0.0F);
    const float rim = first(floor, spot, receiverAt({184.0F, 0.0F, 0.0F}, up));
    const double d = std::sqrt(400.0 * 400.0 + 184.0 * 184.0);
    EXPECT_NEAR(static_cast<double>(rim), 0.5 * 7500 * 300 * 400 / (d * d * d), 0.01 * 5);
}

TEST(DirectLight, SunsAndSkies) {
    SceneBuilder builder = floorScene();
    addSky(builder, 900.0F);
    SunLight sun;
    sun.towards = {0.6F, 0.0F, 0.8F};
    sun.irradiance = Rgb(100.0F);
    EXPECT_NEAR(first(builder, sun, receiverAt(Vec3(0.0F), up)), 80.0F, 0.4F);
    EXPECT_EQ(first(builder, sun, receiverAt(Vec3(0.0F), -up)), 0.0F);
    // Past the rim of the sky there is nothing the light could come through.
    EXPECT_EQ(first(builder, sun, receiverAt({700.0F, 0.0F, 0.0F}, up)), 0.0F);
    sun.devianceRadians = 0.02F;
    EXPECT_NEAR(first(builder, sun, receiverAt(Vec3(0.0F), up)), 80.0F, 0.4F);

    SkyLight sky;
    sky.irradiance = Rgb(10.0F);
    float expected = 0;
    for (int i = 0; i < 13; ++i) {
        const float azimuth = 2.0F * pi * static_cast<float>(i) / 13.0F;
        const float elevation = 0.9F + 0.05F * static_cast<float>(i);
        sky.towards.emplace_back(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                                 std::sin(elevation));
        expected += 10.0F * std::sin(elevation);
    }
    EXPECT_NEAR(first(builder, sky, receiverAt(Vec3(0.0F), up)), expected, 0.001F * expected);
}

TEST(DirectLight, PolygonsGiveTheirFormFactor) {
    const SceneBuilder floor = floorScene();
    const AreaLight light = lamp({-32.0F, 32.0F, 100.0F}, {64.0F, 0.0F, 0.0F}, {0.0F, -64.0F, 0.0F}, 500.0F);
    ASSERT_LT(light.normal.z, 0.0F);
    // Four rectangles of 32 × 32 meet above the point.
    const float x = 0.32F;
    const float s = std::sqrt(1.0F + x * x);
    const float share = 4.0F * (2.0F * x / s * std::atan(x / s)) / (2.0F * pi);
    EXPECT_NEAR(first(floor, light, receiverAt(Vec3(0.0F), up)), 500.0F * share, 0.005F * 500.0F * share);
    EXPECT_EQ(first(floor, light, receiverAt({0.0F, 0.0F, 200.0F}, -up)), 0.0F) << "one-sided";
    AreaLight both = light;
    both.twoSided = true;
    EXPECT_NEAR(first(floor, both, receiverAt({0.0F, 0.0F, 200.0F}, -up)), 500.0F * share, 0.005F * 500.0F * share);
}

TEST(DirectLight, TwoSidedReceiversSeeBothSides) {
    SceneBuilder builder;
    builder.quad({-1000.0F, -1000.0F, -500.0F}, {2000.0F, 0.0F, 0.0F}, {0.0F, 2000.0F, 0.0F});
    scene::Material cloth;
    cloth.twoSided = true;
    builder.quad({-9.0F, -9.0F, 0.0F}, {18.0F, 0.0F, 0.0F}, {0.0F, 18.0F, 0.0F}, 1);
    builder.grey(0.5F);
    builder.material(cloth);
    const std::vector<Light> sources{point({0.0F, 0.0F, 100.0F}, 3.0F), point({0.0F, 0.0F, -100.0F}, 5.0F)};
    const Lit lit(builder, sources,
                  {receiverAt(Vec3(0.0F), up), receiverAt(Vec3(0.0F), -up), receiverAt(Vec3(0.0F), up, true)});
    const auto e = lit.irradiance();
    EXPECT_NEAR(e[0].x, 2.25F, 0.01F);
    EXPECT_NEAR(e[1].x, 3.75F, 0.02F);
    EXPECT_NEAR(e[2].x, 6.0F, 0.03F);
    const AreaLight above = lamp({-50.0F, 50.0F, 60.0F}, {100.0F, 0.0F, 0.0F}, {0.0F, -100.0F, 0.0F}, 10.0F);
    const AreaLight below = lamp({-50.0F, -50.0F, -60.0F}, {100.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F}, 10.0F);
    const Lit lamps(builder, {above, below}, {receiverAt(Vec3(0.0F), up), receiverAt(Vec3(0.0F), up, true)});
    const auto l = lamps.irradiance();
    EXPECT_GT(l[0].x, 1.0F);
    EXPECT_NEAR(l[1].x, 2.0F * l[0].x, 1e-3F);
}

TEST(DirectLight, NegativeLightSubtractsAndTheSumIsNotNegative) {
    const SceneBuilder floor = floorScene();
    const Light bright = point({0.0F, 0.0F, 100.0F}, 3.0F);
    const Light dark = point({0.0F, 0.0F, 100.0F}, -1.0F);
    const scene::Receiver at = receiverAt(Vec3(0.0F), up);
    EXPECT_NEAR(Lit(floor, {bright, dark}, {at}).first(), 1.5F, 0.01F);
    EXPECT_EQ(Lit(floor, {dark}, {at}).first(), 0.0F);
}

// ---- shadows ----

TEST(DirectLight, OpaqueBlocksAndFiltersTint) {
    for (const auto kind : {scene::Interaction::Opaque, scene::Interaction::Sky}) {
        SceneBuilder builder = floorScene();
        scene::Material material;
        material.interaction = kind;
        builder.quad({-50.0F, -50.0F, 50.0F}, {100.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F}, builder.material(material));
        const float expected = kind == scene::Interaction::Opaque ? 0.0F : 2.25F;
        EXPECT_NEAR(first(builder, point({0.0F, 0.0F, 100.0F}, 3.0F), receiverAt(Vec3(0.0F), up)), expected, 0.01F);
    }
}

TEST(DirectLight, ASunBehindARoofOrABackdropIsDark) {
    SceneBuilder builder = floorScene();
    addSky(builder, 900.0F);
    builder.quad({-50.0F, -50.0F, 300.0F}, {100.0F, 0.0F, 0.0F},
                 {0.0F, 100.0F, 0.0F}); // faces up: stops light all the same
    SunLight sun;
    sun.irradiance = Rgb(100.0F);
    EXPECT_EQ(first(builder, sun, receiverAt(Vec3(0.0F), up)), 0.0F);
    EXPECT_NEAR(first(builder, sun, receiverAt({60.0F, 0.0F, 0.0F}, up)), 100.0F, 0.01F);
    EXPECT_NEAR(first(builder, sun, receiverAt({0.0F, 0.0F, 300.0F}, up)), 100.0F, 0.01F);
    // What lies beyond the sky does not matter.
    builder.quad({-1000.0F, -1000.0F, 950.0F}, {2000.0F, 0.0F, 0.0F}, {0.0F, 2000.0F, 0.0F});
    EXPECT_NEAR(first(builder, sun, receiverAt({60.0F, 0.0F, 0.0F}, up)), 100.0F, 0.01F);
}

TEST(DirectLight, PenumbraOfALamp) {
    // Half of the lamp is hidden behind a wall whose edge lies on the line to its middle.
    SceneBuilder builder = floorScene();
    builder.quad({-200.0F, -200.0F, 50.0F}, {200.0F, 0.0F, 0.0F}, {0.0F, 400.0F, 0.0F});
    const AreaLight light = lamp({-32.0F, 32.0F, 100.0F}, {64.0F, 0.0F, 0.0F}, {0.0F, -64.0F, 0.0F}, 500.0F);
    const scene::Receiver at = receiverAt(Vec3(0.0F), up);
    Lit lit(builder, {light}, {at});
    const float open = first(floorScene(), light, at);
    lit.options.softness = 16;
    lit.options.softSamples = 256;
    EXPECT_NEAR(lit.first() / open, 0.5F, 0.02F);
    lit.options = {};
    EXPECT_NEAR(lit.first() / open, 0.5F, 0.05F) << "64 samples: the error of low discrepancy is about 1/64";
}

TEST(DirectLight, VerticesOfLampsAndBesideThem) {
    // A lamp set flush into the wall x = 0, which is part of the scene; vertices as levels have them, on its border.
    SceneBuilder builder = floorScene();
    builder.quad({0.0F, -32.0F, 0.0F}, {0.0F, 64.0F, 0.0F}, {0.0F, 0.0F, 64.0F});
    const AreaLight light = lamp({0.0F, -32.0F, 0.0F}, {0.0F, 64.0F, 0.0F}, {0.0F, 0.0F, 64.0F}, 100.0F);
    ASSERT_GT(light.normal.x, 0.0F);
    scene::Receiver own = receiverAt({0.0F, -32.0F, 0.0F}, {1.0F, 0.0F, 0.0F});
    own.inset = {0.0F, -31.3F, 0.7F};
    scene::Receiver beside = receiverAt(Vec3(0.0F), up);
    beside.inset = {1.0F, 0.0F, 0.0F};
    const auto e = Lit(builder, {light}, {own, beside}).irradiance();
    EXPECT_EQ(e[0].x, 0.0F) << "a lamp does not light itself";
    EXPECT_NEAR(e[1].x, 50.0F, 2.0F) << "the floor at its foot sees half a sphere of it";
}

// ---- many lights ----

/// 600 lamps and 200 points in 25 rooms: of each receiver's lights nearly all are behind walls.
Lit manyRooms(std::uint32_t seed, std::size_t receivers) {
    SceneBuilder builder;
    builder.grey(0.5F);
    std::mt19937 random(seed);
    std::vector<Light> sources;
    std::vector<scene::Receiver> points;
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 5; ++x) {
            const Vec3 corner(300.0F * static_cast<float>(x), 300.0F * static_cast<float>(y), 0.0F);
            builder.room(corner, corner + Vec3(290.0F, 290.0F, 200.0F));
            // A pillar each, so that rooms have shadows of their own.
            for (int i = 0; i < 24; ++i)
                sources.emplace_back(lamp(
                    corner + Vec3(10.0F + 250.0F * test::unit(random), 30.0F + 250.0F * test::unit(random), 199.0F),
                    {16.0F, 0.0F, 0.0F}, {0.0F, -16.0F, 0.0F}, 300.0F * test::unit(random)));
            for (int i = 0; i < 8; ++i)
                sources.emplace_back(point(corner + Vec3(10.0F) + Vec3(270.0F, 270.0F, 180.0F) * test::unit3(random),
                                           20.0F * test::unit(random)));
            builder.room(corner + Vec3(160.0F, 160.0F, 0.0F), corner + Vec3(130.0F, 130.0F, 150.0F));
        }
    for (std::size_t i = 0; i < receivers; ++i) {
        const Vec3 corner(300.0F * static_cast<float>(random() % 5), 300.0F * static_cast<float>(random() % 5), 0.0F);
        points.push_back(receiverAt(corner + Vec3(290.0F * test::unit(random), 290.0F * test::unit(random), 0.0F), up));
    }
    return {builder, std::move(sources), std::move(points), intersect::Kind::Bsp};
}

TEST(DirectLight, ManyLightsCostFewRaysAndLittleError) {
    Lit lit = manyRooms(3, 130);
    std::uint64_t rays = 0;
    const auto fast = lit.irradiance(&rays);
    lit.options.exhaustive = true;
    lit.options.softness = 2;
    std::uint64_t allRays = 0;
    const auto reference = lit.irradiance(&allRays);
    double sum = 0;
    double sumSquared = 0;
    int lit1 = 0;
    for (std::size_t i = 0; i < fast.size(); ++i) {
        if (reference[i].x < 1.0F) continue; // below a visible step of a lightmap
        const double error = static_cast<double>(fast[i].x / reference[i].x) - 1;
        sum += error;
        sumSquared += error * error;
        ++lit1;
    }
    const double rms = std::sqrt(sumSquared / lit1);
    RecordProperty("rms_error_per_mille", static_cast<int>(1000 * rms));
    RecordProperty("rays_per_receiver", static_cast<int>(rays / fast.size()));
    EXPECT_GT(lit1, 100);
    EXPECT_LT(rms, 0.03) << rays / fast.size() << " rays per receiver";
    EXPECT_NEAR(sum / lit1, 0.0, 4 * rms / std::sqrt(lit1)) << "no bias beyond 4 sigma";
    EXPECT_LT(rays * 10, allRays);
}

TEST(DirectLight, TheTailIsUnbiased) {
    // Every light may be left to the tail, of which one sample is drawn: the mean over many seeds is still right.
    Lit lit = manyRooms(4, 1);
    lit.receivers.points[0] = receiverAt({100.0F, 100.0F, 0.0F}, up);
    lit.options.exhaustive = true;
    lit.options.softness = 1;
    const auto expected = static_cast<double>(lit.first());
    lit.options.exhaustive = false;
    lit.options.absoluteTolerance = 1e6F;
    lit.options.tailSamples = 1;
    double sum = 0;
    double sumSquared = 0;
    constexpr int seeds = 8'000;
    for (int seed = 0; seed < seeds; ++seed) {
        lit.options.seed = static_cast<std::uint64_t>(seed);
        const auto e = static_cast<double>(lit.first());
        sum += e;
        sumSquared += e * e;
    }
    const double mean = sum / seeds;
    const double error = std::sqrt((sumSquared / seeds - mean * mean) / seeds);
    EXPECT_LT(error, 0.05 * expected);
    EXPECT_NEAR(mean, expected, 4 * error) << "false alarm once in 16,000 seeds; the seeds are fixed";
    EXPECT_GT(sumSquared / seeds - mean * mean, 0.01 * expected * expected) << "one sample is noisy";
}

// ---- variances ----

/// What `lit` really varies by over seeds, against what it says it does: sums over receivers, channel means.
struct Spread {
    double real = 0, said = 0, mean = 0;
};

Spread spreadOverSeeds(Lit& lit, int seeds) {
    const std::size_t count = lit.receivers.points.size();
    const std::vector<std::uint32_t> which = all(lit.receivers);
    std::vector<double> sum(count), sumSquared(count);
    Spread result;
    for (int seed = 0; seed < seeds; ++seed) {
        lit.options.seed = static_cast<std::uint64_t>(seed);
        const DirectLight direct(*lit.scene, lit.lights, *lit.intersector, lit.receivers, lit.options);
        std::vector<Rgb> e(count);
        std::vector<float> variance(count, -1.0F);
        direct.estimate(which, e, variance);
        for (std::size_t i = 0; i < count; ++i) {
            EXPECT_GE(variance[i], 0.0F);
            sum[i] += double{meanChannel(e[i])};
            sumSquared[i] += double{meanChannel(e[i])} * double{meanChannel(e[i])};
            result.said += double{variance[i]} / seeds;
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        result.mean += sum[i] / seeds;
        result.real += (sumSquared[i] - sum[i] * sum[i] / seeds) / (seeds - 1);
    }
    return result;
}

TEST(DirectLight, VarianceOfTheTailIsHonest) {
    // Point lights: nothing is soft, all noise is the tail's.
    Lit lit = manyRooms(7, 40);
    std::vector<Light> points;
    for (const Light& light : lit.lights.lights())
        if (std::holds_alternative<PointLight>(light)) points.push_back(light);
    lit.lights = lights::LightSet(points, lit.scene);
    lit.options.absoluteTolerance = 1e6F;
    lit.options.tailSamples = 64;
    const Spread spread = spreadOverSeeds(lit, 200);
    EXPECT_GT(spread.real, 1e-4 * spread.mean) << "a test without noise tests nothing";
    // On the safe side: here 64 draws take a third of all lights, and successive differences do not know that lights
    // whose bound is larger than a step are never missed.
    EXPECT_GT(spread.said, 0.9 * spread.real);
    EXPECT_LT(spread.said, 5.0 * spread.real);
}

TEST(DirectLight, VarianceOfPenumbrasIsHonest) {
    // Receivers in the penumbra of a lamp behind the edge of a wall.
    SceneBuilder builder = floorScene();
    builder.quad({-200.0F, -200.0F, 50.0F}, {200.0F, 0.0F, 0.0F}, {0.0F, 400.0F, 0.0F});
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 25; ++i) points.push_back(receiverAt({-24.0F + 2.0F * static_cast<float>(i), 0.0F, 0.0F}, up));
    Lit lit(builder, {lamp({-32.0F, 32.0F, 100.0F}, {64.0F, 0.0F, 0.0F}, {0.0F, -64.0F, 0.0F}, 500.0F)}, points);
    for (const unsigned samples : {8U, 64U}) {
        lit.options.softSamples = samples;
        const Spread spread = spreadOverSeeds(lit, 400);
        EXPECT_GT(spread.said, spread.real) << samples;
        // Groups of eight points hide some of what a sequence gains over points at random.
        EXPECT_LT(spread.said, 6 * spread.real) << samples;
    }
}

TEST(DirectLight, WithoutNoiseTheVarianceIsZero) {
    const SceneBuilder floor = floorScene();
    const AreaLight light = lamp({-32.0F, 32.0F, 100.0F}, {64.0F, 0.0F, 0.0F}, {0.0F, -64.0F, 0.0F}, 500.0F);
    const Lit lit(floor, {light, point({0.0F, 0.0F, 400.0F})}, {receiverAt(Vec3(0.0F), up)});
    const DirectLight direct(*lit.scene, lit.lights, *lit.intersector, lit.receivers, lit.options);
    const std::uint32_t which = 0;
    Rgb e(0.0F);
    float variance = -1;
    direct.estimate({&which, 1}, {&e, 1}, {&variance, 1});
    EXPECT_EQ(variance, 0.0F);
    variance = -1;
    direct.estimate({&which, 1}, {&e, 1}, {&variance, 1});
    EXPECT_EQ(variance, 0.0F) << "remembered";
}

TEST(DirectLight, VariancesAreTheSameWhenRemembered) {
    const Lit lit = manyRooms(8, 70);
    const DirectLight direct(*lit.scene, lit.lights, *lit.intersector, lit.receivers, lit.options);
    const std::vector<std::uint32_t> which = all(lit.receivers);
    std::vector<Rgb> e(which.size());
    std::vector<float> fresh(which.size());
    std::vector<float> remembered(which.size());
    direct.estimate(which, e, fresh);
    direct.estimate(which, e, remembered);
    EXPECT_EQ(fresh, remembered);
    EXPECT_GT(*std::max_element(fresh.begin(), fresh.end()), 0.0F);
}

TEST(DirectLight, SameBitsOnAnyNumberOfThreadsAndInAnyBatch) {
    Lit lit = manyRooms(5, 300);
    setThreads(1);
    const auto one = lit.irradiance();
    setThreads(2);
    EXPECT_EQ(lit.irradiance(), one);
    setThreads(0);
    const DirectLight direct(*lit.scene, lit.lights, *lit.intersector, lit.receivers, lit.options);
    for (std::uint32_t i = 300; i-- > 0;) {
        Rgb e(0.0F);
        direct.estimate({&i, 1}, {&e, 1});
        ASSERT_EQ(e, one[i]);
    }
    // The same place under another number.
    std::reverse(lit.receivers.points.begin(), lit.receivers.points.end());
    auto turned = lit.irradiance();
    std::reverse(turned.begin(), turned.end());
    EXPECT_EQ(turned, one);
}

TEST(DirectLight, ComputesEachReceiverOnce) {
    const Lit lit = manyRooms(6, 100);
    const DirectLight direct(*lit.scene, lit.lights, *lit.intersector, lit.receivers, lit.options);
    const std::vector<std::uint32_t> which = all(lit.receivers);
    std::vector<Rgb> e(which.size());
    direct.estimate(std::span(which).first(60), std::span(e).first(60));
    EXPECT_EQ(direct.receiversComputed(), 60U);
    direct.estimate(which, e);
    EXPECT_EQ(direct.receiversComputed(), 100U);
    const std::uint64_t rays = direct.raysTraced();
    std::vector<Rgb> again(which.size());
    direct.estimate(which, again);
    EXPECT_EQ(direct.raysTraced(), rays);
    EXPECT_EQ(again, e);
    EXPECT_EQ(direct.name(), "direct");
}

// ---- numbers that must not break it ----

TEST(DirectLight, WithoutLightsItIsDarkAndCostsNothing) {
    std::uint64_t rays = 1;
    const Lit lit(floorScene(), {}, {receiverAt(Vec3(0.0F), up)});
    EXPECT_EQ(lit.irradiance(&rays)[0], Rgb(0.0F));
    EXPECT_EQ(rays, 0U);
    const Lit nobody(floorScene(), {point({0.0F, 0.0F, 9.0F})}, {});
    EXPECT_TRUE(nobody.irradiance().empty());
}

TEST(DirectLight, StaysFiniteWhateverHappens) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    const std::vector<scene::Receiver> points{receiverAt(Vec3(0.0F), up),         receiverAt(Vec3(0.0F), up, true),
                                              receiverAt(Vec3(0.0F), Vec3(0.0F)), receiverAt({nan, 0.0F, 0.0F}, up),
                                              receiverAt(Vec3(0.0F), Vec3(nan)),  receiverAt({1e38F, 0.0F, 0.0F}, up),
                                              receiverAt({5.0F, 5.0F, 0.0F}, up)};
    for (const float power : {0.0F, 1e-38F, 1e-30F, 1e30F, 3e38F, -1e30F, infinity, nan})
        for (const Vec3& place :
             {Vec3(0.0F), Vec3(0.0F, 0.0F, 1e-30F), Vec3(0.0F, 0.0F, 50.0F), Vec3(1e30F), Vec3(nan)}) {
            PointLight bare;
            bare.position = place;
            bare.power = Rgb(power);
            bare.falloff.minDistance = 0;
            SphereLight sphere{place, Rgb(power), 0.0F, {}};
            SpotLight spot;
            spot.position = place;
            spot.direction = -up;
            spot.power = Rgb(power);
            SunLight sun;
            sun.irradiance = Rgb(power);
            AreaLight flat = lamp(place, {10.0F, 0.0F, 0.0F}, {0.0F, 10.0F, 0.0F}, power);
            AreaLight none = lamp(place, Vec3(0.0F), {0.0F, 10.0F, 0.0F}, power);
            none.corners.clear();
            const SkyLight sky{{up, Vec3(0.0F), Vec3(nan)}, Rgb(power)};
            SceneBuilder builder = floorScene();
            addSky(builder, 900.0F);
            const Lit lit(builder, {bare, sphere, spot, sun, flat, none, sky, SkyLight{}}, points);
            for (const Rgb& e : lit.irradiance())
                EXPECT_TRUE(std::isfinite(e.x) && e.x >= 0.0F) << e.x << " at power " << power;
        }
}

TEST(DirectLight, OffsetsFollowTheScaleOfTheScene) {
    for (const float size : {1e-3F, 1.0F, 4096.0F, 1e7F}) {
        SceneBuilder builder;
        builder.grey(0.5F);
        builder.room(Vec3(0.0F), Vec3(size));
        PointLight light;
        light.position = Vec3(0.5F * size);
        light.power = Rgb(4.0F * pi * 0.25F * size * size);
        light.falloff.minDistance = 0;
        Lit lit(builder, {light},
                {receiverAt({0.5F * size, 0.5F * size, 0.0F}, up), receiverAt({0.0F, 0.5F * size, 0.0F}, up)});
        lit.receivers.points[1].inset.x = 1e-3F * size; // as makeReceivers does at the border of a surface
        const auto e = lit.irradiance();
        EXPECT_NEAR(e[0].x, 1.0F, 0.005F) << size;
        EXPECT_NEAR(e[1].x, 1.0F / (2.0F * std::sqrt(2.0F)), 0.005F) << size;
        const DirectLight direct(*lit.scene, lit.lights, *lit.intersector, lit.receivers);
        EXPECT_LE(direct.rayOffset(), 0.001F * size);
        EXPECT_GE(direct.rayOffset(), 1e-6F * size);
    }
}

} // namespace
} // namespace pie::gather
