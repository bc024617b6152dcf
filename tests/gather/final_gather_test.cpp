// Final gathering against light with exact answers.

#include "pie/core/parallel.h"
#include "pie/gather/direct.h"
#include "pie/gather/final_gather.h"
#include "pie/gather/form_factor.h"
#include "pie/photons/tracer.h"
#include "tests/gather/gathering.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace pie::gather {
namespace {

using photons::Photon;
using test::all;
using test::receiverAt;
using test::SceneBuilder;

const Vec3 up(0.0F, 0.0F, 1.0F);

/// A lit wall of reflectance 0.5 at x = 0, 200 by 100 units, and a black floor that sees it: E = 0.5 E(wall) F.
struct LitWall {
    static constexpr float irradiance = 3;
    static constexpr float rho = 0.5F;
    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<intersect::Intersector> intersector;
    scene::Receivers receivers;
    maps::RealtimeMap map{4};
    NearestOptions atHits;
    FinalGatherOptions options;

    explicit LitWall(std::vector<float> distances, std::size_t photonsPerFrame = 20'000) {
        SceneBuilder builder;
        const std::uint32_t white = builder.grey(rho);
        const std::uint32_t black = builder.grey(0);
        builder.quad({0.0F, -100.0F, 0.0F}, {0.0F, 200.0F, 0.0F}, {0.0F, 0.0F, 100.0F}, white);
        builder.quad({0.0F, -100.0F, 0.0F}, {200.0F, 0.0F, 0.0F}, {0.0F, 200.0F, 0.0F}, black);
        scene = builder.make();
        intersector = intersect::makeIntersector(intersect::Kind::BruteForce, *scene, {});
        for (const float d : distances) {
            receivers.points.push_back(receiverAt({d, 0.0F, 0.0F}, up));
            receivers.points.back().inset.x = std::max(d, 0.5F);
        }
        std::mt19937 random(3);
        for (int frame = 0; frame < 4; ++frame) {
            std::vector<Photon> photons;
            for (std::size_t i = 0; i < photonsPerFrame; ++i) {
                const Vec3 p(0.0F, 200.0F * test::unit(random) - 100.0F, 100.0F * test::unit(random));
                photons.push_back(test::photonOn(*scene, i % 2 == 0 ? 0 : 1, p,
                                                 irradiance * 20'000.0F / static_cast<float>(photonsPerFrame)));
                photons.back().bounce = 0;
            }
            map.replaceOldest(std::move(photons));
        }
        map.rebuild();
        atHits.area = AreaEstimate::True;
        atHits.kernel = Kernel::Epanechnikov;
        atHits.maxRadius = 20;
        atHits.maxCount = 2000; // 2.4 % of noise where all rays end in one place
        options.samples = 256;
    }
    /// Where rays start.
    [[nodiscard]] double exact(std::size_t i) const {
        const std::array<Vec3, 4> wall{Vec3(0.0F, -100.0F, 0.0F), Vec3(0.0F, 100.0F, 0.0F), Vec3(0.0F, 100.0F, 100.0F),
                                       Vec3(0.0F, -100.0F, 100.0F)};
        const float offset = glm::length(scene->bounds.size()) / 4096.0F;
        return static_cast<double>(rho * irradiance) * (formFactor(wall, receivers.points[i].inset + offset * up, up));
    }
    [[nodiscard]] std::vector<Rgb> estimate() const {
        const FinalGather gather(*scene, *intersector, receivers, map, atHits, options);
        std::vector<Rgb> result(receivers.points.size(), Rgb(-1.0F));
        gather.estimate(all(receivers), result);
        return result;
    }
};

TEST(FinalGather, SeesALitWallByItsFormFactor) {
    for (const float secondary : {0.0F, 16.0F})
        for (const unsigned precompute : {0U, 4U}) {
            LitWall wall({0.0F, 1.0F, 5.0F, 20.0F, 60.0F, 150.0F});
            wall.options.secondaryDistance = secondary;
            wall.options.precompute = precompute;
            const std::vector<Rgb> found = wall.estimate();
            for (std::size_t i = 0; i < found.size(); ++i)
                EXPECT_NEAR(found[i].x, wall.exact(i), 0.045)
                    << i << ", secondary " << secondary << ", precompute " << precompute;
        }
}

TEST(FinalGather, DirectLightAtTheReceiverIsLeftOutOrFromPhotons) {
    LitWall wall({50.0F});
    wall.receivers.points.push_back(receiverAt({0.0F, 0.0F, 50.0F}, {1.0F, 0.0F, 0.0F}));
    EXPECT_EQ(wall.estimate()[1], Rgb(0.0F)) << "the wall sees only the black floor";
    wall.options.addDirect = true;
    EXPECT_NEAR(wall.estimate()[1].x, LitWall::irradiance, 0.1F * LitWall::irradiance);
}

// A closed cube: reflected light is Φ/A · ρ/(1 − ρ) in the mean. 216 receivers, evenly over the walls.
TEST(FinalGather, FindsTheExactMeanOfAFurnace) {
    constexpr float side = 64;
    constexpr float rho = 0.6F;
    SceneBuilder builder;
    builder.grey(rho);
    builder.room(Vec3(0.0F), Vec3(side));
    const auto scene = builder.make();
    const auto intersector = intersect::makeIntersector(intersect::Kind::BruteForce, *scene, {});
    lights::PointLight lamp;
    lamp.position = Vec3(0.5F * side);
    lamp.power = Rgb(1000.0F);
    lamp.falloff.minDistance = 0;
    const lights::LightSet lights({lamp}, scene);
    photons::TracerOptions tracing;
    tracing.storeDirectLight = true;
    tracing.recursionDepth = 60;
    std::vector<Photon> photons;
    photons::PhotonTracer(*scene, lights, *intersector, tracing).trace(1, 60'000, photons);
    maps::RealtimeMap map;
    map.replaceOldest(std::move(photons));
    map.rebuild();
    scene::Receivers receivers;
    for (int face = 0; face < 6; ++face)
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 6; ++x) {
                Vec3 normal(0.0F);
                normal[face / 2] = face % 2 == 0 ? 1.0F : -1.0F;
                Vec3 p(0.0F);
                p[face / 2] = face % 2 == 0 ? 0.0F : side;
                p[(face / 2 + 1) % 3] = (static_cast<float>(x) + 0.5F) * side / 6;
                p[(face / 2 + 2) % 3] = (static_cast<float>(y) + 0.5F) * side / 6;
                receivers.points.push_back(receiverAt(p, normal));
            }
    NearestOptions atHits;
    atHits.area = AreaEstimate::True;
    atHits.kernel = Kernel::Epanechnikov;
    atHits.maxRadius = 8;
    const double exact = 1000.0 / (6.0 * side * side) * rho / (1 - rho);
    FinalGatherOptions options;
    options.samples = 128;
    options.secondaryDistance = 4;
    const auto mean = [&] {
        const FinalGather gather(*scene, *intersector, receivers, map, atHits, options, &lights);
        std::vector<Rgb> found(receivers.points.size());
        gather.estimate(all(receivers), found);
        double sum = 0;
        for (const Rgb& e : found) sum += static_cast<double>(e.x) / static_cast<double>(found.size());
        return sum;
    };
    EXPECT_NEAR(mean() / exact, 1.0, 0.01);
    options.precompute = 4;
    EXPECT_NEAR(mean() / exact, 1.0, 0.015);
    options.precompute = 0;
    options.cacheAccuracy = 0.3F;
    EXPECT_NEAR(mean() / exact, 1.0, 0.02);
}

TEST(FinalGather, TheCacheGathersFewAndInterpolates) {
    std::vector<float> distances;
    for (int i = 0; i < 300; ++i) distances.push_back(20.0F + 0.3F * static_cast<float>(i));
    LitWall wall(distances);
    wall.options.cacheAccuracy = 0.1F;
    const FinalGather gather(*wall.scene, *wall.intersector, wall.receivers, wall.map, wall.atHits, wall.options);
    std::vector<Rgb> found(distances.size());
    gather.estimate(all(wall.receivers), found);
    EXPECT_GT(gather.records(), 2U);
    EXPECT_LT(gather.records(), 60U);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i].x, wall.exact(i), 0.03) << distances[i];
    // Nothing is traced twice, and what is asked along does not matter.
    const std::uint64_t rays = gather.raysTraced();
    const std::uint32_t one = 123;
    Rgb alone(0.0F);
    gather.estimate({&one, 1}, {&alone, 1});
    EXPECT_EQ(alone, found[one]);
    EXPECT_EQ(gather.raysTraced(), rays);
    EXPECT_GT(gather.bytes(), 0U);
    // New photons are new light.
    wall.map.clear();
    wall.map.rebuild();
    gather.estimate({&one, 1}, {&alone, 1});
    EXPECT_EQ(alone, Rgb(0.0F));
}

TEST(FinalGather, StandardErrorCoversTheError) {
    std::vector<float> distances;
    for (int i = 0; i < 200; ++i) distances.push_back(5.0F + 0.7F * static_cast<float>(i));
    LitWall wall(distances, 2000);
    wall.options.samples = 64;
    wall.options.secondaryDistance = 0;
    const FinalGather gather(*wall.scene, *wall.intersector, wall.receivers, wall.map, wall.atHits, wall.options);
    std::vector<Estimate> found(distances.size());
    gather.explain(all(wall.receivers), found);
    std::vector<Rgb> plain(distances.size());
    gather.estimate(all(wall.receivers), plain);
    double within = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].irradiance, plain[i]);
        EXPECT_EQ(found[i].photons, 64U);
        // Channels are 1, 2 and 0 times the first: their mean is the first.
        if (std::abs(static_cast<double>(found[i].irradiance.x) - wall.exact(i)) <=
            static_cast<double>(found[i].standardError))
            ++within;
    }
    // The groups of rays are better spread together than each alone, so more than 68 %. 200 receivers, correlated.
    EXPECT_GT(within / 200, 0.6);
}

TEST(FinalGather, SameBitsOnAnyNumberOfThreads) {
    for (const float cache : {0.0F, 0.3F}) {
        LitWall wall({0.0F, 2.0F, 3.0F, 5.0F, 8.0F, 13.0F, 21.0F, 34.0F, 55.0F, 89.0F}, 3000);
        for (int i = 0; i < 60; ++i)
            wall.receivers.points.push_back(receiverAt({3.0F * static_cast<float>(i), 20.0F, 0.0F}, up, i % 3 == 0));
        wall.options.samples = 100;
        wall.options.cacheAccuracy = cache;
        setThreads(1);
        const std::vector<Rgb> one = wall.estimate();
        setThreads(2);
        EXPECT_EQ(wall.estimate(), one);
        setThreads(0);
    }
}

TEST(FinalGather, NothingBreaksIt) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    LitWall wall({0.0F, 10.0F}, 100);
    wall.receivers.points.push_back(receiverAt({10.0F, 0.0F, 0.0F}, Vec3(0.0F)));
    wall.receivers.points.push_back(receiverAt({nan, 0.0F, 0.0F}, up));
    wall.receivers.points.push_back(receiverAt({10.0F, 0.0F, 0.0F}, Vec3(nan)));
    wall.receivers.points.push_back(receiverAt({1e30F, 0.0F, 0.0F}, up, true));
    for (const unsigned samples : {0U, 1U, 40U})
        for (const unsigned second : {0U, 1U})
            for (const unsigned precompute : {0U, 1U, 1000U})
                for (const float cache : {0.0F, 1e-6F, 0.3F, 1e6F}) {
                    wall.options.samples = samples;
                    wall.options.secondarySamples = second;
                    wall.options.precompute = precompute;
                    wall.options.cacheAccuracy = cache;
                    for (const Rgb& e : wall.estimate())
                        ASSERT_TRUE(std::isfinite(e.x) && e.x >= 0.0F) << samples << ' ' << cache;
                    if (samples == 0) {
                        EXPECT_EQ(wall.estimate()[1], Rgb(0.0F));
                    }
                }
}

} // namespace
} // namespace pie::gather
