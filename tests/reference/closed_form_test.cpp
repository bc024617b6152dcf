// Where irradiance is known exactly: the oracle must find it within half a per cent, and within its own error.

#include "tests/reference/traced.h"

#include <gtest/gtest.h>

#include <numbers>

namespace pie::reference::test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr float watts = 1000;
const Vec3 up(0.0F, 0.0F, 1.0F);

/// A sphere seen from inside: an octahedron whose faces were divided `levels` times.
void addSphere(SceneBuilder& builder, float radius, int levels, std::uint32_t material) {
    struct Face {
        Vec3 a{0.0F}, b{0.0F}, c{0.0F};
    };
    std::vector<Face> faces;
    for (const float x : {-1.0F, 1.0F})
        for (const float y : {-1.0F, 1.0F})
            for (const float z : {-1.0F, 1.0F}) {
                Face face{{x, 0.0F, 0.0F}, {0.0F, y, 0.0F}, {0.0F, 0.0F, z}};
                if (x * y * z > 0.0F) std::swap(face.b, face.c); // counter-clockwise from inside
                faces.push_back(face);
            }
    for (int level = 0; level < levels; ++level) {
        std::vector<Face> finer;
        for (const Face& f : faces) {
            const Vec3 ab = glm::normalize(f.a + f.b);
            const Vec3 bc = glm::normalize(f.b + f.c);
            const Vec3 ca = glm::normalize(f.c + f.a);
            finer.insert(finer.end(), {{f.a, ab, ca}, {ab, f.b, bc}, {ca, bc, f.c}, {ab, bc, ca}});
        }
        faces.swap(finer);
    }
    for (const Face& f : faces) builder.triangle(radius * f.a, radius * f.b, radius * f.c, material);
}

class SphereFurnace : public ::testing::TestWithParam<float> {};

TEST_P(SphereFurnace, FindsTheExactMean) {
    const float rho = GetParam();
    SceneBuilder builder;
    addSphere(builder, 100.0F, 5, builder.grey(rho));
    const Traced traced(builder, {lamp(Vec3(0.0F), Rgb(watts))});
    std::mt19937 random(1);
    const gather::test::SurfaceSampler surface(*traced.scene);
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 60; ++i) {
        const auto [place, triangle] = surface(random);
        points.push_back(receiverAt(place, traced.scene->normals[triangle]));
    }
    // Flux in is flux absorbed, whatever the tessellation: Φ = (1 − ρ) A E.
    const double exact = double{watts} / (surface.area() * (1.0 - double{rho}));
    const Mean mean = meanOf(traced.at(points));
    EXPECT_NEAR(mean.value / exact, 1.0, 0.005);
    EXPECT_NEAR(mean.value, exact, mostErrors * mean.error + 3e-4 * exact);
    const double smooth = double{watts} / (4 * pi * 1e4 * (1.0 - double{rho}));
    EXPECT_NEAR(mean.value / smooth, 1.0, 0.005);
}
INSTANTIATE_TEST_SUITE_P(Reflectance, SphereFurnace, ::testing::Values(0.2F, 0.5F, 0.8F));

class CubeFurnace : public ::testing::TestWithParam<float> {};

TEST_P(CubeFurnace, FindsTheExactMean) {
    const float rho = GetParam();
    SceneBuilder builder;
    builder.room(Vec3(0.0F), Vec3(64.0F), builder.grey(rho));
    const Traced traced(builder, {lamp(Vec3(32.0F), Rgb(watts))});
    Options options;
    options.target = 0.02;
    const std::vector<Value> values =
        traced.at(grid(Vec3(0.0F), {64.0F, 0.0F, 0.0F}, {0.0F, 64.0F, 0.0F}, up, 16), options);
    const double exact = double{watts} / (6.0 * 64 * 64 * (1.0 - double{rho}));
    const Mean mean = gridMeanOf(values);
    EXPECT_LT(mean.error, 0.001 * exact);
    EXPECT_NEAR(mean.value / exact, 1.0, 0.005);
    // The midpoint rule on this grid is 0.1 % off for direct light.
    EXPECT_NEAR(mean.value, exact, mostErrors * mean.error + 2e-3 * exact);
}
INSTANTIATE_TEST_SUITE_P(Reflectance, CubeFurnace, ::testing::Values(0.2F, 0.5F, 0.8F));

TEST(ClosedForm, PlaneUnderAPointLight) {
    SceneBuilder builder;
    builder.quad({-500.0F, -500.0F, 0.0F}, {1000.0F, 0.0F, 0.0F}, {0.0F, 1000.0F, 0.0F}, builder.grey(0.5F));
    const double h = 60;
    const Traced traced(builder, {lamp({0.0F, 0.0F, 60.0F}, Rgb(watts))});
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 10; ++i) points.push_back(receiverAt({30.0F * static_cast<float>(i), 0.0F, 0.0F}, up));
    const auto values = traced.at(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double cosine = h / std::hypot(h, double{points[i].position.x});
        const double exact = double{watts} * cosine * cosine * cosine / (4 * pi * h * h);
        // Nothing is reflected to the plane: no noise. The receiver is lifted by a thousandth of the height.
        EXPECT_NEAR(values[i].irradiance.y / exact, 1.0, 0.004) << i;
        EXPECT_LT(values[i].standardError.y, 1e-9 * exact);
    }
}

TEST(ClosedForm, ParallelSquares) {
    // Two opposite faces of a cube see each other with F = 0.19982 (Howell, configuration C-11).
    SceneBuilder builder;
    const std::uint32_t black = builder.grey(0.0F);
    builder.quad({0.0F, 0.0F, 0.0F}, {100.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F}, black);
    const float z = 100;
    const std::vector<Vec3> corners{{0.0F, 0.0F, z}, {0.0F, 100.0F, z}, {100.0F, 100.0F, z}, {100.0F, 0.0F, z}};
    const lights::AreaLight light = lights::makeAreaLight(corners, Rgb(50.0F));
    ASSERT_LT(light.normal.z, -0.99F);
    const Traced traced(builder, {light});
    const double x2 = 1;
    const double root = std::sqrt(1 + x2);
    const double exact =
        2 / (pi * x2) *
        (std::log((1 + x2) / std::sqrt(1 + 2 * x2)) + 2 * root * std::atan(1 / root) - 2 * std::atan(1.0));
    ASSERT_NEAR(exact, 0.19982, 1e-5);
    Options options;
    options.target = 0.01;
    const Mean mean =
        gridMeanOf(traced.at(grid(Vec3(0.0F), {100.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F}, up, 12), options));
    EXPECT_NEAR(mean.value / (50 * exact), 1.0, 0.005);
    EXPECT_NEAR(mean.value, 50 * exact, mostErrors * mean.error + 0.002 * 50 * exact) << "lifted by 0.03 of 100";
}

TEST(ClosedForm, WhiteCubeNeverEnds) {
    // A cube that absorbs nothing but at its floor, which absorbs all: what arrives there is all there is.
    SceneBuilder builder;
    const std::uint32_t white = builder.grey(1.0F);
    const std::uint32_t black = builder.grey(0.0F);
    builder.room(Vec3(0.0F), Vec3(64.0F), white);
    builder.quad({0.0F, 0.0F, 0.5F}, {64.0F, 0.0F, 0.0F}, {0.0F, 64.0F, 0.0F}, black);
    const Traced traced(builder, {lamp({20.0F, 30.0F, 50.0F}, Rgb(watts))});
    Options options;
    options.target = 0.02;
    const Mean mean =
        gridMeanOf(traced.at(grid({0.0F, 0.0F, 0.5F}, {64.0F, 0.0F, 0.0F}, {0.0F, 64.0F, 0.0F}, up, 8), options));
    EXPECT_NEAR(mean.value, double{watts} / (64 * 64), mostErrors * mean.error + 0.003 * double{watts} / (64 * 64));
}

} // namespace
} // namespace pie::reference::test
