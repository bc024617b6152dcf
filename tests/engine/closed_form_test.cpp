// The default estimator as users run it, through Transport, where irradiance is known exactly: within half a per cent,
// for every intersector and every distribution of photons.

#include "pie/engine/transport.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <tuple>
#include <vector>

namespace pie::engine {
namespace {

using gather::test::receiverAt;
using gather::test::SceneBuilder;
using sampling::Distribution;

constexpr double pi = std::numbers::pi;
constexpr float watts = 1e7F;
const Vec3 up(0.0F, 0.0F, 1.0F);
constexpr intersect::Kind intersectors[] = {intersect::Kind::BruteForce, intersect::Kind::Bsp, intersect::Kind::Embree};
constexpr Distribution distributions[] = {Distribution::Halton,   Distribution::Sobol,     Distribution::R2,
                                          Distribution::Explicit, Distribution::Rejection, Distribution::Stratified,
                                          Distribution::Spiral};

Settings preciseSettings() {
    Settings settings;
    settings.photonsFromLight = 20'000;
    settings.stillFrames = 4;
    settings.recursionDepth = 60; // ρ⁶⁰ of 0.8 is a millionth
    settings.directTolerance = 0.01F;
    return settings;
}

lights::PointLight lamp(const Vec3& position) {
    lights::PointLight light;
    light.position = position;
    light.power = Rgb(watts);
    light.falloff.minDistance = 0;
    return light;
}

/// Light at all receivers, refined to the end.
std::vector<Rgb> settled(const SceneBuilder& builder, const lights::Light& light, const scene::Receivers& receivers,
                         const Settings& settings) {
    const level::Tree none;
    Transport transport(makeSurroundings(builder.make(), none, settings), {light}, none, receivers, settings);
    while (transport.statistics().framesTraced < static_cast<std::uint64_t>(settings.stillFrames)) transport.advance();
    std::vector<std::uint32_t> which(receivers.points.size());
    std::iota(which.begin(), which.end(), 0U);
    transport.finish(which);
    std::vector<Rgb> irradiance(which.size());
    transport.irradiance(which, irradiance);
    EXPECT_EQ(transport.statistics().mapBytes, 0U) << "the gather has no map";
    return irradiance;
}

double meanOf(const std::vector<Rgb>& irradiance) {
    double sum = 0;
    for (const Rgb& e : irradiance) sum += static_cast<double>(meanChannel(e));
    return sum / static_cast<double>(irradiance.size());
}

/// A sphere seen from inside: an octahedron whose faces were divided `levels` times.
SceneBuilder sphere(float radius, int levels, float rho) {
    std::vector<std::array<Vec3, 3>> faces;
    for (const float x : {-1.0F, 1.0F})
        for (const float y : {-1.0F, 1.0F})
            for (const float z : {-1.0F, 1.0F}) {
                const Vec3 a(x, 0.0F, 0.0F);
                const Vec3 b(0.0F, y, 0.0F);
                const Vec3 c(0.0F, 0.0F, z);
                // Counter-clockwise from inside.
                faces.push_back(x * y * z > 0.0F ? std::array{a, c, b} : std::array{a, b, c});
            }
    for (int level = 0; level < levels; ++level) {
        std::vector<std::array<Vec3, 3>> finer;
        for (const auto& [a, b, c] : faces) {
            const Vec3 ab = glm::normalize(a + b);
            const Vec3 bc = glm::normalize(b + c);
            const Vec3 ca = glm::normalize(c + a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        faces.swap(finer);
    }
    SceneBuilder builder;
    builder.grey(rho);
    for (const auto& [a, b, c] : faces) builder.triangle(radius * a, radius * b, radius * c);
    return builder;
}

struct Furnace {
    SceneBuilder builder;
    scene::Receivers receivers; ///< thrown evenly on the surface
    double area = 0;            ///< of the triangles: flux in is flux absorbed, whatever the tessellation

    Furnace(int levels, float rho, int count) : builder(sphere(radius, levels, rho)) {
        const auto scene = builder.make();
        const gather::test::SurfaceSampler sampler(*scene);
        area = sampler.area();
        std::mt19937 random(1);
        for (int i = 0; i < count; ++i) {
            const auto [position, triangle] = sampler(random);
            receivers.points.push_back(receiverAt(position, scene->normals[triangle]));
        }
    }
    static constexpr float radius = 256;
};

class SphereFurnace : public ::testing::TestWithParam<float> {};

TEST_P(SphereFurnace, GatherFindsTheExactMean) {
    const float rho = GetParam();
    const Furnace furnace(4, rho, 300);
    const double mean = meanOf(settled(furnace.builder, lamp(Vec3(0.0F)), furnace.receivers, preciseSettings()));
    EXPECT_NEAR(mean / (double{watts} / (furnace.area * (1.0 - double{rho}))), 1.0, 0.005);
    // Of the sphere itself, whose area is 0.6 % larger.
    const double smooth = double{watts} / (4 * pi * std::pow(double{Furnace::radius}, 2) * (1.0 - double{rho}));
    EXPECT_NEAR(mean / smooth, 1.0, 0.012);
}
INSTANTIATE_TEST_SUITE_P(Reflectance, SphereFurnace, ::testing::Values(0.2F, 0.5F, 0.8F));

using Way = std::tuple<intersect::Kind, Distribution>;
class EveryWay : public ::testing::TestWithParam<Way> {
protected:
    static Settings settings() {
        Settings settings = preciseSettings();
        settings.intersector = std::get<0>(GetParam());
        settings.lightDistribution = settings.diffuseDistribution = std::get<1>(GetParam());
        if (settings.intersector == intersect::Kind::BruteForce) {
            settings.photonsFromLight = 5'000;
            settings.gatherRays = 64;
        }
        return settings;
    }
};

TEST_P(EveryWay, SphereFurnace) {
    const Furnace furnace(3, 0.5F, 200);
    const double exact = double{watts} / (furnace.area * 0.5);
    const double mean = meanOf(settled(furnace.builder, lamp(Vec3(0.0F)), furnace.receivers, settings()));
    RecordProperty("ratio", std::to_string(mean / exact));
    EXPECT_NEAR(mean / exact, 1.0, 0.005);
}

TEST_P(EveryWay, PlaneUnderAPointLight) {
    SceneBuilder builder;
    builder.quad({-500.0F, -500.0F, 0.0F}, {1000.0F, 0.0F, 0.0F}, {0.0F, 1000.0F, 0.0F}, builder.grey(0.5F));
    const double h = 60;
    scene::Receivers receivers;
    for (int i = 0; i < 10; ++i)
        receivers.points.push_back(receiverAt({30.0F * static_cast<float>(i), 0.0F, 0.0F}, up));
    const auto irradiance = settled(builder, lamp({0.0F, 0.0F, 60.0F}), receivers, settings());
    for (std::size_t i = 0; i < irradiance.size(); ++i) {
        const double cosine = h / std::hypot(h, double{receivers.points[i].position.x});
        const double exact = double{watts} * std::pow(cosine, 3) / (4 * pi * h * h);
        // Nothing is reflected to the plane, and a point in full view has no noise.
        EXPECT_NEAR(static_cast<double>(irradiance[i].y) / exact, 1.0, 1e-5) << i;
    }
}

TEST_P(EveryWay, ParallelSquares) {
    // Opposite faces of a cube see each other with F = 0.19982 (Howell, configuration C-11). The lower one does not
    // reflect or there would be light between them.
    SceneBuilder builder;
    builder.quad(Vec3(0.0F), {100.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F}, builder.grey(0.0F));
    const std::vector<Vec3> corners{
        {0.0F, 0.0F, 100.0F}, {0.0F, 100.0F, 100.0F}, {100.0F, 100.0F, 100.0F}, {100.0F, 0.0F, 100.0F}};
    scene::Receivers receivers;
    constexpr int cells = 16;
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x)
            receivers.points.push_back(receiverAt(
                {(static_cast<float>(x) + 0.5F) * 100 / cells, (static_cast<float>(y) + 0.5F) * 100 / cells, 0.0F},
                up));
    const double exact =
        2 / pi *
        (std::log(2 / std::sqrt(3.0)) + 2 * std::sqrt(2.0) * std::atan(1 / std::sqrt(2.0)) - 2 * std::atan(1.0));
    ASSERT_NEAR(exact, 0.19982, 1e-5);
    const float emitted = 5000;
    const double mean = meanOf(settled(builder, lights::makeAreaLight(corners, Rgb(emitted)), receivers, settings()));
    // The midpoint rule on this grid is 0.04 % off.
    EXPECT_NEAR(mean / (double{emitted} * exact), 1.0, 0.001);
}

INSTANTIATE_TEST_SUITE_P(All, EveryWay,
                         ::testing::Combine(::testing::ValuesIn(intersectors), ::testing::ValuesIn(distributions)));

} // namespace
} // namespace pie::engine
