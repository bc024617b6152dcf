// The two estimators on photons placed by hand: what they count, what they divide by, and numbers that must not break
// them. Their accuracy on traced light: furnace_test.cpp.

#include "pie/core/parallel.h"
#include "pie/gather/nearest_photons.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace pie::gather {
namespace {

using photons::Photon;
using test::all;
using test::receiverAt;
using test::receiversAt;
using test::SceneBuilder;

constexpr float pi = std::numbers::pi_v<float>;
const Vec3 up(0.0F, 0.0F, 1.0F);

Photon photonOn(const scene::Scene& scene, std::uint32_t triangle, const Vec3& position, float watts) {
    Photon photon;
    photon.position = position;
    photon.triangle = triangle;
    photon.direction = -scene.normals[triangle];
    photon.flux = Rgb(watts, 2.0F * watts, 0.0F);
    photon.bounce = 1;
    return photon;
}

/// Photons thrown evenly on every triangle: `irradiance` watts per square unit.
std::vector<Photon> even(const scene::Scene& scene, std::size_t count, float irradiance, std::uint32_t seed) {
    const test::SurfaceSampler sampler(scene);
    const float watts = irradiance * static_cast<float>(sampler.area()) / static_cast<float>(count);
    std::mt19937 random(seed);
    std::vector<Photon> photons;
    for (std::size_t i = 0; i < count; ++i) {
        const auto [position, triangle] = sampler(random);
        photons.push_back(photonOn(scene, triangle, position, watts));
    }
    return photons;
}

std::shared_ptr<const scene::Scene> room() {
    SceneBuilder builder;
    builder.room(Vec3(0.0F), Vec3(100.0F));
    return builder.make();
}

struct Gathering {
    std::shared_ptr<const scene::Scene> scene;
    scene::Receivers receivers;
    maps::RealtimeMap map;
    NearestOptions options;
    Kernel kernel = Kernel::Epanechnikov; ///< of the true area

    Gathering(std::shared_ptr<const scene::Scene> s, std::vector<scene::Receiver> points, std::vector<Photon> photons,
              maps::Search search = maps::Search::KdTree)
        : scene(std::move(s)), receivers(receiversAt(std::move(points))), map(1, search) {
        map.replaceOldest(std::move(photons));
        map.rebuild();
    }
    [[nodiscard]] std::vector<Rgb> estimate(bool trueArea, const Estimator* direct = nullptr) const {
        const std::vector<std::uint32_t> which = all(receivers);
        std::vector<Rgb> irradiance(which.size(), Rgb(-1.0F));
        if (trueArea) {
            const TrueArea area(*scene, kernel, options.slice, options.maxRadius);
            const AreaTable table(area, receivers);
            NearestPhotons(*scene, receivers, map, options, area, table, direct).estimate(which, irradiance);
        } else {
            NearestPhotons(*scene, receivers, map, options, direct).estimate(which, irradiance);
        }
        return irradiance;
    }
};

TEST(NearestPhotons, DividesTheFluxOfKMinusOneByTheDiscOfTheKth) {
    const auto scene = room();
    std::vector<Photon> photons;
    for (const float d : {1.0F, 2.0F, 3.0F, 4.0F, 5.0F})
        photons.push_back(photonOn(*scene, 0, {50.0F + d, 50.0F, 0.0F}, d));
    Gathering g(scene, {receiverAt({50.0F, 50.0F, 0.0F}, up)}, photons);
    g.options.maxRadius = 20.0F;
    g.options.maxCount = 3;
    EXPECT_FLOAT_EQ(g.estimate(false)[0].x, (1.0F + 2.0F) / (pi * 9.0F));
    EXPECT_FLOAT_EQ(g.estimate(false)[0].y, 2.0F * (1.0F + 2.0F) / (pi * 9.0F));
    g.options.dropBorder = false;
    EXPECT_FLOAT_EQ(g.estimate(false)[0].x, (1.0F + 2.0F + 3.0F) / (pi * 9.0F));
    g.options.maxCount = 9; // fewer there are: the largest radius, and all of them
    g.options.dropBorder = true;
    EXPECT_FLOAT_EQ(g.estimate(false)[0].x, 15.0F / (pi * 400.0F));
    g.options.maxCount = 0;
    EXPECT_EQ(g.estimate(false)[0], Rgb(0.0F));
    g.options.maxCount = 1; // the only one cannot be dropped
    EXPECT_FLOAT_EQ(g.estimate(false)[0].x, 1.0F / pi);
    g.options.maxRadius = 0.5F;
    EXPECT_EQ(g.estimate(false)[0], Rgb(0.0F));
}

TEST(NearestPhotons, TrueAreaWeightsByItsKernel) {
    const auto scene = room();
    std::vector<Photon> photons;
    for (const float d : {1.0F, 2.0F, 4.0F}) photons.push_back(photonOn(*scene, 0, {50.0F + d, 50.0F, 0.0F}, 1.0F));
    Gathering g(scene, {receiverAt({50.0F, 50.0F, 0.0F}, up)}, photons);
    g.options.maxRadius = 20.0F;
    g.options.maxCount = 3;
    const float expected = ((1.0F - 1.0F / 16.0F) + (1.0F - 4.0F / 16.0F)) / (pi / 2.0F * 16.0F);
    EXPECT_NEAR(g.estimate(true)[0].x, expected, 1e-3F * expected);
    g.kernel = Kernel::Constant;
    EXPECT_NEAR(g.estimate(true)[0].x, 2.0F / (pi * 16.0F), 1e-5F);
}

TEST(NearestPhotons, SliceAndDirectionKeepOtherSurfacesOut) {
    const auto scene = room();
    Photon above = photonOn(*scene, 0, {50.0F, 50.0F, 6.0F}, 1.0F);
    Photon fromBelow = photonOn(*scene, 0, {50.0F, 50.0F, 0.0F}, 1.0F);
    fromBelow.direction = up;
    Gathering g(scene, {receiverAt({50.0F, 50.0F, 0.0F}, up)}, {above, fromBelow});
    g.options.maxRadius = 10.0F;
    const float one = 1.0F / (pi * 100.0F);
    EXPECT_EQ(g.estimate(false)[0].x, 0.0F);
    g.options.incomingDirection = false;
    EXPECT_FLOAT_EQ(g.estimate(false)[0].x, one);
    g.options.volume = SearchVolume::Sphere;
    EXPECT_FLOAT_EQ(g.estimate(false)[0].x, 2.0F * one);
}

TEST(NearestPhotons, FiltersBeforeCounting) {
    // 1000 photons of the wall are nearer than any of the floor; k of the floor are found all the same.
    const auto scene = room();
    std::vector<Photon> photons;
    for (int i = 0; i < 1000; ++i)
        photons.push_back(photonOn(*scene, 4, {0.0F, 50.0F, 0.001F * static_cast<float>(i)}, 100.0F));
    for (int i = 1; i <= 20; ++i)
        photons.push_back(photonOn(*scene, 0, {3.0F + static_cast<float>(i), 50.0F, 0.0F}, 1.0F));
    Gathering g(scene, {receiverAt({0.0F, 50.0F, 0.0F}, up)}, photons);
    g.options.maxCount = 10;
    g.options.maxRadius = 50.0F;
    g.kernel = Kernel::Constant;
    const float expected = 9.0F / (pi * 13.0F * 13.0F) * 2.0F; // half a disc
    EXPECT_NEAR(g.estimate(true)[0].x, expected, 1e-3F * expected);
}

TEST(NearestPhotons, EdgesAndCorners) {
    const auto scene = room();
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 40; ++i) {
        const float s = 20.0F + 1.5F * static_cast<float>(i);
        points.push_back(receiverAt({s, 50.0F, 0.0F}, up));  // inside
        points.push_back(receiverAt({s, 0.0F, 0.0F}, up));   // edge
        points.push_back(receiverAt({100.0F, s, 0.0F}, up)); // edge
    }
    const std::size_t corner = points.size();
    for (const float x : {0.0F, 100.0F})
        for (const float y : {0.0F, 100.0F}) {
            points.push_back(receiverAt({x, y, 0.0F}, up));
            points.push_back(receiverAt({x, y, 100.0F}, -up));
        }
    Gathering g(scene, points, even(*scene, 400'000, 3.0F, 8));
    g.options.maxCount = 400;
    g.options.maxRadius = 40.0F;
    g.options.slice.halfThickness = 0.05F;
    const auto mean = [&](const std::vector<Rgb>& values, int kind) {
        double sum = 0;
        int count = 0;
        for (std::size_t i = 0; i < values.size(); ++i)
            if ((i >= corner ? 2 : i % 3 == 0 ? 0 : 1) == kind) {
                sum += static_cast<double>(values[i].x);
                ++count;
            }
        return sum / count / 3.0;
    };
    // Standard error of one estimate 5 %, of the means below 1 % (inside and edges) and 2 % (corners): bounds at 4
    // sigma.
    const std::vector<Rgb> disc = g.estimate(false);
    EXPECT_NEAR(mean(disc, 0), 1.0, 0.04);
    EXPECT_NEAR(mean(disc, 1), 0.5, 0.04) << "half of the disc is not there";
    EXPECT_NEAR(mean(disc, 2), 0.25, 0.04) << "three quarters of the disc are not there";
    const std::vector<Rgb> exact = g.estimate(true);
    EXPECT_NEAR(mean(exact, 0), 1.0, 0.04);
    EXPECT_NEAR(mean(exact, 1), 1.0, 0.04);
    EXPECT_NEAR(mean(exact, 2), 1.0, 0.08);
}

TEST(NearestPhotons, KMinusOneIsUnbiasedWhereKIsNot) {
    const auto scene = room();
    std::vector<scene::Receiver> points;
    std::mt19937 random(14);
    for (int i = 0; i < 4000; ++i)
        points.push_back(
            receiverAt({20.0F + 60.0F * test::unit(random), 20.0F + 60.0F * test::unit(random), 0.0F}, up));
    Gathering g(scene, points, even(*scene, 600'000, 1.0F, 15));
    g.options.maxCount = 5;
    g.options.slice.halfThickness = 0.05F;
    const auto mean = [](const std::vector<Rgb>& values) {
        double sum = 0;
        for (const Rgb& value : values) sum += static_cast<double>(value.x);
        return sum / static_cast<double>(values.size());
    };
    // 4000 estimates with a relative standard deviation of 1/sqrt(3): standard error 0.9 %, hence 4 sigma = 3.7 %.
    EXPECT_NEAR(mean(g.estimate(false)), 1.0, 0.037);
    EXPECT_NEAR(mean(g.estimate(true)), 1.0, 0.037);
    g.options.dropBorder = false;
    EXPECT_NEAR(mean(g.estimate(false)), 1.25, 0.046);
}

TEST(NearestPhotons, TwoSidedReceiversAddBothSides) {
    SceneBuilder builder;
    scene::Material cloth;
    cloth.twoSided = true;
    builder.material(cloth);
    builder.quad({-50.0F, -50.0F, 0.0F}, {100.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F});
    const auto scene = builder.make();
    std::vector<Photon> photons = even(*scene, 100'000, 4.0F, 19);
    for (std::size_t i = 0; i < photons.size(); ++i)
        if (i % 4 == 0) photons[i].direction = up; // a quarter from below
    Gathering g(scene, {receiverAt(Vec3(0.0F), up, true), receiverAt(Vec3(0.0F), up), receiverAt(Vec3(0.0F), -up)},
                photons);
    g.options.maxCount = 2000;
    g.options.maxRadius = 40.0F;
    for (const bool trueArea : {false, true}) {
        const std::vector<Rgb> e = g.estimate(trueArea);
        EXPECT_NEAR(e[0].x, 4.0F, 0.4F); // standard error 2.2 % and more
        EXPECT_NEAR(e[1].x, 3.0F, 0.35F);
        EXPECT_NEAR(e[2].x, 1.0F, 0.15F);
    }
}

TEST(NearestPhotons, ScalesByTheFramesPresent) {
    const auto scene = room();
    Gathering g(scene, {receiverAt({50.0F, 50.0F, 0.0F}, up)}, {});
    g.map.setAccumulationFrames(3);
    g.options.maxRadius = 10.0F;
    for (int frame = 0; frame < 5; ++frame) {
        g.map.replaceOldest({photonOn(*scene, 0, {50.0F, 51.0F, 0.0F}, 2.0F)});
        g.map.rebuild();
        EXPECT_FLOAT_EQ(g.estimate(false)[0].x, frame == 0 ? 1.0F / (pi * 100.0F) : g.estimate(false)[0].x);
    }
    g.map.clear();
    g.map.rebuild();
    EXPECT_EQ(g.estimate(false)[0], Rgb(0.0F));
}

TEST(NearestPhotons, RadiusHeuristic) {
    const auto scene = room();
    Gathering g(scene, {}, even(*scene, 10'000, 1.0F, 3));
    g.options.maxRadius = 80.0F;
    g.options.maxCount = 50;
    g.options.radiusHeuristic = true;
    g.options.heuristicAlpha = 0.5F;
    const NearestPhotons estimator(*scene, g.receivers, g.map, g.options);
    const float enclosing = 50.0F * std::sqrt(3.0F);
    EXPECT_NEAR(estimator.searchRadius(), enclosing * std::sqrt(50.0F / (0.5F * 10'000.0F)), 0.1F); // eq 3.7
    g.options.heuristicAlpha = 1e-6F;
    EXPECT_EQ(NearestPhotons(*scene, g.receivers, g.map, g.options).searchRadius(), 80.0F);
    g.map.clear();
    g.map.rebuild();
    EXPECT_EQ(estimator.searchRadius(), 80.0F);
}

/// One watt per square unit everywhere.
class One final : public Estimator {
public:
    void estimate(std::span<const std::uint32_t> /*which*/, std::span<Rgb> irradiance) const override {
        std::fill(irradiance.begin(), irradiance.end(), Rgb(1.0F));
    }
    [[nodiscard]] std::string_view name() const override { return "one"; }
};

TEST(NearestPhotons, AddsDirectLightInPlaceOfDirectPhotons) {
    const auto scene = room();
    Photon direct = photonOn(*scene, 0, {50.0F, 51.0F, 0.0F}, 2.0F);
    direct.bounce = 0;
    const Photon indirect = photonOn(*scene, 0, {50.0F, 52.0F, 0.0F}, 3.0F);
    Gathering g(scene, {receiverAt({50.0F, 50.0F, 0.0F}, up)}, {direct, indirect});
    g.options.maxRadius = 10.0F;
    const float area = pi * 100.0F;
    const One one;
    EXPECT_FLOAT_EQ(g.estimate(false)[0].x, 5.0F / area);
    EXPECT_FLOAT_EQ(g.estimate(false, &one)[0].x, 1.0F + 3.0F / area);
    g.options.indirectOnly = true;
    EXPECT_FLOAT_EQ(g.estimate(false)[0].x, 3.0F / area);
    g.map.clear();
    g.map.rebuild();
    EXPECT_EQ(g.estimate(true, &one)[0], Rgb(1.0F));
}

TEST(NearestPhotons, StaysFiniteWhateverHappens) {
    const auto scene = room();
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float watts : {0.0F, 1e-38F, 1e-30F, 1e30F, 3e38F, -5.0F, infinity, nan}) {
        // All in one point, and there is the receiver.
        std::vector<Photon> photons(200, photonOn(*scene, 0, {50.0F, 50.0F, 0.0F}, 1.0F));
        for (Photon& photon : photons) photon.flux = Rgb(watts);
        Gathering g(scene,
                    {receiverAt({50.0F, 50.0F, 0.0F}, up), receiverAt({50.0F, 50.0F, 0.0F}, up, true),
                     receiverAt({50.0F, 50.0F, 1e-30F}, up), receiverAt({50.0F, 50.0F, 0.0F}, Vec3(0.0F)),
                     receiverAt({50.0F, 50.0F, 0.0F}, Vec3(nan)), receiverAt({nan, 50.0F, 0.0F}, up)},
                    photons);
        for (const float radius :
             {0.0F, std::numeric_limits<float>::denorm_min(), 1e-20F, 1.0F, 1e30F, infinity, nan, -1.0F})
            for (const std::size_t k :
                 {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{200}, std::size_t{201}})
                for (const bool trueArea : {false, true}) {
                    g.options.maxRadius = radius;
                    g.options.maxCount = k;
                    for (const Rgb& e : g.estimate(trueArea)) {
                        EXPECT_TRUE(std::isfinite(e.x) && e.x >= 0.0F)
                            << e.x << ": " << watts << " W, radius " << radius << ", k " << k;
                    }
                    if (k == 0 || !(radius > 0.0F) || watts == 0.0F) {
                        EXPECT_EQ(g.estimate(trueArea)[0], Rgb(0.0F));
                    }
                }
    }
}

TEST(NearestPhotons, AnInfiniteRadiusIsTheDiagonalOfTheScene) {
    const auto scene = room();
    Gathering g(scene, {receiverAt({50.0F, 50.0F, 0.0F}, up)}, {photonOn(*scene, 0, {50.0F, 51.0F, 0.0F}, 2.0F)});
    g.options.maxRadius = std::numeric_limits<float>::infinity();
    EXPECT_FLOAT_EQ(g.estimate(false)[0].x, 2.0F / (pi * 30'000.0F));
}

TEST(NearestPhotons, SameBitsOnAnyNumberOfThreadsAndInAnyBatch) {
    const auto scene = room();
    std::mt19937 random(31);
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 700; ++i)
        points.push_back(receiverAt({100.0F * test::unit(random), 100.0F * test::unit(random), 0.0F}, up, i % 5 == 0));
    Gathering g(scene, points, even(*scene, 20'000, 1.0F, 32));
    g.options.maxRadius = 20.0F;
    for (const bool trueArea : {false, true}) {
        setThreads(1);
        const std::vector<Rgb> one = g.estimate(trueArea);
        setThreads(2);
        EXPECT_EQ(g.estimate(trueArea), one);
        setThreads(0);
        // One by one, backwards.
        const TrueArea area(*scene, g.kernel, g.options.slice, g.options.maxRadius);
        const AreaTable table(area, g.receivers);
        const NearestPhotons disc(*scene, g.receivers, g.map, g.options);
        const NearestPhotons exact(*scene, g.receivers, g.map, g.options, area, table);
        for (std::uint32_t i = 700; i-- > 0;) {
            Rgb e(0.0F);
            (trueArea ? exact : disc).estimate({&i, 1}, {&e, 1});
            ASSERT_EQ(e, one[i]) << "receiver " << i;
        }
        EXPECT_EQ(disc.name(), "nearest");
        EXPECT_EQ(exact.name(), "true_area");
    }
}

TEST(NearestPhotons, TheExactMapGivesTheSame) {
    const auto scene = room();
    const std::vector<Photon> photons = even(*scene, 3000, 1.0F, 42);
    std::mt19937 random(43);
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 200; ++i)
        points.push_back(receiverAt({100.0F * test::unit(random), 100.0F * test::unit(random), 0.0F}, up));
    Gathering tree(scene, points, photons);
    Gathering exact(scene, points, photons, maps::Search::Exact);
    for (const bool trueArea : {false, true}) {
        const auto a = tree.estimate(trueArea);
        const auto b = exact.estimate(trueArea);
        // The same photons, summed in another order.
        for (std::size_t i = 0; i < a.size(); ++i) EXPECT_FLOAT_EQ(a[i].x, b[i].x);
    }
}

} // namespace
} // namespace pie::gather
