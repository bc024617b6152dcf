// A lamp close under the ceiling: most of the light that comes back from anywhere comes from a few texels above it.

#include "pie/gather/bright_texels.h"
#include "pie/gather/cached_gather.h"
#include "pie/photons/tracer.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

namespace pie::gather {
namespace {

using test::all;
using test::receiverAt;
using test::SceneBuilder;

struct LitCeiling {
    static constexpr float side = 256;
    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<intersect::Intersector> intersector;
    lights::LightSet lights;
    scene::Receivers receivers; ///< of the floor, and of a pane that stands in the room
    std::unique_ptr<DirectLight> direct;

    explicit LitCeiling(float below) {
        SceneBuilder builder;
        builder.grey(0.5F);
        builder.room(Vec3(0.0F), Vec3(side));
        scene::Material pane;
        pane.reflectance = Rgb(0.5F);
        pane.twoSided = true;
        const std::uint32_t glass = builder.material(pane);
        builder.quad(Vec3(40, 60, 20), Vec3(60, 30, 0), Vec3(0, 0, 80), glass);
        scene = builder.make();
        intersector = intersect::makeIntersector(intersect::Kind::Embree, *scene, {});
        lights::PointLight lamp;
        lamp.position = Vec3(0.5F * side, 0.5F * side, side - below);
        lamp.power = Rgb(1e6F, 5e5F, 1e5F);
        lamp.falloff.minDistance = 0;
        lights = lights::LightSet({lamp}, scene);
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 12; ++x)
                receivers.points.push_back(
                    receiverAt(Vec3(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, 0.0F) * (side / 12),
                               Vec3(0, 0, 1)));
        for (int i = 1; i < 8; ++i) {
            scene::Receiver receiver = receiverAt(Vec3(40, 60, 20) + static_cast<float>(i) * Vec3(7.5F, 3.75F, 8.0F),
                                                  glm::normalize(Vec3(30, -60, 0)));
            receiver.twoSided = true;
            receivers.points.push_back(receiver);
        }
        direct = std::make_unique<DirectLight>(*scene, lights, *intersector, receivers);
    }
    [[nodiscard]] std::vector<photons::Photon> photons(bool firstHits, std::uint64_t count) const {
        photons::TracerOptions options;
        options.storeDirectLight = firstHits;
        options.recursionDepth = firstHits ? 0 : 100;
        std::vector<photons::Photon> result;
        photons::PhotonTracer(*scene, lights, *intersector, options).trace(0, count, result);
        return result;
    }
    [[nodiscard]] std::unique_ptr<CachedGather> gather(unsigned rays, bool aim, std::uint64_t seed = 0) const {
        GatherOptions options;
        options.rays = rays;
        options.seed = seed;
        options.standardErrors = true;
        auto result = std::make_unique<CachedGather>(*scene, lights, *intersector, receivers, direct.get(), options);
        if (aim) result->aim(photons(true, 20'000));
        result->add(photons(false, 100'000));
        result->refine(all(receivers), std::numeric_limits<std::uint64_t>::max());
        return result;
    }
    [[nodiscard]] std::vector<Rgb> light(const CachedGather& gather) const {
        std::vector<Rgb> light(receivers.points.size());
        gather.estimate(all(receivers), light);
        return light;
    }
};

double meanRatio(const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<double>(meanChannel(a[i]) / meanChannel(b[i]));
    return sum / static_cast<double>(a.size());
}

double rmsError(const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += std::pow(static_cast<double>(meanChannel(a[i]) / meanChannel(b[i])) - 1, 2);
    return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(BrightTexels, AreThoseAroundTheLamp) {
    const LitCeiling room(20);
    const SurfaceTexels texels(*room.scene);
    BrightTexels bright(texels);
    EXPECT_TRUE(bright.empty());
    bright.choose(room.photons(true, 20'000));
    ASSERT_FALSE(bright.empty());
    for (std::size_t i = 0; i < bright.size(); ++i) {
        const Vec3 centre = texels.texels()[bright.texel(i)].centre;
        EXPECT_GT(centre.z, 255.0F);
        EXPECT_LT(glm::length(Vec2(centre) - Vec2(128.0F)), 70.0F);
    }
    std::vector<float> sums;
    const scene::Receiver floor = receiverAt(Vec3(30, 40, 0), Vec3(0, 0, 1));
    const float all = bright.chances(floor, sums);
    float sum = 0;
    for (std::size_t i = 0; i < bright.size(); ++i) {
        sum += bright.chance(floor, bright.texel(i));
        EXPECT_EQ(sums[i], sum);
    }
    EXPECT_EQ(all, sum);
    EXPECT_EQ(bright.chance(floor, texels.near(Vec3(20, 20, 0), Vec3(0, 0, 1))), 0.0F);
}

TEST(BrightTexels, ARoomLitEvenlyHasNoneAndPaysForNone) {
    const LitCeiling room(128);
    const SurfaceTexels texels(*room.scene);
    BrightTexels bright(texels);
    bright.choose(room.photons(true, 20'000));
    EXPECT_TRUE(bright.empty());
    EXPECT_EQ(bright.bytes(), 0U);
    EXPECT_EQ(room.gather(64, true)->raysTraced(), room.gather(64, false)->raysTraced());
}

// The truth has 32 times the rays, none of them aimed. 151 receivers, whose errors of 256 rays are 5 % each: the mean
// is known to 0.4 %, that of aimed ones to a third of it.
TEST(BrightTexels, AimedRaysFindTheSameLightWithAFractionOfTheNoise) {
    const LitCeiling room(20);
    const std::vector<Rgb> truth = room.light(*room.gather(8'192, false));
    const std::vector<Rgb> plain = room.light(*room.gather(256, false));
    const std::vector<Rgb> aimed = room.light(*room.gather(256, true));
    EXPECT_NEAR(meanRatio(aimed, truth), 1.0, 0.005);
    EXPECT_LT(rmsError(aimed, truth), 0.4 * rmsError(plain, truth));
    RecordProperty("plain", std::to_string(rmsError(plain, truth)));
    RecordProperty("aimed", std::to_string(rmsError(aimed, truth)));
}

TEST(BrightTexels, StandardErrorsKnowOfAimedRays) {
    const LitCeiling room(20);
    const std::vector<Rgb> truth = room.light(*room.gather(8'192, false));
    double share = 0;
    constexpr int trials = 4;
    for (std::uint64_t seed = 1; seed <= trials; ++seed) {
        const auto gather = room.gather(64, true, seed);
        std::vector<Estimate> estimates(room.receivers.points.size());
        gather->explain(all(room.receivers), estimates);
        share += test::shareWithin(estimates, truth) / trials;
    }
    RecordProperty("share", std::to_string(share));
    EXPECT_NEAR(share, 0.68, 0.08);
}

} // namespace
} // namespace pie::gather
