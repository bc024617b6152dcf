#include "pie/lights/light_set.h"
#include "tests/lights/rooms.h"
#include "tests/sampling/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace pie::lights {
namespace {

Light lamp(float watts, const Vec3& position = Vec3(0.0F)) { return PointLight{position, Rgb(watts), {}}; }

std::vector<std::size_t> countByLight(const LightSet& set, const sampling::Halton& halton, std::uint64_t count) {
    std::vector<std::size_t> counts(set.lights().size(), 0);
    for (std::uint64_t i = 0; i < count; ++i) {
        std::uint32_t light = 0;
        const Emission e = set.emit(halton, i, &light);
        EXPECT_TRUE(std::isfinite(e.flux.x));
        ++counts[light];
    }
    return counts;
}

TEST(LightSet, PhotonsGoByPower) {
    const LightSet set({lamp(1), lamp(5), lamp(0), lamp(2), lamp(0.5F), lamp(0)}, nullptr);
    EXPECT_FLOAT_EQ(set.totalPower().x, 8.5F);
    constexpr std::uint64_t count = 50'000;
    const sampling::Halton halton;
    const auto counts = countByLight(set, halton, count);
    const std::vector<double> shares{1 / 8.5, 5 / 8.5, 0, 2 / 8.5, 0.5 / 8.5, 0};
    // A van der Corput sequence misses the share of an interval by at most log2(n) + 1 points.
    for (std::size_t i = 0; i < shares.size(); ++i)
        EXPECT_NEAR(static_cast<double>(counts[i]), shares[i] * count, 17.0) << i;
}

TEST(LightSet, EveryPhotonCarriesTheSamePower) {
    const LightSet set({lamp(1), lamp(5), lamp(2)}, nullptr);
    for (std::uint64_t i = 0; i < 1000; ++i) EXPECT_NEAR(set.emit(sampling::Halton(), i).flux.y, 8.0F, 1e-4F);
}

TEST(LightSet, ColouredLightsKeepTheirPowerPerChannel) {
    const std::vector<Light> lights{PointLight{{}, Rgb(9, 0, 0), {}}, PointLight{{}, Rgb(0, 3, 1), {}}};
    const LightSet set(lights, nullptr);
    glm::dvec3 sum(0.0);
    constexpr int count = 1 << 16;
    for (std::uint64_t i = 0; i < count; ++i) sum += glm::dvec3(set.emit(sampling::Halton(), i).flux);
    EXPECT_NEAR(sum.x / count, 9.0, 0.01);
    EXPECT_NEAR(sum.y / count, 3.0, 0.01);
    EXPECT_NEAR(sum.z / count, 1.0, 0.01);
}

TEST(LightSet, NegativeLightsSendNegativeFlux) {
    const LightSet set({lamp(4), lamp(-1)}, nullptr);
    EXPECT_FALSE(set.empty());
    EXPECT_NEAR(set.totalPower().x, 3.0F, 1e-5F);
    double sum = 0.0;
    constexpr int count = 1 << 16;
    for (std::uint64_t i = 0; i < count; ++i) sum += set.emit(sampling::Halton(), i).flux.x;
    EXPECT_NEAR(sum / count, 3.0, 0.01);
}

TEST(LightSet, NothingToEmit) {
    EXPECT_TRUE(LightSet().empty());
    EXPECT_TRUE(LightSet({}, nullptr).empty());
    EXPECT_TRUE(LightSet({lamp(0)}, nullptr).empty());
    EXPECT_TRUE(
        LightSet({lamp(std::numeric_limits<float>::quiet_NaN()), lamp(std::numeric_limits<float>::infinity())}, nullptr)
            .empty());
    EXPECT_TRUE(LightSet({SunLight{{0, 0, 1}, Rgb(100.0F)}, SkyLight{{{0, 0, 1}}, Rgb(1.0F)}}, nullptr).empty())
        << "no sky in the scene";
}

TEST(LightSet, ExtremePowersStayFinite) {
    for (const float watts : {1e-30F, 1.0F, 1e30F}) {
        const LightSet set({lamp(watts), lamp(2 * watts), lamp(1)}, nullptr);
        const sampling::Halton halton;
        for (std::uint64_t i = 0; i < 300; ++i) {
            const Emission e = set.emit(halton, i);
            EXPECT_TRUE(std::isfinite(e.flux.x));
            EXPECT_GT(e.flux.x, 0.0F);
        }
    }
}

/// Thousands of lights, as in levels with many emissive faces: all are found, in proportion.
TEST(LightSet, ManyLights) {
    std::vector<Light> lights;
    double total = 0.0;
    for (int i = 0; i < 5000; ++i) {
        const float watts = 1.0F + static_cast<float>((i * 7919) % 97);
        lights.push_back(lamp(watts));
        total += watts;
    }
    const LightSet set(lights, nullptr);
    constexpr std::uint64_t count = 500'000;
    const auto counts = countByLight(set, sampling::Halton(), count);
    for (std::size_t i = 0; i < lights.size(); ++i)
        EXPECT_NEAR(static_cast<double>(counts[i]), std::get<PointLight>(lights[i]).power.x / total * count, 20.0);
}

/// The photons of each light are spread over directions far better than random ones, whatever its share, and also where
/// the number of lights shares factors with the bases.
TEST(LightSet, EachLightSeesAWellDistributedSequence) {
    for (const int count : {1, 2, 3, 6, 30, 210}) {
        std::vector<Light> lights;
        for (int i = 0; i < count; ++i) lights.push_back(lamp(count < 6 ? 1.0F + static_cast<float>(i) : 1.0F));
        const LightSet set(lights, nullptr);
        const sampling::Halton halton;
        std::vector<std::vector<Vec2>> directions(lights.size());
        for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(count) * 256; ++i) {
            std::uint32_t light = 0;
            const Emission e = set.emit(halton, i, &light);
            directions[light].emplace_back(halton(i, 1), halton(i, 2));
            ASSERT_GT(glm::length(e.direction), 0.9F);
        }
        double sum = 0.0;
        double worst = 0.0;
        for (const auto& points : directions) {
            const double ratio = test::starDiscrepancy(points) / test::randomStarDiscrepancy(points.size());
            sum += ratio;
            worst = std::max(worst, ratio);
        }
        EXPECT_LT(sum / count, 0.4) << count << " lights";
        EXPECT_LT(worst, 1.0) << count << " lights";
        RecordProperty("mean ratio of " + std::to_string(count), std::to_string(sum / count));
    }
}

/// Selective photon tracing, eq 5: photons a group apart leave the same light in nearly the same direction.
TEST(LightSet, GroupsOfPhotonsFollowSimilarPaths) {
    std::vector<Light> lights;
    for (int i = 0; i < 8; ++i) lights.push_back(lamp(1.0F));
    const LightSet set(lights, nullptr);
    const sampling::Halton halton;
    constexpr std::uint64_t group = 8ULL * 81 * 25; // 8 lights, 81 × 25 directions
    for (std::uint64_t i = 0; i < 3000; ++i) {
        std::uint32_t a = 0;
        std::uint32_t b = 0;
        const Emission first = set.emit(halton, i, &a);
        const Emission second = set.emit(halton, i + 17 * group, &b);
        ASSERT_EQ(a, b);
        // 1/81 of the height and 1/25 of a turn.
        ASSERT_NEAR(first.direction.z, second.direction.z, 2.0 / 81 + 1e-5);
        ASSERT_LT(glm::length(first.direction - second.direction), 0.45F);
    }
}

TEST(LightSet, EmissionIsAFunctionOfTheIndex) {
    const LightSet set({lamp(1), lamp(5, {1, 2, 3}), SphereLight{{4, 5, 6}, Rgb(3.0F), 2, {}}}, nullptr);
    const LightSet copy = set;
    const sampling::Halton halton(7);
    for (const std::uint64_t i : {0ULL, 1ULL, 99ULL, 1ULL << 40U}) {
        const Emission a = set.emit(halton, i);
        const Emission b = copy.emit(sampling::Halton(7), i);
        EXPECT_EQ(a.origin, b.origin);
        EXPECT_EQ(a.direction, b.direction);
        EXPECT_EQ(a.flux, b.flux);
    }
}

std::vector<Light> oneOfEach() {
    SkyLight sky;
    sky.irradiance = Rgb(2.0F);
    for (int i = 0; i < 9; ++i)
        sky.towards.push_back(
            glm::normalize(Vec3(std::cos(static_cast<float>(i) * 0.7F), std::sin(static_cast<float>(i) * 0.7F), 0.5F)));
    return {lamp(3e5F, {20, -30, 60}),
            SphereLight{{-20, 10, 50}, Rgb(1e5F), 8, {}},
            SpotLight{{0, 0, 80}, {0, 0, -1}, Rgb(4e5F), 0.7F, 32, {}},
            SunLight{glm::normalize(Vec3(0.3F, 0.1F, 1.0F)), Rgb(10.0F), 0.05F},
            sky,
            makeAreaLight({{-50, -50, 70}, {-50, 20, 70}, {0, 40, 70}, {50, 20, 70}, {40, -50, 70}}, Rgb(40.0F)),
            makeAreaLight({{60, -50, 5}, {60, 50, 5}, {60, 50, 60}}, Rgb(60.0F), true)};
}
std::shared_ptr<const scene::Scene> openAbove() {
    test::RoomBuilder room;
    const auto open = room.material(test::sky());
    const auto wall = room.material(test::opaque(Rgb(0.5F)));
    room.inside({-100, -100, 0}, {100, 100, 100}, {wall, open, wall, wall, wall, wall});
    return room.build();
}

TEST(LightSet, RunsOfIndicesEqualSingleOnes) {
    const LightSet set(oneOfEach(), openAbove());
    const sampling::Halton halton(3);
    std::vector<Emission> run(700);
    set.emit(halton, 1234567, run);
    for (std::size_t i = 0; i < run.size(); ++i) {
        const Emission one = set.emit(halton, 1234567 + i);
        ASSERT_EQ(run[i].origin, one.origin);
        ASSERT_EQ(run[i].direction, one.direction);
        ASSERT_EQ(run[i].flux, one.flux);
        ASSERT_EQ(run[i].falloff, one.falloff);
        ASSERT_EQ(run[i].rimRate, one.rimRate);
    }
}

constexpr int cells = 6;

/// Flux of one frame of photons into the cells of the floor.
std::array<double, cells * cells> fallenPhotons(const LightSet& set, const sampling::Halton& halton,
                                                std::size_t count) {
    std::array<double, cells * cells> fallen{};
    std::vector<Emission> run(count);
    set.emit(halton, 0, run);
    for (const Emission& e : run) {
        const float t = -e.origin.z / e.direction.z;
        if (!(t > 0.0F)) continue;
        const Vec3 p = e.origin + t * e.direction;
        const int x = static_cast<int>(std::floor((p.x + 60.0F) / 20.0F));
        const int y = static_cast<int>(std::floor((p.y + 60.0F) / 20.0F));
        if (x < 0 || y < 0 || x >= cells || y >= cells) continue;
        fallen[static_cast<std::size_t>(x * cells + y)] +=
            e.flux.x * arrivalFactor(e, t, -e.direction.z) / static_cast<double>(count);
    }
    return fallen;
}
/// The same by illuminate, over one cell.
double illuminatedCell(const LightSet& set, const sampling::Halton& halton, int x, int y) {
    constexpr std::uint64_t samples = 512;
    double sum = 0.0;
    for (const Light& light : set.lights())
        for (std::uint64_t i = 0; i < samples; ++i) {
            const Vec3 p(20.0F * (static_cast<float>(x) + halton(i, 2)) - 60.0F,
                         20.0F * (static_cast<float>(y) + halton(i, 3)) - 60.0F, 0.0F);
            const Illumination got = illuminate(light, p, {0, 0, 1}, false, {halton(i, 0), halton(i, 1)});
            // Sun and sky: only where the way leads out through the ceiling, not a wall.
            const Vec3 out = p + got.towards * (100.0F / got.towards.z);
            const bool open = got.towards.z > 0.0F && std::abs(out.x) < 100.0F && std::abs(out.y) < 100.0F;
            if (!got.needsSky || open) sum += got.irradiance.x * 400.0 / samples;
        }
    return sum;
}

/// The photons of all lights together leave on the floor what illuminate sums up to. Seeds are independent repetitions;
/// |z| < 6 in each of 36 cells (false alarm 1e-3 in all: Student's t with 15 degrees of freedom).
TEST(LightSet, PhotonsOfAllLightsLightTheFloorAsTheyIlluminateIt) {
    const LightSet set(oneOfEach(), openAbove());
    std::array<test::Moments, cells * cells> photons;
    std::array<test::Moments, cells * cells> direct;
    for (std::uint64_t seed = 1; seed <= 16; ++seed) {
        const sampling::Halton halton(seed);
        const auto fallen = fallenPhotons(set, halton, 50'000);
        for (int x = 0; x < cells; ++x)
            for (int y = 0; y < cells; ++y) {
                const auto cell = static_cast<std::size_t>(x * cells + y);
                photons[cell].add(fallen[cell]);
                direct[cell].add(illuminatedCell(set, halton, x, y));
            }
    }
    for (std::size_t cell = 0; cell < photons.size(); ++cell) {
        const auto& a = photons[cell];
        const auto& b = direct[cell];
        EXPECT_LT(std::abs(test::zScore(a.mean(), b.mean(), a.squaredError() + b.squaredError())), 6.0)
            << cell << ": " << a.mean() << ' ' << b.mean();
        EXPECT_NEAR(a.mean() / b.mean(), 1.0, 0.05) << cell;
    }
}

/// A sky enters through all portals in proportion to what they show to each direction.
TEST(LightSet, SkyPhotonsAllWeighTheSame) {
    test::RoomBuilder room;
    const auto open = room.material(test::sky());
    const auto wall = room.material(test::opaque(Rgb(0.5F)));
    room.inside({0, 0, 0}, {100, 200, 50}, {wall, open, open, wall, wall, wall});
    SkyLight sky;
    sky.irradiance = Rgb(2.0F);
    for (int i = 0; i < 9; ++i)
        sky.towards.push_back(glm::normalize(Vec3(std::cos(i * 0.7F), std::sin(i * 0.7F), 0.5F)));
    const LightSet set({sky}, room.build());
    ASSERT_FALSE(set.empty());
    const float watts = set.totalPower().x;
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const Emission e = set.emit(sampling::Halton(), i);
        EXPECT_NEAR(e.flux.x / watts, 1.0F, 1e-4F);
        EXPECT_TRUE((e.origin.z > 49.0F && e.direction.z < 0.0F) || (e.origin.x < 1.0F && e.direction.x > 0.0F));
    }
}

} // namespace
} // namespace pie::lights
