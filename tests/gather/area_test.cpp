// The surface that exists: analytic cases, random scenes against points thrown on their surfaces, and the tables.

#include "pie/core/parallel.h"
#include "pie/gather/area.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <glm/vec3.hpp>

#include <cmath>
#include <thread>

namespace pie::gather {
namespace {

using test::all;
using test::receiverAt;
using test::receiversAt;
using test::SceneBuilder;
using test::unit3;

constexpr double pi = std::numbers::pi;
const Vec3 up(0.0F, 0.0F, 1.0F);

/// Share of the whole disc.
double share(const scene::Scene& scene, const Vec3& point, const Vec3& normal, float radius,
             Kernel kernel = Kernel::Epanechnikov, const SliceOptions& slice = {}) {
    const TrueArea area(scene, kernel, slice, radius);
    EXPECT_EQ(area.maxRadius(), radius);
    return area.integral(point, normal, radius) /
           (discIntegral(kernel) * static_cast<double>(radius) * static_cast<double>(radius));
}

TEST(TrueArea, OpenFloorEdgeAndCorner) {
    SceneBuilder builder;
    builder.room({0.0F, 0.0F, 0.0F}, {256.0F, 256.0F, 128.0F});
    const auto room = builder.make();
    for (const Kernel kernel : {Kernel::Constant, Kernel::Cone, Kernel::Gaussian, Kernel::Epanechnikov}) {
        const double tolerance = kernel == Kernel::Constant || kernel == Kernel::Epanechnikov ? 1e-6 : 1e-4;
        EXPECT_NEAR(share(*room, {128.0F, 100.0F, 0.0F}, up, 60.0F, kernel), 1.0, tolerance);
        EXPECT_NEAR(share(*room, {128.0F, 0.0F, 0.0F}, up, 60.0F, kernel), 0.5, tolerance);
        EXPECT_NEAR(share(*room, {0.0F, 0.0F, 0.0F}, up, 60.0F, kernel), 0.25, tolerance);
        EXPECT_NEAR(share(*room, {256.0F, 256.0F, 128.0F}, -up, 60.0F, kernel), 0.25, tolerance);
        EXPECT_NEAR(share(*room, {0.0F, 0.0F, 64.0F}, {1.0F, 0.0F, 0.0F}, 60.0F, kernel), 0.5, tolerance);
    }
    // Facing the other way there is nothing: rooms are one-sided.
    EXPECT_EQ(share(*room, {128.0F, 128.0F, 0.0F}, -up, 60.0F), 0.0);
}

TEST(TrueArea, DoesNotDependOnTheTriangulation) {
    SceneBuilder plain;
    plain.quad({0.0F, 0.0F, 0.0F}, {64.0F, 0.0F, 0.0F}, {0.0F, 64.0F, 0.0F});
    SceneBuilder slivers; // a fan of long thin triangles around a point near the border
    const Vec3 hub(1.0F, 32.0F, 0.0F);
    for (int i = 0; i < 640; ++i) {
        const auto at = [](int n) {
            const auto s = static_cast<float>(n % 160) * 0.4F;
            switch (n / 160 % 4) {
            case 0: return Vec3(s, 0.0F, 0.0F);
            case 1: return Vec3(64.0F, s, 0.0F);
            case 2: return Vec3(64.0F - s, 64.0F, 0.0F);
            default: return Vec3(0.0F, 64.0F - s, 0.0F);
            }
        };
        slivers.triangle(hub, at(i), at(i + 1));
    }
    const auto a = plain.make();
    const auto b = slivers.make();
    std::mt19937 random(3);
    for (int i = 0; i < 200; ++i) {
        const Vec3 point(64.0F * test::unit(random), 64.0F * test::unit(random), 2.0F * test::unit(random));
        const float radius = 1.0F + 60.0F * test::unit(random);
        EXPECT_NEAR(share(*a, point, up, radius), share(*b, point, up, radius), 1e-4) << "point " << i;
    }
}

TEST(TrueArea, TheSliceCutsWhatLeavesIt) {
    SceneBuilder builder; // a slope of 30 degrees through the origin
    const float slope = std::tan(static_cast<float>(pi) / 6.0F);
    builder.quad({-100.0F, -100.0F, -100.0F * slope}, {200.0F, 0.0F, 200.0F * slope}, {0.0F, 200.0F, 0.0F});
    const auto scene = builder.make();
    SliceOptions slice;
    slice.halfThickness = 5.0F;
    // The receiver's normal is vertical: of the slope's disc remains the band with |z| <= 5, that is |s| <= 5/sin 30°.
    const TrueArea area(*scene, Kernel::Constant, slice, 40.0F);
    const double half = 10;
    const double r = 40;
    const double band = 2 * (half * std::sqrt(r * r - half * half) + r * r * std::asin(half / r));
    EXPECT_NEAR(area.integral({0.0F, 0.0F, 0.0F}, up, 40.0F), band, 1e-3);
    // And nothing when it faces too far away.
    slice.minCosine = 0.9F;
    EXPECT_EQ(TrueArea(*scene, Kernel::Constant, slice, 40.0F).integral({0.0F, 0.0F, 0.0F}, up, 40.0F), 0.0);
}

TEST(TrueArea, StepsBeyondTheSliceDoNotCount) {
    SceneBuilder builder;
    builder.quad({0.0F, -50.0F, 0.0F}, {50.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F});
    builder.quad({-50.0F, -50.0F, 8.0F}, {50.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F});
    builder.quad({-50.0F, -50.0F, 2.0F}, {50.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F});
    const auto scene = builder.make();
    const double thin = share(*scene, {0.0F, 0.0F, 0.0F}, up, 20.0F, Kernel::Constant);
    EXPECT_NEAR(thin, 0.5 + 0.5 * (1 - 4.0 / 400), 1e-6) << "the step of 2 units counts, that of 8 does not";
}

TEST(TrueArea, SkyIsNoSurfaceAndTwoSidedOnesFaceBothWays) {
    SceneBuilder builder;
    scene::Material sky;
    sky.interaction = scene::Interaction::Sky;
    scene::Material cloth;
    cloth.twoSided = true;
    const std::uint32_t skyNumber = builder.material(sky);
    const std::uint32_t clothNumber = builder.material(cloth);
    builder.quad({0.0F, 0.0F, 0.0F}, {50.0F, 0.0F, 0.0F}, {0.0F, 50.0F, 0.0F}, skyNumber);
    builder.quad({-50.0F, 0.0F, 0.0F}, {50.0F, 0.0F, 0.0F}, {0.0F, 50.0F, 0.0F}, clothNumber);
    const auto scene = builder.make();
    EXPECT_NEAR(share(*scene, {0.0F, 25.0F, 0.0F}, up, 20.0F), 0.5, 1e-6);
    EXPECT_NEAR(share(*scene, {0.0F, 25.0F, 0.0F}, -up, 20.0F), 0.5, 1e-6);
}

TEST(TrueArea, CoplanarTrianglesCountOnceOnlyWhenTheyAreTheSame) {
    SceneBuilder builder;
    for (int i = 0; i < 3; ++i) builder.quad({0.0F, 0.0F, 0.0F}, {50.0F, 0.0F, 0.0F}, {0.0F, 50.0F, 0.0F});
    const auto same = builder.make();
    EXPECT_NEAR(share(*same, {25.0F, 25.0F, 0.0F}, up, 20.0F), 1.0, 1e-6);
    builder.quad({0.0F, 0.0F, 0.0F}, {60.0F, 0.0F, 0.0F}, {0.0F, 50.0F, 0.0F});
    const auto overlapping = builder.make();
    EXPECT_NEAR(share(*overlapping, {25.0F, 25.0F, 0.0F}, up, 20.0F), 2.0, 1e-6) << "the documented limit";
}

TEST(TrueArea, WorksFarFromTheOriginAndInTinyLevels) {
    for (const auto& [origin, size] : std::vector<std::pair<Vec3, float>>{
             {{1e7F, -1e7F, 5e6F}, 4096.0F}, {{0.0F, 0.0F, 0.0F}, 1e-3F}, {{0.0F, 0.0F, 0.0F}, 1e7F}}) {
        SceneBuilder builder;
        builder.quad(origin, {size, 0.0F, 0.0F}, {0.0F, size, 0.0F});
        const auto scene = builder.make();
        EXPECT_NEAR(share(*scene, origin + Vec3(0.5F * size, 0.5F * size, 0.0F), up, 0.25F * size), 1.0, 1e-5);
        EXPECT_NEAR(share(*scene, origin + Vec3(0.5F * size, 0.0F, 0.0F), up, 0.25F * size), 0.5, 1e-5);
    }
}

TEST(TrueArea, NumbersThatMustNotBreakIt) {
    SceneBuilder builder;
    builder.quad({0.0F, 0.0F, 0.0F}, {3.0F, 0.0F, 0.0F}, {0.0F, 4.0F, 0.0F});
    const auto scene = builder.make();
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float radius : {0.0F, -1.0F, nan}) {
        const TrueArea area(*scene, Kernel::Constant, {}, radius);
        EXPECT_EQ(area.maxRadius(), 0.0F);
        EXPECT_EQ(area.integral({1.0F, 1.0F, 0.0F}, up, 0.0F), 0.0);
    }
    const TrueArea area(*scene, Kernel::Constant, {}, infinity);
    EXPECT_FLOAT_EQ(area.maxRadius(), 5.0F) << "cut down to the diagonal of the scene";
    EXPECT_NEAR(area.integral({1.0F, 1.0F, 0.0F}, up, 5.0F), 12.0, 1e-6);
    const float tiny = std::numeric_limits<float>::denorm_min();
    EXPECT_GE(area.integral({1.0F, 1.0F, 0.0F}, up, tiny), 0.0);
    for (const Vec3& bad : {Vec3(nan, 0.0F, 0.0F), Vec3(infinity, 0.0F, 0.0F), Vec3(1e38F, 1e38F, 1e38F)})
        EXPECT_EQ(area.integral(bad, up, 5.0F), 0.0);
    EXPECT_EQ(area.integral({1.0F, 1.0F, 0.0F}, {0.0F, 0.0F, 0.0F}, 5.0F), 0.0);
    EXPECT_EQ(area.integral({1.0F, 1.0F, 0.0F}, {nan, 0.0F, 0.0F}, 5.0F), 0.0);

    const scene::Scene empty;
    EXPECT_EQ(TrueArea(empty, Kernel::Constant, {}, 9.0F).integral({0.0F, 0.0F, 0.0F}, up, 9.0F), 0.0);
}

/// A heap of triangles of all sizes, one- and two-sided.
std::shared_ptr<const scene::Scene> heap(std::uint32_t seed, int count) {
    std::mt19937 random(seed);
    SceneBuilder builder;
    scene::Material cloth;
    cloth.twoSided = true;
    builder.grey(0.5F);
    builder.material(cloth);
    for (int i = 0; i < count; ++i) {
        const Vec3 a = 40.0F * unit3(random);
        const float size = std::pow(10.0F, 2.0F * test::unit(random) - 0.3F);
        // Mostly lying flat, so that many pass the test of facing.
        const Vec3 flat(1.0F, 1.0F, i % 3 == 0 ? 1.0F : 0.1F);
        builder.triangle(a, a + size * flat * test::direction(random), a + size * flat * test::direction(random),
                         random() % 2);
    }
    return builder.make();
}

TEST(TrueArea, AgreesWithPointsThrownOnTheSurface) {
    // The points are photons that passed SurfaceTest: flux and area speak of the same surface.
    const auto scene = heap(5, 300);
    const test::SurfaceSampler sampler(*scene);
    constexpr int points = 400'000;
    std::mt19937 random(6);
    std::vector<photons::Photon> photons(points);
    for (photons::Photon& photon : photons) {
        const auto [position, triangle] = sampler(random);
        photon.position = position;
        photon.triangle = triangle;
        // From the front of one-sided triangles, from either side of others: each side counts as one surface.
        const Vec3 normal = scene->normals[triangle];
        const bool back = scene->material(triangle).twoSided && random() % 2 == 0;
        photon.direction = back ? normal : -normal;
    }
    int outside = 0;
    constexpr int receivers = 60;
    for (int i = 0; i < receivers; ++i) {
        const Vec3 point = sampler(random).first;
        const Vec3 normal = i % 2 == 0 ? up : test::direction(random);
        const float radius = 2.0F + 18.0F * test::unit(random);
        const Kernel kernel = i % 3 == 0 ? Kernel::Constant : i % 3 == 1 ? Kernel::Epanechnikov : Kernel::Cone;
        const TrueArea area(*scene, kernel, {}, radius);
        const SurfaceTest belongs{*scene, point, normal, {}, false};
        double sum = 0;
        double sumSquared = 0;
        for (const photons::Photon& photon : photons) {
            const double t = static_cast<double>(glm::dot(photon.position - point, photon.position - point)) /
                             static_cast<double>(radius * radius);
            if (t > 1 || belongs(photon) != SurfaceTest::Side::Front) continue;
            // Half of the points on a two-sided triangle fell on the other side.
            const double w = value(kernel, t) * (scene->material(photon.triangle).twoSided ? 2 : 1);
            sum += w;
            sumSquared += w * w;
        }
        const double scale = sampler.area() / points;
        const double error = scale * std::sqrt(sumSquared);
        const double expected = area.integral(point, normal, radius);
        if (std::abs(scale * sum - expected) > 3.5 * error + 1e-3) ++outside;
    }
    // 3.5 sigma: 60 × 4.7e-4; two or more by chance in 4 of 10,000 runs. The seed is fixed.
    EXPECT_LE(outside, 1);
}

TEST(TrueArea, FindsTheSameTrianglesWhateverTheGrid) {
    // Small and large balls use different grids; the constant kernel with an unlimited slice must not notice.
    const auto scene = heap(9, 500);
    SliceOptions slice;
    slice.halfThickness = 1000.0F;
    const TrueArea fine(*scene, Kernel::Constant, slice, 3.0F);
    const TrueArea coarse(*scene, Kernel::Constant, slice, 40.0F);
    std::mt19937 random(10);
    for (int i = 0; i < 300; ++i) {
        const Vec3 point = 50.0F * unit3(random) - 5.0F;
        EXPECT_NEAR(fine.integral(point, up, 3.0F), coarse.integral(point, up, 3.0F), 1e-9);
    }
}

TEST(AreaTable, InterpolatesWithinAPercent) {
    SceneBuilder builder;
    builder.room({0.0F, 0.0F, 0.0F}, {512.0F, 512.0F, 200.0F});
    const auto room = builder.make();
    const TrueArea area(*room, Kernel::Epanechnikov, {}, 192.0F);
    std::mt19937 random(12);
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 300; ++i) {
        Vec3 point(512.0F * test::unit(random), 512.0F * test::unit(random), 0.0F);
        if (i % 3 == 0) point.x = 0.0F;
        if (i % 9 == 0) point.y = 512.0F;
        points.push_back(receiverAt(point, up));
    }
    const scene::Receivers receivers = receiversAt(points);
    const AreaTable table(area, receivers);
    double sumSquared = 0;
    double worst = 0;
    int count = 0;
    for (std::uint32_t i = 0; i < points.size(); ++i)
        for (const float radius : {192.0F, 191.0F, 130.0F, 97.3F, 48.0F, 21.0F, 10.0F, 4.0F, 3.0F}) {
            const double disc = discIntegral(Kernel::Epanechnikov) * static_cast<double>(radius * radius);
            const double exact = area.integral(points[i].position, up, radius) / disc;
            const double error = static_cast<double>(table.share(i, false, radius)) / exact - 1;
            sumSquared += error * error;
            worst = std::max(worst, std::abs(error));
            ++count;
        }
    EXPECT_LT(std::sqrt(sumSquared / count), 0.002);
    EXPECT_LT(worst, 0.015);
}

TEST(AreaTable, BelowItsSmallestRadiusTheShareStays) {
    SceneBuilder builder;
    builder.room({0.0F, 0.0F, 0.0F}, {512.0F, 512.0F, 200.0F});
    const auto room = builder.make();
    const TrueArea area(*room, Kernel::Epanechnikov, {}, 128.0F);
    const scene::Receivers receivers = receiversAt({receiverAt({1.0F, 100.0F, 0.0F}, up)});
    const AreaTable table(area, receivers);
    EXPECT_EQ(table.share(0, false, 2.0F), table.share(0, false, 0.1F));
    EXPECT_EQ(table.share(0, false, 2.0F), table.share(0, false, 0.0F));
    EXPECT_EQ(table.share(0, false, 128.0F), table.share(0, false, 1e9F));
}

TEST(AreaTable, KeepsTheTwoSidesApart) {
    SceneBuilder builder;
    scene::Material cloth;
    cloth.twoSided = true;
    builder.grey(0.5F);
    builder.material(cloth);
    builder.quad({-50.0F, -50.0F, 0.0F}, {100.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F}, 1);
    builder.quad({-50.0F, -50.0F, 1.0F}, {50.0F, 0.0F, 0.0F}, {0.0F, 100.0F, 0.0F}, 0); // only upwards, half the width
    const auto scene = builder.make();
    const TrueArea area(*scene, Kernel::Constant, {}, 30.0F);
    const scene::Receivers receivers =
        receiversAt({receiverAt({0.0F, 0.0F, 0.0F}, up), receiverAt({0.0F, 0.0F, 0.0F}, up, true)});
    const AreaTable table(area, receivers);
    EXPECT_NEAR(table.share(1, false, 30.0F), 1.5F, 0.01F);
    EXPECT_NEAR(table.share(1, true, 30.0F), 1.0F, 0.01F);
    EXPECT_EQ(table.share(0, false, 30.0F), table.share(1, false, 30.0F));
}

TEST(AreaTable, AnswersTheSameToManyThreadsAtOnce) {
    const auto scene = heap(21, 400);
    const TrueArea area(*scene, Kernel::Epanechnikov, {}, 15.0F);
    std::mt19937 random(22);
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 400; ++i) points.push_back(receiverAt(40.0F * unit3(random), up, i % 2 == 0));
    const scene::Receivers receivers = receiversAt(points);
    const auto shares = [&](const AreaTable& table) {
        std::vector<float> list;
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            list.push_back(table.share(i, false, 7.0F));
            if (points[i].twoSided) list.push_back(table.share(i, true, 7.0F));
        }
        return list;
    };
    const AreaTable ahead(area, receivers);
    ahead.prepare(all(receivers));
    const AreaTable shared(area, receivers);
    std::vector<std::vector<float>> results(3);
    {
        std::vector<std::jthread> threads;
        for (auto& result : results) threads.emplace_back([&] { result = shares(shared); });
    }
    const std::vector<float> expected = shares(ahead);
    for (const auto& result : results) EXPECT_EQ(result, expected);
    EXPECT_GT(std::count_if(expected.begin(), expected.end(), [](float s) { return s > 0.0F; }), 300);
}

} // namespace
} // namespace pie::gather
