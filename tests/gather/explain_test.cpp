// What an estimate says about its own error, against errors that are known.

#include "tests/gather/gathering.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pie::gather {
namespace {

using photons::Photon;
using test::all;
using test::receiverAt;
using test::receiversAt;

const Vec3 up(0.0F, 0.0F, 1.0F);
constexpr float pi = 3.14159265F;

/// A floor, receivers on it, and frames of photons thrown at random: independent receivers, of which the answer is
/// known.
struct Floor {
    std::shared_ptr<const scene::Scene> scene;
    scene::Receivers receivers;
    maps::RealtimeMap map;
    NearestOptions options;

    Floor(std::size_t frames, std::size_t photonsPerFrame, bool bright) : map(frames) {
        test::SceneBuilder builder;
        builder.quad(Vec3(0.0F), {1000.0F, 0.0F, 0.0F}, {0.0F, 1000.0F, 0.0F});
        scene = builder.make();
        std::vector<scene::Receiver> points;
        for (int y = 1; y < 20; ++y)
            for (int x = 1; x < 20; ++x)
                points.push_back(receiverAt({50.0F * static_cast<float>(x), 50.0F * static_cast<float>(y), 0.0F}, up));
        receivers = receiversAt(points);
        std::mt19937 random(77);
        for (std::size_t frame = 0; frame < frames; ++frame) {
            std::vector<Photon> photons;
            for (std::size_t i = 0; i < photonsPerFrame; ++i) {
                Vec3 p(1000.0F * test::unit(random), 1000.0F * test::unit(random), 0.0F);
                const float weight = bright ? truth(p) : 1.0F;
                photons.push_back(test::photonOn(*scene, 0, p, weight * 1e6F / static_cast<float>(photonsPerFrame)));
                photons.back().flux = Rgb(photons.back().flux.x);
            }
            map.replaceOldest(std::move(photons));
        }
        map.rebuild();
        options.maxCount = 60;
        options.maxRadius = 24;
    }
    /// Bright every 50 units, where receivers are.
    static float truth(const Vec3& p) {
        return 1.0F + 0.5F * std::cos(2 * pi * p.x / 50.0F) * std::cos(2 * pi * p.y / 50.0F);
    }

    [[nodiscard]] std::vector<Estimate> explain() const {
        const std::vector<std::uint32_t> which = all(receivers);
        std::vector<Estimate> estimates(which.size());
        NearestPhotons(*scene, receivers, map, options).explain(which, estimates);
        return estimates;
    }
};

double shareWithin(const std::vector<Estimate>& estimates, double truth) {
    double within = 0;
    for (const Estimate& e : estimates)
        if (std::abs(static_cast<double>(e.irradiance.x) - truth) <= static_cast<double>(e.standardError)) ++within;
    return within / static_cast<double>(estimates.size());
}

// 361 independent receivers: the share has a standard deviation of 2.5 %. With 10 batches 66 % are expected within one
// error (Student), with 40 68 %. Bounds at 3.5 sigma: one false alarm in 2,000.
TEST(Explain, TwoThirdsAreWithinOneStandardError) {
    for (const std::size_t frames : {10U, 40U}) {
        Floor floor(frames, 400'000 / frames, false);
        for (const RadiusRule radius : {RadiusRule::Nearest, RadiusRule::Fixed})
            for (const AreaEstimate area : {AreaEstimate::Disc, AreaEstimate::Hull, AreaEstimate::True})
                for (const Kernel kernel : {Kernel::Constant, Kernel::Epanechnikov}) {
                    floor.options.radius = radius;
                    floor.options.area = area;
                    floor.options.kernel = kernel;
                    floor.options.maxRadius = radius == RadiusRule::Fixed ? 8.0F : 24.0F;
                    EXPECT_NEAR(shareWithin(floor.explain(), 1.0), 0.67, 0.09)
                        << frames << " frames, area " << int(area) << ", kernel " << int(kernel) << ", radius "
                        << int(radius);
                }
    }
}

TEST(Explain, OneFrameTakesPhotonsForIndependent) {
    Floor floor(1, 400'000, false);
    EXPECT_NEAR(shareWithin(floor.explain(), 1.0), 0.68, 0.09);
}

TEST(Explain, SaysHowManyPhotonsAndHowFar) {
    Floor floor(10, 40'000, false);
    for (const Estimate& e : floor.explain()) {
        EXPECT_EQ(e.photons, 60U);
        EXPECT_NEAR(e.radius, std::sqrt(60.0F / (pi * 0.4F)), 3.5F);
    }
    floor.options.maxCount = 0;
    for (const Estimate& e : floor.explain()) {
        EXPECT_EQ(e.photons, 0U);
        EXPECT_EQ(e.standardError, 0.0F);
        EXPECT_EQ(e.irradiance, Rgb(0.0F));
    }
}

TEST(Explain, BiasIsSeenWhereItDominates) {
    Floor floor(10, 100'000, true);
    floor.options.radius = RadiusRule::Fixed;
    floor.options.maxRadius = 12;
    const std::vector<Estimate> estimates = floor.explain();
    double error = 0;
    double bias = 0;
    double noise = 0;
    for (const Estimate& e : estimates) {
        error += static_cast<double>(1.5F - e.irradiance.x) / static_cast<double>(estimates.size());
        bias += static_cast<double>(e.bias) / static_cast<double>(estimates.size());
        noise += static_cast<double>(e.standardError) / static_cast<double>(estimates.size());
    }
    EXPECT_GT(error, 3 * noise) << "bias dominates here";
    EXPECT_NEAR(bias / error, 0.85, 0.15) << "the next order of the cosine is missed";
    // Where the light is even, what is called bias is at most noise.
    Floor even(10, 100'000, false);
    even.options = floor.options;
    double falseBias = 0;
    for (const Estimate& e : even.explain())
        falseBias += static_cast<double>(e.bias) / static_cast<double>(estimates.size());
    EXPECT_LT(falseBias, 1.5 * noise);
}

TEST(Explain, TheIrradianceIsThatOfEstimate) {
    Floor floor(5, 8'000, true);
    const std::vector<std::uint32_t> which = all(floor.receivers);
    for (const AreaEstimate area : {AreaEstimate::Disc, AreaEstimate::Box, AreaEstimate::OrientedBox,
                                    AreaEstimate::Ellipse, AreaEstimate::Hull, AreaEstimate::True}) {
        floor.options.area = area;
        std::vector<Rgb> irradiance(which.size());
        NearestPhotons(*floor.scene, floor.receivers, floor.map, floor.options).estimate(which, irradiance);
        const std::vector<Estimate> estimates = floor.explain();
        for (std::size_t i = 0; i < which.size(); ++i) EXPECT_EQ(estimates[i].irradiance, irradiance[i]);
    }
}

} // namespace
} // namespace pie::gather
