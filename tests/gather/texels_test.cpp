#include "pie/gather/texel_light.h"
#include "pie/gather/texels.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace pie::gather {
namespace {

using test::SceneBuilder;
using test::SurfaceSampler;

std::shared_ptr<const scene::Scene> roomWithCrate() {
    SceneBuilder builder;
    builder.grey(0.5F);
    builder.room(Vec3(0.0F), Vec3(512, 384, 256));
    // A crate and a slope, whose faces are not along the axes.
    builder.quad(Vec3(100, 100, 64), Vec3(50, 20, 0), Vec3(-20, 50, 0));
    builder.quad(Vec3(300, 0, 0), Vec3(0, 384, 0), Vec3(-100, 0, 130));
    return builder.make();
}

double totalArea(const SurfaceTexels& texels, std::size_t level) {
    double sum = 0;
    for (const auto& texel : texels.texels(level)) sum += static_cast<double>(texel.area);
    return sum;
}

photons::Photon photonAt(const scene::Scene& scene, const Vec3& point, std::uint32_t triangle, const Rgb& flux) {
    photons::Photon photon;
    photon.position = point;
    photon.triangle = triangle;
    photon.direction = -scene.normals[triangle];
    photon.flux = flux;
    return photon;
}

TEST(SurfaceTexels, AreasOfEveryLevelAddUpToTheSurface) {
    const auto scene = roomWithCrate();
    for (const float edge : {7.0F, 32.0F, 64.0F, 1000.0F}) {
        const SurfaceTexels texels(*scene, {edge});
        for (std::size_t level = 0; level < texels.levels(); ++level)
            EXPECT_NEAR(totalArea(texels, level) / scene->area, 1.0, 1e-5) << edge << ", level " << level;
    }
}

TEST(SurfaceTexels, EveryPointOfASurfaceHasATexelAboutAsNearAsItIsLarge) {
    const auto scene = roomWithCrate();
    const SurfaceTexels texels(*scene, {32});
    const SurfaceSampler sample(*scene);
    std::mt19937 random(3);
    std::vector<std::uint32_t> met(texels.texels().size(), 0);
    constexpr int points = 200'000;
    for (int i = 0; i < points; ++i) {
        const auto [point, triangle] = sample(random);
        const std::uint32_t texel = texels.find(triangle, false, point);
        ASSERT_NE(texel, SurfaceTexels::none);
        ++met[texel];
        // A cell that joined its neighbour reaches two cells far; the diagonal of that is 1.5 √5 edges.
        EXPECT_LT(glm::length(texels.texels()[texel].centre - point), 32 * 3.4F);
    }
    // Hits are proportional to area: chi-square of independent draws, fixed seed; 5 sigma is one false alarm in 3.5
    // million.
    double chi = 0;
    for (std::size_t t = 0; t < met.size(); ++t) {
        const double expected = points * static_cast<double>(texels.texels()[t].area) / scene->area;
        chi += (met[t] - expected) * (met[t] - expected) / expected;
    }
    const auto freedom = static_cast<double>(met.size() - 1);
    EXPECT_LT(chi, freedom + 5 * std::sqrt(2 * freedom));
    EXPECT_GT(chi, freedom - 5 * std::sqrt(2 * freedom));
}

TEST(SurfaceTexels, PointsLieOnTheirTexel) {
    const auto scene = roomWithCrate();
    TexelOptions options{48};
    options.points = 6;
    const SurfaceTexels texels(*scene, options);
    ASSERT_EQ(texels.points().points.size(), 6 * texels.texels().size());
    std::size_t own = 0;
    for (std::size_t i = 0; i < texels.points().points.size(); ++i) {
        const scene::Receiver& point = texels.points().points[i];
        own += texels.near(point.position, point.normal) == i / 6 ? 1 : 0;
        EXPECT_NEAR(glm::length(point.normal), 1.0F, 1e-5F);
    }
    // `near` looks for the nearest centre, which at a texel's border may be the neighbour's.
    EXPECT_GT(own, texels.points().points.size() * 8 / 10);
}

TEST(SurfaceTexels, TheBackOfOneSidedSurfacesAndSkiesKeepNothing) {
    SceneBuilder builder;
    builder.grey(0.5F);
    scene::Material sky;
    sky.interaction = scene::Interaction::Sky;
    const std::uint32_t skyNumber = builder.material(sky);
    scene::Material cloth;
    cloth.twoSided = true;
    const std::uint32_t clothNumber = builder.material(cloth);
    builder.quad(Vec3(0.0F), Vec3(64, 0, 0), Vec3(0, 64, 0));
    builder.quad(Vec3(0, 0, 100), Vec3(64, 0, 0), Vec3(0, 64, 0), skyNumber);
    builder.quad(Vec3(0, 0, 50), Vec3(64, 0, 0), Vec3(0, 64, 0), clothNumber);
    const auto scene = builder.make();
    const SurfaceTexels texels(*scene, {16});
    EXPECT_NE(texels.find(0, false, Vec3(30, 20, 0)), SurfaceTexels::none);
    EXPECT_EQ(texels.find(0, true, Vec3(30, 20, 0)), SurfaceTexels::none);
    EXPECT_EQ(texels.find(2, false, Vec3(30, 20, 100)), SurfaceTexels::none);
    const std::uint32_t front = texels.find(4, false, Vec3(30, 20, 50));
    const std::uint32_t back = texels.find(4, true, Vec3(30, 20, 50));
    ASSERT_NE(front, SurfaceTexels::none);
    ASSERT_NE(back, SurfaceTexels::none);
    EXPECT_NE(front, back) << "light on one side of a cloth is not light on the other";
    EXPECT_NEAR(totalArea(texels, 0), 3 * 64 * 64, 1.0);
}

TEST(SurfaceTexels, ExtremeScenesHaveBoundedNumbersOfTexels) {
    for (const float size : {1e-3F, 1.0F, 1e7F})
        for (const float far : {0.0F, 1e6F}) {
            SceneBuilder builder;
            builder.room(Vec3(far * size), Vec3(far * size) + Vec3(size));
            const auto scene = builder.make();
            const SurfaceTexels texels(*scene);
            EXPECT_GT(texels.texels().size(), 0U);
            EXPECT_LE(texels.texels().size(), TexelOptions{}.maxTexels);
            for (const auto& texel : texels.texels()) {
                EXPECT_TRUE(std::isfinite(texel.area) && texel.area > 0.0F);
                ASSERT_TRUE(std::isfinite(texel.centre.x));
            }
        }
    const scene::Scene empty = scene::makeScene(std::span<const Vec3>(), std::span<const std::uint32_t>(), {});
    EXPECT_EQ(SurfaceTexels(empty).texels().size(), 0U);
    // Far too small an edge is doubled, not obeyed.
    SceneBuilder builder;
    builder.room(Vec3(0.0F), Vec3(4096));
    TexelOptions options{0.01F};
    options.maxTexels = 100'000;
    EXPECT_LE(SurfaceTexels(*builder.make(), options).texels().size(), 100'000U);
}

/// A frame of photons of unit power scattered over the room.
std::vector<photons::Photon> frame(const scene::Scene& scene, std::uint32_t seed, std::size_t count) {
    const SurfaceSampler sample(scene);
    std::mt19937 random(seed);
    std::vector<photons::Photon> photons;
    for (std::size_t i = 0; i < count; ++i) {
        const auto [point, triangle] = sample(random);
        photons.push_back(
            photonAt(scene, point, triangle, Rgb(1.0F, 0.3F, 1e-4F) * test::unit(random) / static_cast<float>(count)));
    }
    return photons;
}

// A hundred frames of photons in turns for ten million frames: what is left of them is nothing at all, where floats
// would have drifted. The sums are those of the last hundred frames at every time.
TEST(TexelLight, TenMillionFramesOfAddingAndRemovingLeaveExactlyNothing) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    constexpr std::size_t frames = 100'000; // sanitizers look at every step, not at the number of them
#else
    constexpr std::size_t frames = 10'000'000;
#endif
    SceneBuilder builder;
    builder.quad(Vec3(0.0F), Vec3(64, 0, 0), Vec3(0, 64, 0));
    const auto scene = builder.make();
    const SurfaceTexels texels(*scene, {64});
    TexelLight light(texels, 1.0, nullptr, true);
    std::vector<std::vector<photons::Photon>> pool;
    for (std::uint32_t f = 0; f < 16; ++f) pool.push_back(frame(*scene, f, 1));
    for (std::size_t f = 0; f < frames; ++f) {
        light.add(pool[f % pool.size()]);
        if (f >= 8) light.remove(pool[(f - 8) % pool.size()]);
    }
    EXPECT_EQ(light.still().parts(), 8 * PhotonSums::batches);
    EXPECT_FALSE(light.still().empty());
    for (std::size_t f = frames - 8; f < frames; ++f) light.remove(pool[f % pool.size()]);
    EXPECT_TRUE(light.still().empty());
    light.update();
    for (const auto& radiosity : light.radiosity()) EXPECT_EQ(radiosity.r, 0.0F);
}

TEST(TexelLight, FluxOverAreaTimesReflectance) {
    SceneBuilder builder;
    builder.grey(0.25F);
    builder.quad(Vec3(0.0F), Vec3(64, 0, 0), Vec3(0, 64, 0));
    const auto scene = builder.make();
    const SurfaceTexels texels(*scene, {100});
    ASSERT_EQ(texels.texels().size(), 1U);
    TexelLight light(texels, 2000.0, nullptr, false);
    const std::vector<photons::Photon> photons{photonAt(*scene, Vec3(10, 20, 0), 0, Rgb(300, 0, 1)),
                                               photonAt(*scene, Vec3(50, 20, 0), 0, Rgb(700, 0, 2))};
    light.add(photons);
    light.add({});
    light.update();
    // Two frames, the second without photons.
    EXPECT_NEAR(light.radiosity()[0].r, 0.25 * 0.5 * 1000 / 4096, 1e-6);
    EXPECT_EQ(light.radiosity()[0].g, 0.0F);
    EXPECT_NEAR(light.radiosity()[0].b, 0.25 * 0.5 * 3 / 4096, 1e-7);
    EXPECT_EQ(light.photons(0), 2U);
}

TEST(TexelLight, WhatIsNoNumberOrBeyondAllPowerIsLeftOut) {
    SceneBuilder builder;
    builder.quad(Vec3(0.0F), Vec3(64, 0, 0), Vec3(0, 64, 0));
    const auto scene = builder.make();
    const SurfaceTexels texels(*scene, {100});
    for (const double power : {0.0, 1e-30, 1.0, 1e30}) {
        TexelLight light(texels, power, nullptr, false);
        for (const float flux :
             {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 3e38F, 0.0F}) {
            const std::vector<photons::Photon> photons{photonAt(*scene, Vec3(10, 20, 0), 0, Rgb(flux))};
            light.add(photons);
        }
        light.update();
        EXPECT_TRUE(std::isfinite(light.radiosity()[0].r));
        EXPECT_GE(light.radiosity()[0].r, 0.0F);
    }
    // Very weak and very strong lights keep their proportions.
    for (const float power : {1e-30F, 1e30F}) {
        TexelLight light(texels, static_cast<double>(power), nullptr, false);
        const std::vector<photons::Photon> photons{photonAt(*scene, Vec3(10, 20, 0), 0, Rgb(power / 1000))};
        light.add(photons);
        light.update();
        EXPECT_NEAR(light.radiosity()[0].r / (0.5F * power / 1000 / 4096), 1.0F, 1e-5F);
    }
}

} // namespace
} // namespace pie::gather
