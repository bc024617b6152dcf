// Closed boxes have an exact answer: mean irradiance Φ / (A (1 − ρ)). What the gather adds to direct light is measured
// against it, at inner points, on edges and in corners, where nothing may be lost.

#include "pie/core/parallel.h"
#include "pie/gather/cached_gather.h"
#include "pie/photons/tracer.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <numbers>

namespace pie::gather {
namespace {

using test::all;
using test::receiverAt;
using test::SceneBuilder;

constexpr float side = 256;
constexpr float watts = 1e6F;
constexpr double area = 6.0 * side * side;

/// A cube lit from its middle, receivers in a grid over all faces.
struct Cube {
    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<intersect::Intersector> intersector;
    lights::LightSet lights;
    scene::Receivers receivers;
    std::unique_ptr<DirectLight> direct;
    std::unique_ptr<CachedGather> gather;

    explicit Cube(float rho, GatherOptions options = {}, bool shadowRays = true, int cells = 8, float power = watts) {
        SceneBuilder builder;
        builder.grey(rho);
        builder.room(Vec3(0.0F), Vec3(side));
        scene = builder.make();
        intersector = intersect::makeIntersector(intersect::Kind::Embree, *scene, {});
        lights::PointLight lamp;
        lamp.position = Vec3(0.5F * side);
        lamp.power = Rgb(power);
        lamp.falloff.minDistance = 0;
        lights = lights::LightSet({lamp}, scene);
        for (int face = 0; face < 6; ++face)
            for (int y = 0; y < cells; ++y)
                for (int x = 0; x < cells; ++x) {
                    Vec3 normal(0.0F);
                    normal[face / 2] = face % 2 == 0 ? 1.0F : -1.0F;
                    Vec3 p(0.0F);
                    p[face / 2] = face % 2 == 0 ? 0.0F : side;
                    p[(face / 2 + 1) % 3] = (static_cast<float>(x) + 0.5F) / static_cast<float>(cells) * side;
                    p[(face / 2 + 2) % 3] = (static_cast<float>(y) + 0.5F) / static_cast<float>(cells) * side;
                    receivers.points.push_back(receiverAt(p, normal));
                }
        if (shadowRays) direct = std::make_unique<DirectLight>(*scene, lights, *intersector, receivers);
        options.standardErrors = true;
        gather = std::make_unique<CachedGather>(*scene, lights, *intersector, receivers, direct.get(), options);
    }
    void trace(std::uint64_t frames, std::uint64_t count, unsigned depth = 100) const {
        photons::TracerOptions options;
        options.storeDirectLight = !direct;
        options.recursionDepth = depth;
        const photons::PhotonTracer tracer(*scene, lights, *intersector, options);
        for (std::uint64_t f = 0; f < frames; ++f) {
            std::vector<photons::Photon> photons;
            tracer.trace(1 + f * count, count, photons);
            gather->add(photons);
        }
        gather->update();
    }
    [[nodiscard]] std::vector<Rgb> light() const {
        std::vector<Rgb> light(receivers.points.size());
        gather->estimate(all(receivers), light);
        return light;
    }
    void finish() const { gather->refine(all(receivers), std::numeric_limits<std::uint64_t>::max()); }
    [[nodiscard]] double mean() const {
        double sum = 0;
        for (const Rgb& e : light()) sum += static_cast<double>(e.x);
        return sum / static_cast<double>(receivers.points.size());
    }
};

// The grid integrates the smooth direct light to 0.1 %; the gather's own noise is 256 rays × 864 receivers. Direct
// light from photons is that of whole texels, which the grid of receivers meets unevenly.
TEST(CachedGather, FindsTheExactMeanOfAClosedCube) {
    for (const float rho : {0.2F, 0.5F, 0.8F})
        for (const bool shadowRays : {true, false}) {
            const Cube cube(rho, {}, shadowRays, 12);
            cube.trace(10, 40'000);
            cube.finish();
            EXPECT_NEAR(cube.mean() / (static_cast<double>(watts) / (area * (1.0 - static_cast<double>(rho)))), 1.0,
                        shadowRays ? 0.005 : 0.01)
                << rho << (shadowRays ? ", shadow rays" : ", photons alone");
        }
}

// Bounces of a closed cube are a geometric series: Φ/A (1 + ρ + ρ² + …).
TEST(CachedGather, LightStopsAfterAsManyReflectionsAsAreAsked) {
    constexpr double rho = 0.5;
    for (const unsigned reflections : {0U, 1U}) {
        GatherOptions options;
        options.reflections = reflections;
        const Cube cube(static_cast<float>(rho), options, true, 12);
        cube.trace(1, 10'000, 0);
        cube.finish();
        for (const std::uint32_t r : all(cube.receivers)) EXPECT_TRUE(cube.gather->finished(r));
        EXPECT_NEAR(cube.mean() / (static_cast<double>(watts) / area), reflections == 0 ? 1.0 : 1.0 + rho, 0.01);
        EXPECT_EQ(cube.gather->raysTraced() == 0, reflections == 0);
    }
}

TEST(CachedGather, EveryStageIsARoughAnswerAlready) {
    const Cube cube(0.5F);
    cube.trace(10, 20'000);
    const double exact = static_cast<double>(watts) / (area * 0.5);
    const std::vector<std::uint32_t> which = all(cube.receivers);
    // Nothing refined: photons and direct light of texels here and there.
    EXPECT_NEAR(cube.mean() / exact, 1.0, 0.05);
    int rounds = 0;
    while (cube.gather->refine(which, 2000) > 0) {
        ASSERT_LT(++rounds, 1000);
        EXPECT_NEAR(cube.mean() / exact, 1.0, 0.05) << rounds;
    }
    EXPECT_GT(rounds, 5);
    for (const std::uint32_t r : which) EXPECT_TRUE(cube.gather->finished(r));
}

// What a receiver ends with does not depend on what else is asked, in which order, in how many steps, by how many
// threads.
TEST(CachedGather, SameBitsInAnyOrderAndOnAnyNumberOfThreads) {
    std::vector<Rgb> first;
    for (const unsigned threadCount : {1U, 2U, 3U}) {
        setThreads(threadCount);
        const Cube cube(0.5F);
        std::vector<std::uint32_t> which = all(cube.receivers);
        if (threadCount == 2) std::reverse(which.begin(), which.end());
        if (threadCount == 3) {
            cube.gather->refine(std::span(which).first(7), 1000);
            cube.trace(2, 5000);
            while (cube.gather->refine(which, 3000) > 0) {}
        } else {
            cube.trace(2, 5000);
            cube.finish();
        }
        const std::vector<Rgb> light = cube.light();
        if (first.empty()) first = light;
        EXPECT_EQ(std::memcmp(first.data(), light.data(), light.size() * sizeof(Rgb)), 0) << threadCount;
    }
    setThreads(0);
}

TEST(CachedGather, NothingIsLostAtEdgesAndCorners) {
    Cube cube(0.5F, {}, true, 1);
    // Vertices of the cube's floor: an edge and a corner, inset by a unit as makeReceivers does.
    scene::Receivers rim;
    for (const Vec3& p : {Vec3(0, 128, 0), Vec3(0, 0, 0)}) {
        scene::Receiver receiver = receiverAt(p, Vec3(0, 0, 1));
        receiver.inset = glm::clamp(p, Vec3(1, 1, 0), Vec3(255, 255, 256));
        rim.points.push_back(receiver);
    }
    GatherOptions options;
    options.rays = 4096;
    DirectLight direct(*cube.scene, cube.lights, *cube.intersector, rim);
    CachedGather gather(*cube.scene, cube.lights, *cube.intersector, rim, &direct, options);
    // The truth by refining texels: an edge of 8 against the default.
    GatherOptions fineOptions = options;
    fineOptions.texels.edge = 8;
    CachedGather fine(*cube.scene, cube.lights, *cube.intersector, rim, &direct, fineOptions);
    photons::TracerOptions tracing;
    tracing.recursionDepth = 100;
    const photons::PhotonTracer tracer(*cube.scene, cube.lights, *cube.intersector, tracing);
    for (std::uint64_t f = 0; f < 10; ++f) {
        std::vector<photons::Photon> photons;
        tracer.trace(1 + f * 100'000, 100'000, photons);
        gather.add(photons);
        fine.add(photons);
    }
    const std::vector<std::uint32_t> which = all(rim);
    gather.refine(which, std::numeric_limits<std::uint64_t>::max());
    fine.refine(which, std::numeric_limits<std::uint64_t>::max());
    std::vector<Rgb> coarse(2);
    std::vector<Rgb> exact(2);
    gather.estimate(which, coarse);
    fine.estimate(which, exact);
    for (int i = 0; i < 2; ++i) {
        EXPECT_NEAR(coarse[i].x / exact[i].x, 1.0F, 0.03F) << i;
        // Direct light alone is what shadow rays see; the walls beside an edge add about as much again.
        EXPECT_GT(exact[i].x, static_cast<float>(0.5 * watts / (area * 0.5)));
    }
}

// The share of errors within one standard error, against the same gather with many times the photons and rays. Binomial
// with 864 receivers: ±5 points are three sigma; neighbours share texels, so their errors are not independent.
TEST(CachedGather, StandardErrorsAreHonest) {
    GatherOptions precise;
    precise.rays = 4096;
    precise.texelRays = 1024;
    precise.texels.points = 8;
    Cube reference(0.6F, precise, true, 12);
    reference.trace(10, 100'000);
    reference.finish();
    const std::vector<Rgb> truth = reference.light();
    double share = 0;
    constexpr int trials = 3;
    for (int trial = 0; trial < trials; ++trial) {
        GatherOptions options;
        options.rays = 256;
        options.seed = static_cast<std::uint64_t>(trial) + 1;
        Cube cube(0.6F, options, true, 12);
        photons::TracerOptions tracing;
        tracing.recursionDepth = 100;
        tracing.seed = options.seed;
        // Independent photons: the batches of a sequence are not, so that what it gains goes unseen.
        tracing.lightDistribution = tracing.diffuseDistribution = sampling::Distribution::Explicit;
        const photons::PhotonTracer tracer(*cube.scene, cube.lights, *cube.intersector, tracing);
        std::vector<photons::Photon> photons;
        tracer.trace(0, 10'000, photons);
        cube.gather->add(photons);
        cube.finish();
        const std::vector<std::uint32_t> which = all(cube.receivers);
        std::vector<Estimate> estimates(which.size());
        cube.gather->explain(which, estimates);
        for (const Estimate& e : estimates) EXPECT_GT(e.standardError, 0.0F);
        share += test::shareWithin(estimates, truth) / trials;
    }
    RecordProperty("share", std::to_string(share));
    EXPECT_NEAR(share, 0.68, 0.05);
}

TEST(CachedGather, ExtremesStayFiniteAndNotNegative) {
    for (const float power : {0.0F, 1e-30F, 1e30F})
        for (const float rho : {0.0F, 1.0F})
            for (const std::uint64_t photons : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1000}}) {
                GatherOptions options;
                options.rays = 2;
                const Cube cube(rho, options, true, 2, power);
                cube.trace(1, photons);
                cube.finish();
                std::vector<Estimate> estimates(cube.receivers.points.size());
                cube.gather->explain(all(cube.receivers), estimates);
                for (const Estimate& e : estimates) {
                    EXPECT_TRUE(std::isfinite(e.irradiance.x) && e.irradiance.x >= 0.0F) << power << ' ' << rho;
                    EXPECT_TRUE(std::isfinite(e.standardError) && e.standardError >= 0.0F);
                }
                if (power > 0.0F) continue;
                for (const Rgb& e : cube.light()) EXPECT_EQ(e, Rgb(0.0F));
            }
}

TEST(CachedGather, ASceneWithoutSurfaceGivesWhatLightsGive) {
    const scene::Scene scene = scene::makeScene(std::span<const Vec3>(), std::span<const std::uint32_t>(), {});
    const auto shared = std::make_shared<const scene::Scene>(scene);
    lights::PointLight lamp;
    lamp.power = Rgb(100.0F);
    lamp.falloff.minDistance = 0;
    const lights::LightSet lights({lamp}, shared);
    const auto intersector = intersect::makeIntersector(intersect::Kind::Embree, *shared, {});
    const scene::Receivers receivers = test::receiversAt({receiverAt(Vec3(0, 0, -10), Vec3(0, 0, 1))});
    DirectLight direct(*shared, lights, *intersector, receivers);
    CachedGather gather(*shared, lights, *intersector, receivers, &direct, {});
    gather.add({});
    const std::vector<std::uint32_t> which{0};
    gather.refine(which, 1000);
    while (gather.refine(which, 1000) > 0) {}
    std::vector<Rgb> light(1);
    gather.estimate(which, light);
    EXPECT_NEAR(light[0].x, 100 / (4 * std::numbers::pi * 100), 1e-4);
}

} // namespace
} // namespace pie::gather
