// Paths: purity, order, what is stored where.

#include "pie/core/parallel.h"
#include "tests/photons/traced.h"
#include "tests/sampling/distributions.h"
#include "tests/sampling/statistics.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>

namespace pie::photons {
namespace {

using test::Traced;

bool sameBits(const Photon& a, const Photon& b) {
    return a.position == b.position && a.direction == b.direction && a.flux == b.flux && a.triangle == b.triangle &&
           a.id == b.id && a.bounce == b.bounce;
}

/// A room with everything in it: colours, a mirror-image of nothing, sky, a two-sided panel, a filter grating.
std::shared_ptr<const scene::Scene> everything() {
    test::RoomBuilder room;
    const auto grey = room.material(test::opaque(Rgb(0.6F)));
    const auto red = room.material(test::opaque(Rgb(0.9F, 0.2F, 0.1F)));
    const auto open = room.material(test::sky());
    auto panel = test::opaque(Rgb(0.5F, 0.7F, 0.3F));
    panel.twoSided = true;
    const auto both = room.material(panel);
    auto glass = test::opaque(Rgb(0.3F));
    glass.interaction = scene::Interaction::Filter;
    glass.twoSided = true;
    auto image = std::make_shared<level::Image>();
    image->width = image->height = 1;
    image->hasAlpha = true;
    image->pixels = {Rgba8(255, 128, 0, 100)};
    glass.filter = image;
    const auto grating = room.material(glass);
    room.inside({0, 0, 0}, {256, 256, 128}, {grey, open, red, grey, grey, red});
    room.quad({60, 60, 40}, {160, 60, 40}, {160, 160, 70}, {60, 160, 70}, both);
    room.quad({200, 20, 10}, {200, 200, 10}, {200, 200, 100}, {200, 20, 100}, grating);
    return room.build();
}
std::vector<lights::Light> manyLights() {
    return {test::lamp({100, 100, 100}, Rgb(1e5F, 8e4F, 6e4F)),
            lights::SunLight{glm::normalize(Vec3(0.3F, 0.2F, 1.0F)), Rgb(20.0F), 0.01F},
            lights::makeAreaLight({{30, 30, 127}, {30, 90, 127}, {90, 90, 127}, {90, 30, 127}}, Rgb(50.0F)),
            lights::SpotLight{{230, 230, 100}, glm::normalize(Vec3(-1, -1, -1)), Rgb(2e5F), 0.6F, 32, {}}};
}

std::vector<TracerOptions> allOptions() {
    auto seeded = test::roulette(true, 6);
    seeded.seed = 12345;
    std::vector<TracerOptions> all{test::roulette(true, 8), test::roulette(false, 8), test::splitting(5, true, 3),
                                   test::splitting(3, false, 4), seeded};
    for (const sampling::Distribution distribution : test::allDistributions)
        for (TracerOptions options : {test::roulette(true, 8), test::splitting(4, false, 3)}) {
            options.lightDistribution = options.diffuseDistribution = distribution;
            options.photonsPerFrame = 700; // sets begin and end within batches
            all.push_back(options);
        }
    return all;
}
/// Indices to trace: a photon that splits is a hundred that do not.
std::uint64_t share(std::uint64_t count, const TracerOptions& options) {
    return options.scattering == TracerOptions::Scattering::Splitting ? count / 20 : count;
}

/// The same index gives the same path alone, in a batch, and in a batch that starts elsewhere.
TEST(Tracer, APhotonIsAFunctionOfItsIndex) {
    for (const TracerOptions& options : allOptions()) {
        Traced traced(everything(), manyLights(), options);
        const std::uint64_t count = share(5000, options);
        const auto batch = traced.trace(1000, count);
        std::size_t at = 0;
        for (std::uint64_t i = 0; i < count; ++i) {
            for (const Photon& photon : traced.trace(1000 + i, 1)) {
                ASSERT_LT(at, batch.size());
                const Photon& same = batch[at++];
                // Its share of a frame of one is `count` times that of this frame.
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(photon.flux[c] / static_cast<float>(count), same.flux[c],
                                2e-6F * std::abs(same.flux[c]) + 1e-30F);
                ASSERT_EQ(photon.position, same.position);
                ASSERT_EQ(photon.direction, same.direction);
                ASSERT_EQ(photon.triangle, same.triangle);
                ASSERT_EQ(photon.bounce, same.bounce);
            }
        }
        EXPECT_EQ(at, batch.size());
    }
}

TEST(Tracer, ThreadsDoNotChangeABit) {
    for (const TracerOptions& options : allOptions()) {
        Traced traced(everything(), manyLights(), options);
        const std::uint64_t count = share(20'000, options);
        setThreads(1);
        const auto one = traced.trace(7, count);
        const TraceCounts books = traced.counts;
        for (const unsigned threads : {2U, 5U}) {
            setThreads(threads);
            const auto many = traced.trace(7, count);
            ASSERT_EQ(one.size(), many.size());
            for (std::size_t i = 0; i < one.size(); ++i) ASSERT_TRUE(sameBits(one[i], many[i])) << i;
            for (int c = 0; c < 3; ++c) {
                EXPECT_EQ(std::bit_cast<std::uint64_t>(books.emittedFlux[c]),
                          std::bit_cast<std::uint64_t>(traced.counts.emittedFlux[c]));
                EXPECT_EQ(std::bit_cast<std::uint64_t>(books.absorbedFlux[c]),
                          std::bit_cast<std::uint64_t>(traced.counts.absorbedFlux[c]));
            }
        }
        setThreads(0);
    }
}

TEST(Tracer, AppendsInIndexOrderAndNumbersFromZero) {
    Traced traced(everything(), manyLights(), test::roulette(true, 5));
    std::vector<Photon> out(3);
    out[2].id = 77;
    const TraceCounts counts = traced.tracer().trace(0, 3000, out);
    ASSERT_EQ(out.size(), 3 + counts.stored);
    EXPECT_EQ(out[2].id, 77U);
    for (std::size_t i = 3; i < out.size(); ++i) ASSERT_EQ(out[i].id, i - 3);
    // Bounces rise within a path and fall back where the next begins.
    EXPECT_EQ(counts.emitted, 3000U);
    std::size_t starts = 0;
    for (std::size_t i = 3; i < out.size(); ++i)
        if (out[i].bounce == 0)
            ++starts;
        else
            ASSERT_GE(static_cast<int>(out[i].bounce),
                      static_cast<int>(i > 3 && out[i - 1].bounce < out[i].bounce ? out[i - 1].bounce + 1 : 1));
    EXPECT_GT(starts, 1000U);
}

TEST(Tracer, PartsOfAFrameAreTheFrame) {
    const test::Traced traced(test::furnace(Rgb(0.5F)), {test::lamp(Vec3(50), Rgb(1000))}, test::roulette(true, 5));
    std::vector<Photon> whole;
    traced.tracer().trace(100, 1600, whole);
    std::vector<Photon> parts;
    constexpr std::array<std::uint64_t, 4> bounds{0, 100, 1100, 1600};
    for (std::size_t i = 0; i + 1 < bounds.size(); ++i)
        traced.tracer().trace(100 + bounds[i], bounds[i + 1] - bounds[i], 1600, parts);
    ASSERT_EQ(parts.size(), whole.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
        EXPECT_EQ(parts[i].position, whole[i].position);
        EXPECT_EQ(parts[i].flux, whole[i].flux);
    }
}

// What an edit of one light takes back and what it leaves are, together, what was there.
TEST(Tracer, MutedLightsLeaveTheOthersAsTheyWere) {
    const auto scene = test::furnace(Rgb(0.5F));
    const std::vector<lights::Light> lights{test::lamp(Vec3(20), Rgb(1000, 0, 0)), test::lamp(Vec3(80), Rgb(0, 700, 0)),
                                            test::lamp(Vec3(50), Rgb(0, 0, 30))};
    const auto embree = intersect::makeIntersector(intersect::Kind::Embree, *scene, {});
    const auto photons = [&](const lights::LightSet& set) {
        std::vector<Photon> out;
        const TraceCounts counts = PhotonTracer(*scene, set, *embree, test::roulette(true, 5)).trace(0, 3000, out);
        EXPECT_EQ(counts.emitted, 3000U);
        return out;
    };
    lights::LightSet set(lights, scene);
    const std::vector<Photon> all = photons(set);
    EXPECT_FALSE(set.muted(1));
    set.mute(1);
    EXPECT_TRUE(set.muted(1));
    const std::vector<Photon> others = photons(set);
    set.muteAllBut(1);
    EXPECT_TRUE(set.muted(0) && set.muted(2) && !set.muted(1));
    const std::vector<Photon> own = photons(set);
    EXPECT_GT(own.size(), 500U);
    ASSERT_EQ(own.size() + others.size(), all.size());
    std::size_t a = 0;
    std::size_t b = 0;
    for (const Photon& photon : all) {
        const Photon& half = photon.flux.y > 0.0F ? own[a++] : others[b++];
        EXPECT_EQ(half.position, photon.position);
        EXPECT_EQ(half.flux, photon.flux);
    }
}

TEST(Tracer, DirectLightIsStoredOnlyIfWanted) {
    Traced with(everything(), manyLights(), test::roulette(true, 4));
    Traced without(everything(), manyLights(), test::roulette(false, 4));
    std::size_t direct = 0;
    for (const Photon& p : with.trace(0, 4000)) direct += p.bounce == 0 ? 1 : 0;
    EXPECT_GT(direct, 2000U);
    const auto indirect = without.trace(0, 4000);
    EXPECT_GT(indirect.size(), 1000U);
    for (const Photon& p : indirect) ASSERT_GE(p.bounce, 1);
}

TEST(Tracer, RecursionDepthBoundsThePath) {
    for (const unsigned depth : {0U, 1U, 3U}) {
        Traced traced(test::furnace(Rgb(1.0F)), {test::lamp(Vec3(50.0F), Rgb(1000.0F))}, test::roulette(true, depth));
        const auto photons = traced.trace(0, 500);
        EXPECT_EQ(photons.size(), 500 * (depth + 1)) << "nothing is absorbed";
        EXPECT_EQ(traced.counts.rays, 500 * (depth + 1));
        EXPECT_EQ(traced.counts.cut, 500U);
        for (const Photon& p : photons) EXPECT_LE(p.bounce, depth);
    }
}

/// Fig 5.3: every hit sends on n photons with 1/n of the power; at most maxPathsPerPhoton of them.
TEST(Tracer, SplittingIsThePapersTree) {
    Traced traced(test::furnace(Rgb(0.5F)), {test::lamp(Vec3(50.0F), Rgb(1000.0F))}, test::splitting(4, true, 3));
    const auto photons = traced.trace(0, 10);
    ASSERT_EQ(photons.size(), 10U * (1 + 4 + 16 + 64));
    double power = 1000.0 / 10;
    std::size_t at = 0;
    for (std::size_t bounce = 0, width = 1; bounce < 4; ++bounce, width *= 4, power /= 8)
        for (std::size_t i = 0; i < width; ++i, ++at) {
            EXPECT_EQ(photons[at].bounce, bounce);
            EXPECT_NEAR(photons[at].flux.x / power, 1.0, 1e-5);
        }
}

TEST(Tracer, SplittingHasABound) {
    Traced traced(test::furnace(Rgb(1.0F)), {test::lamp(Vec3(50.0F), Rgb(1000.0F))}, test::splitting(36, false, 5));
    const auto photons = traced.trace(3, 2);
    EXPECT_EQ(photons.size(), 2U * (36 + 4 * 36 * 36));
    EXPECT_LE(traced.counts.rays, 2ULL * 5 * maxPathsPerPhoton);
    Traced wide(test::furnace(Rgb(1.0F)), {test::lamp(Vec3(50.0F), Rgb(1000.0F))},
                test::splitting(1'000'000, false, 2));
    EXPECT_EQ(wide.trace(0, 1).size(), 2U * maxPathsPerPhoton);
    Traced none(test::furnace(Rgb(1.0F)), {test::lamp(Vec3(50.0F), Rgb(1000.0F))}, test::splitting(0, false, 2));
    EXPECT_EQ(none.trace(0, 1).size(), 2U) << "counts as 1";
}

/// The children of a hit are stratified: much better spread than random directions.
TEST(Tracer, ChildrenOfAHitAreStratified) {
    constexpr unsigned children = 64;
    Traced traced(test::furnace(Rgb(0.5F)), {test::lamp(Vec3(50.0F), Rgb(1000.0F))},
                  test::splitting(children, true, 1));
    double ratio = 0.0;
    for (std::uint64_t i = 0; i < 50; ++i) {
        const auto photons = traced.trace(i, 1);
        ASSERT_EQ(photons.size(), 1U + children);
        const Frame frame(traced.scene().normals[photons[0].triangle]);
        std::vector<Vec2> points;
        for (std::size_t k = 1; k < photons.size(); ++k) {
            // Azimuth and squared sine: uniform for a cosine distribution.
            const Vec3 local(glm::dot(photons[k].direction, frame.tangent),
                             glm::dot(photons[k].direction, frame.bitangent),
                             glm::dot(photons[k].direction, frame.normal));
            EXPECT_GE(local.z, -1e-6F);
            points.emplace_back(local.x * local.x + local.y * local.y,
                                std::atan2(local.y, local.x) / 6.2831855F + 0.5F);
        }
        ratio += test::starDiscrepancy(points) / test::randomStarDiscrepancy(children) / 50.0;
    }
    EXPECT_LT(ratio, 0.5);
}

TEST(Tracer, OneSidedSurfacesSwallowWhatComesFromBehind) {
    test::RoomBuilder room;
    const auto wall = room.material(test::opaque(Rgb(1.0F)));
    room.quad({-1e4F, -1e4F, 0}, {1e4F, -1e4F, 0}, {1e4F, 1e4F, 0}, {-1e4F, 1e4F, 0}, wall); // faces up
    for (const float z : {10.0F, -10.0F}) {
        Traced traced(room.build(), {test::lamp({0, 0, z}, Rgb(100.0F))}, test::roulette(true, 3));
        const auto photons = traced.trace(0, 2000);
        EXPECT_EQ(photons.empty(), z < 0.0F);
        EXPECT_EQ(traced.counts.backHits > 900, z < 0.0F);
        EXPECT_NEAR(traced.counts.escapedFlux[0], z < 0.0F ? 50.0 : 100.0, 1.0);
    }
    room.materials[0].twoSided = true;
    Traced both(room.build(), {test::lamp({0, 0, -10}, Rgb(100.0F))}, test::roulette(true, 3));
    const auto photons = both.trace(0, 2000);
    EXPECT_GT(photons.size(), 900U);
    EXPECT_EQ(both.counts.backHits, 0U);
    EXPECT_NEAR(both.counts.escapedFlux[0], 100.0, 1e-3) << "reflected downwards again";
}

/// A photon passes a filter in proportion to its transmittance, in its colour; the rest meets an opaque surface.
TEST(Tracer, FiltersLetTheirShareThrough) {
    test::RoomBuilder room;
    auto glass = test::opaque(Rgb(0.0F));
    glass.interaction = scene::Interaction::Filter;
    glass.alphaOnly = false; // light filter: the texel's colour passes
    auto image = std::make_shared<level::Image>();
    image->width = image->height = 1;
    image->pixels = {Rgba8(255, 51, 0, 255)};
    glass.filter = image;
    const auto filter = room.material(glass);
    const auto wall = room.material(test::opaque(Rgb(0.0F)));
    const float far = 1e5F;
    room.quad({-far, -far, 10}, {far, -far, 10}, {far, far, 10}, {-far, far, 10}, filter);
    room.quad({-far, -far, 0}, {far, -far, 0}, {far, far, 0}, {-far, far, 0}, wall);
    Traced traced(room.build(), {test::lamp({0, 0, 20}, Rgb(200.0F))}, test::roulette(true, 3));
    test::Moments red;
    test::Moments green;
    double blue = 0.0;
    constexpr int groups = 50;
    for (int g = 0; g < groups; ++g) {
        glm::dvec3 sum(0.0);
        for (const Photon& p : traced.trace(static_cast<std::uint64_t>(g) * 1000, 1000))
            if (p.position.z < 1.0F) sum += glm::dvec3(p.flux);
        red.add(sum.x);
        green.add(sum.y);
        blue += sum.z;
    }
    EXPECT_LT(std::abs(test::zScore(red.mean(), 100.0, red.squaredError() + 0.01)), 5.0) << red.mean();
    EXPECT_LT(std::abs(test::zScore(green.mean(), 20.0, green.squaredError() + 0.001)), 5.0) << green.mean();
    EXPECT_EQ(blue, 0.0);
    EXPECT_GT(traced.counts.filtered, 100U);
}

/// Paths from a point light over a black plane: flux per ring as the inverse square law and the cosine say.
TEST(Tracer, PlaneUnderAPointLight) {
    test::RoomBuilder room;
    const auto wall = room.material(test::opaque(Rgb(0.0F)));
    const float far = 1e4F;
    room.quad({-far, -far, 0}, {far, -far, 0}, {far, far, 0}, {-far, far, 0}, wall);
    Traced traced(room.build(), {test::lamp({0, 0, 100}, Rgb(1000.0F))}, test::roulette(true, 3));
    constexpr std::size_t rings = 12;
    constexpr std::size_t count = 100'000;
    std::vector<double> observed(rings + 1, 0.0);
    std::vector<double> expected(rings + 1, 0.0);
    // Inside radius r: 1/2 (1 - 1/sqrt(1 + (r/h)²)) of all.
    const auto inside = [](double r) { return 0.5 * (1.0 - 1.0 / std::sqrt(1.0 + r * r * 1e-4)); };
    for (std::size_t i = 0; i < rings; ++i)
        expected[i] = count * (inside(40.0 * static_cast<double>(i + 1)) - inside(40.0 * static_cast<double>(i)));
    expected[rings] = count * (1.0 - inside(40.0 * rings));
    const auto photons = traced.trace(0, count);
    for (const Photon& p : photons) {
        EXPECT_NEAR(p.flux.x, 0.01F, 1e-6F);
        const auto ring = static_cast<std::size_t>(std::hypot(p.position.x, p.position.y) / 40.0);
        if (ring < rings) ++observed[ring];
    }
    observed[rings] = count;
    for (std::size_t i = 0; i < rings; ++i) observed[rings] -= observed[i];
    // Quasi-random points do better than chance: the deviate is far below that of random ones, and never above 5.
    EXPECT_LT(test::chiSquareDeviate(observed, expected), 0.0);
    for (std::size_t i = 0; i < rings; ++i) EXPECT_NEAR(observed[i] / expected[i], 1.0, 0.01) << i;
}

/// Fig 5.4: in a narrow corner no photon gets out, neither where walls meet at a few degrees.
TEST(Tracer, NothingLeaksFromNarrowCorners) {
    for (const float height : {4.0F, 0.5F, 0.05F}) {
        test::RoomBuilder room;
        const auto wall = room.material(test::opaque(Rgb(0.95F)));
        // A wedge: floor, and a roof that comes down to it at x = 0.
        room.triangle({0, 0, 0}, {100, 0, 0}, {100, 50, 0}, wall);
        room.triangle({0, 0, 0}, {100, 50, 0}, {0, 50, 0}, wall);
        room.triangle({0, 0, 0}, {100, 50, height}, {100, 0, height}, wall);
        room.triangle({0, 0, 0}, {0, 50, 0}, {100, 50, height}, wall);
        room.triangle({0, 0, 0}, {100, 0, height}, {100, 0, 0}, wall);
        room.triangle({0, 50, 0}, {100, 50, 0}, {100, 50, height}, wall);
        room.quad({100, 0, 0}, {100, 0, height}, {100, 50, height}, {100, 50, 0}, wall);
        Traced traced(room.build(), {test::lamp({90, 25, 0.45F * height}, Rgb(1000.0F))}, test::roulette(true, 60));
        const auto photons = traced.trace(0, 5000);
        EXPECT_GT(photons.size(), 60'000U);
        EXPECT_LT(static_cast<double>(traced.counts.escaped + traced.counts.backHits),
                  1e-4 * static_cast<double>(traced.counts.rays))
            << height;
    }
}

TEST(Tracer, IntersectorsGiveTheSamePaths) {
    const auto scene = everything();
    Traced embree(scene, manyLights(), test::roulette(true, 6));
    Traced brute(scene, manyLights(), test::roulette(true, 6), intersect::Kind::BruteForce);
    const auto a = embree.trace(0, 3000);
    const auto b = brute.trace(0, 3000);
    // Rounding may send a path another way at an edge: most are alike.
    std::size_t alike = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        alike += glm::length(a[i].position - b[i].position) < 0.1F ? 1 : 0;
    EXPECT_NEAR(static_cast<double>(a.size()), static_cast<double>(b.size()), 0.01 * static_cast<double>(a.size()));
    EXPECT_GT(alike, 0U);
    glm::dvec3 sums[2]{};
    for (const Photon& p : a) sums[0] += glm::dvec3(p.flux);
    for (const Photon& p : b) sums[1] += glm::dvec3(p.flux);
    EXPECT_NEAR(sums[0].x / sums[1].x, 1.0, 0.01);
}

} // namespace
} // namespace pie::photons
