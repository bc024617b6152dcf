#include "pie/sampling/directions.h"
#include "tests/sampling/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace pie::sampling {
namespace {

constexpr double pi = std::numbers::pi;
constexpr float belowOne = 0x1.fffffep-1F;

struct Map {
    std::string name;
    std::function<Vec3(Vec2)> sample;
    std::function<double(Vec3)> pdf;
    std::function<Vec2(Vec3)> invert;
    double lowest; ///< cosine down to which it reaches
};

std::vector<Map> maps() {
    std::vector<Map> all{
        {"sphere", uniformSphere, [](const Vec3&) { return uniformSpherePdf(); }, invertUniformSphere, -1.0},
        {"hemisphere", cosineHemisphere, cosineHemispherePdf, invertCosineHemisphere, 0.0},
        {"polar hemisphere", polarCosineHemisphere, cosineHemispherePdf, invertPolarCosineHemisphere, 0.0}};
    for (const float cosMax : {0.9F, 0.0F, -0.5F})
        all.push_back({"cone " + std::to_string(cosMax), [=](const Vec2& u) { return uniformCone(u, cosMax); },
                       [=](const Vec3& d) { return d.z >= cosMax ? uniformConePdf(cosMax) : 0.0; },
                       [=](const Vec3& d) { return invertUniformCone(d, cosMax); }, cosMax});
    return all;
}

std::vector<float> extremes() {
    std::vector<float> values{0.0F, 1e-30F, 1e-12F, 1e-6F, 0.25F, 0.5F, 0.75F, 1.0F - 1e-6F, belowOne};
    for (int i = 0; i < 40; ++i) values.push_back((static_cast<float>(i) + 0.37F) / 40.0F);
    return values;
}

TEST(Directions, AreUnitVectorsAndComeBackFromTheInverse) {
    for (const Map& map : maps())
        for (const float x : extremes())
            for (const float y : extremes()) {
                const Vec3 d = map.sample({x, y});
                ASSERT_NEAR(glm::length(glm::dvec3(d)), 1.0, 3e-7) << map.name << ' ' << x << ' ' << y;
                ASSERT_GE(d.z, map.lowest - 1e-7) << map.name;
                const Vec2 u = map.invert(d);
                ASSERT_GE(u.x, 0.0F);
                ASSERT_LT(u.x, 1.0F);
                ASSERT_GE(u.y, 0.0F);
                ASSERT_LT(u.y, 1.0F);
                // The way back is checked by direction: at a pole, and where an angle wraps, u itself is ambiguous.
                const Vec3 error = map.sample(u) - d;
                ASSERT_LT(std::hypot(error.x, error.y), 2e-6F) << map.name << ' ' << x << ' ' << y;
                // Near its rim the hemisphere is as steep in u as 1/z: half a unit in the last place of u shows.
                const double steep = map.lowest == 0.0 && d.z > 0.0F ? 0x1p-23 / d.z : 0.0;
                ASSERT_LT(std::abs(error.z), 2e-6 + steep) << map.name << ' ' << x << ' ' << y;
            }
}

TEST(Directions, NumbersComeBackInsideTheSquare) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0.01F, 0.99F);
    for (const Map& map : maps())
        for (int i = 0; i < 20'000; ++i) {
            const Vec2 u(uniform(random), uniform(random));
            const Vec2 back = map.invert(map.sample(u));
            ASSERT_NEAR(back.x, u.x, 2e-5) << map.name;
            ASSERT_NEAR(back.y, u.y, 2e-5) << map.name;
        }
}

/// Near a pole the inverse keeps the relative precision of a float, where 1 - z would have lost it.
TEST(Directions, PolesAreResolved) {
    for (const float x : {1e-12F, 1e-9F, 1e-6F}) {
        EXPECT_NEAR(invertUniformSphere(uniformSphere({x, 0.3F})).x / x, 1.0, 1e-5);
        EXPECT_NEAR(invertUniformCone(uniformCone({x, 0.3F}, 0.5F), 0.5F).x / x, 1.0, 1e-5);
    }
    const float narrow = std::cos(1e-3F); // a sun
    for (const float x : {0.1F, 0.5F, 0.9F}) {
        const Vec3 d = uniformCone({x, 0.6F}, narrow);
        EXPECT_NEAR(std::hypot(d.x, d.y), std::sqrt(x * 2.0 * (1.0 - narrow)), 1e-9);
    }
    EXPECT_EQ(uniformCone({0.7F, 0.2F}, 1.0F).z, 1.0F);
    EXPECT_TRUE(std::isinf(uniformConePdf(1.0F)));
}

double integral(const Map& map, double lowest, double highest, double from, double to, int steps) {
    double sum = 0.0;
    for (int i = 0; i < steps; ++i)
        for (int k = 0; k < steps; ++k) {
            const double z = lowest + (highest - lowest) * (i + 0.5) / steps;
            const double angle = from + (to - from) * (k + 0.5) / steps;
            const double r = std::sqrt(1.0 - z * z);
            sum += map.pdf(Vec3(r * std::cos(angle), r * std::sin(angle), z));
        }
    return sum * (highest - lowest) * (to - from) / steps / steps;
}

TEST(Directions, PdfsIntegrateToOne) {
    for (const Map& map : maps())
        EXPECT_NEAR(integral(map, map.lowest, 1.0, 0.0, 2.0 * pi, 400), 1.0, 1e-4) << map.name;
}

TEST(Directions, SamplesFollowTheirPdf) {
    constexpr int zBins = 12;
    constexpr int angleBins = 12;
    constexpr int count = 200'000;
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0.0F, belowOne);
    for (const Map& map : maps()) {
        std::vector<double> observed(std::size_t{zBins} * angleBins, 0.0);
        std::vector<double> expected;
        const double height = (1.0 - map.lowest) / zBins;
        for (int i = 0; i < count; ++i) {
            const Vec3 d = map.sample({uniform(random), uniform(random)});
            const double turn = std::atan2(d.y, d.x) / (2.0 * pi);
            const int z = std::clamp(static_cast<int>((d.z - map.lowest) / height), 0, zBins - 1);
            const int a = std::clamp(static_cast<int>((turn < 0.0 ? turn + 1.0 : turn) * angleBins), 0, angleBins - 1);
            ++observed[static_cast<std::size_t>(z * angleBins + a)];
        }
        for (int z = 0; z < zBins; ++z)
            for (int a = 0; a < angleBins; ++a)
                expected.push_back(count * integral(map, map.lowest + z * height, map.lowest + (z + 1) * height,
                                                    2.0 * pi * a / angleBins, 2.0 * pi * (a + 1) / angleBins, 20));
        EXPECT_LT(test::chiSquareDeviate(observed, expected), 5.0) << map.name; // false alarm 3e-7 each
    }
}

TEST(Directions, DiscIsUniformAndInvertible) {
    constexpr int bins = 10;
    constexpr int count = 100'000;
    std::mt19937 random(8);
    std::uniform_real_distribution<float> uniform(0.0F, belowOne);
    std::vector<double> observed(std::size_t{bins} * bins, 0.0);
    const std::vector<double> expected(std::size_t{bins} * bins, static_cast<double>(count) / (bins * bins));
    for (int i = 0; i < count; ++i) {
        const Vec2 u(uniform(random), uniform(random));
        const Vec2 p = concentricDisc(u);
        const double r2 = static_cast<double>(p.x) * p.x + static_cast<double>(p.y) * p.y;
        const double turn = std::atan2(p.y, p.x) / (2.0 * pi) + 0.5;
        ASSERT_LE(r2, 1.0 + 1e-6);
        ++observed[static_cast<std::size_t>(std::clamp(static_cast<int>(r2 * bins), 0, bins - 1) * bins +
                                            std::clamp(static_cast<int>(turn * bins), 0, bins - 1))];
        ASSERT_LT(glm::length(invertConcentricDisc(p) - u), 1e-5F);
    }
    EXPECT_LT(test::chiSquareDeviate(observed, expected), 5.0);
    EXPECT_NEAR(concentricDiscPdf(), 1.0 / pi, 1e-7);
    EXPECT_EQ(concentricDisc({0.5F, 0.5F}), Vec2(0.0F));
    EXPECT_EQ(invertConcentricDisc(Vec2(0.0F)), Vec2(0.5F));
}

/// Numbers the cells (x, y) with x + y < rows from 0.
int cell(int x, int y, int rows) { return x * rows - x * (x - 1) / 2 + y; }

TEST(Directions, TriangleIsUniformAndInvertible) {
    constexpr int rows = 8; // rows² congruent triangles
    constexpr int count = 100'000;
    std::mt19937 random(9);
    std::uniform_real_distribution<float> uniform(0.0F, belowOne);
    std::vector<double> observed(std::size_t{rows} * rows, 0.0);
    const std::vector<double> expected(std::size_t{rows} * rows, static_cast<double>(count) / (rows * rows));
    for (int i = 0; i < count; ++i) {
        const Vec2 u(uniform(random), uniform(random));
        const Vec2 w = uniformTriangle(u);
        ASSERT_GE(w.x, 0.0F);
        ASSERT_GE(w.y, 0.0F);
        ASSERT_LE(w.x + w.y, 1.0F + 1e-6F);
        ASSERT_LT(glm::length(invertUniformTriangle(w) - u), 1e-5F);
        const int x = static_cast<int>(w.x * rows);
        const int y = static_cast<int>(w.y * rows);
        const bool upper = w.x * rows - static_cast<float>(x) + w.y * rows - static_cast<float>(y) > 1.0F;
        ++observed[static_cast<std::size_t>(upper ? rows * rows - 1 - cell(x, y, rows - 1) : cell(x, y, rows))];
    }
    EXPECT_LT(test::chiSquareDeviate(observed, expected), 5.0);
}

TEST(Directions, CornersOfTheSquareStayInTheTriangle) {
    for (const Vec2& u : {Vec2(0.0F), Vec2(belowOne, 0.0F), Vec2(0.0F, belowOne), Vec2(belowOne)}) {
        const Vec2 w = uniformTriangle(u);
        EXPECT_GE(w.x, 0.0F);
        EXPECT_GE(w.y, 0.0F);
        EXPECT_LE(w.x + w.y, 1.0F);
    }
}

} // namespace
} // namespace pie::sampling
