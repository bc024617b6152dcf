// Estimates from several maps: those of one map that is asked for the same photons, and of light that does not leak.

#include "pie/core/parallel.h"
#include "pie/gather/nearest_photons.h"
#include "tests/gather/gathering.h"
#include "tests/maps/trees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace pie::gather {
namespace {

using maps::Partition;
using maps::SplitBy;
using photons::Photon;
using test::even;
using test::photonOn;
using test::receiverAt;
using test::SceneBuilder;

constexpr SplitBy splits[] = {SplitBy::None, SplitBy::Normal, SplitBy::Cell, SplitBy::Both};
const Vec3 up(0.0F, 0.0F, 1.0F);

/// Photons in a map that may be split, receivers, and a way to ask.
struct Split {
    const scene::Scene& scene;
    scene::Receivers receivers;
    maps::RealtimeMap map;
    NearestOptions options;

    Split(const scene::Scene& s, const level::Tree& tree, SplitBy by, std::vector<scene::Receiver> points,
          const std::vector<Photon>& photons, maps::Search search = maps::Search::KdTree)
        : scene(s), receivers(test::receiversAt(std::move(points))),
          map(1, search, by == SplitBy::None ? nullptr : std::make_shared<const Partition>(s, tree, by)) {
        map.replaceOldest(std::vector<Photon>(photons));
        map.rebuild();
        options.maxRadius = 30.0F;
        options.maxCount = 40;
    }
    [[nodiscard]] std::vector<Rgb> estimate() const {
        const NearestPhotons estimator(scene, receivers, map, options);
        const auto which = test::all(receivers);
        std::vector<Rgb> irradiance(which.size());
        estimator.estimate(which, irradiance);
        // At points that are no receivers it is the same, but that true areas are not interpolated, which smooths
        // steps.
        std::vector<Rgb> again(which.size());
        estimator.estimateAt(receivers.points, again);
        for (std::size_t i = 0; i < again.size(); ++i) {
            EXPECT_NEAR(again[i].x, irradiance[i].x,
                        (options.area == AreaEstimate::True ? 0.15F : 1e-5F) * irradiance[i].x + 1e-20F);
        }
        return irradiance;
    }
    [[nodiscard]] maps::Visits visits() const {
        const NearestPhotons estimator(scene, receivers, map, options);
        const auto which = test::all(receivers);
        std::vector<Rgb> irradiance(which.size());
        estimator.estimate(which, irradiance);
        return estimator.visits();
    }
};

/// Rooms with rock between them, one cluster each, and boxes and tents on their floors.
struct Rooms {
    std::shared_ptr<const scene::Scene> scene;
    level::Tree tree = maps::test::rooms(3, 104.0F, 100.0F);
    std::vector<Photon> photons;
    std::vector<scene::Receiver> points;

    explicit Rooms(std::size_t count = 30'000) {
        SceneBuilder builder;
        builder.grey(0.5F);
        scene::Material cloth;
        cloth.twoSided = true;
        builder.material(cloth);
        for (int room = 0; room < 3; ++room) {
            const Vec3 origin(104.0F * static_cast<float>(room), 0.0F, 0.0F);
            builder.room(origin, origin + 100.0F);
            // A tent, and cloth that leans on the wall beside the next room.
            builder.quad(origin + Vec3(40.0F, 20.0F, 0.0F), {0.0F, 60.0F, 0.0F}, {-20.0F, 0.0F, 15.0F});
            builder.quad(origin + Vec3(80.0F, 20.0F, 0.0F), {0.0F, 60.0F, 0.0F}, {18.0F, 0.0F, 40.0F}, 1);
        }
        scene = builder.make();
        photons = even(*scene, count, 1.0F, 3);
        for (std::size_t i = 0; i < photons.size(); ++i) {
            // Each room another light; half of the photons on cloth from behind.
            photons[i].flux *= 1.0F + std::floor(photons[i].position.x / 104.0F);
            if (i % 2 == 0 && scene->material(photons[i].triangle).twoSided) photons[i].direction *= -1.0F;
        }
        std::mt19937 random(4);
        const test::SurfaceSampler sampler(*scene);
        for (int i = 0; i < 600; ++i) {
            const auto [position, triangle] = sampler(random);
            Vec3 normal = scene->normals[triangle];
            if (i % 4 == 0) normal = glm::normalize(normal + 0.7F * test::direction(random));
            points.push_back(receiverAt(position, normal, scene->material(triangle).twoSided));
        }
    }
};

TEST(SplitMaps, AnswerLikeOneMapWithAFilter) {
    // The exact map looks at every photon and asks where it belongs and how it faces.
    const Rooms rooms(9000);
    for (const SplitBy by : splits)
        for (const SearchVolume volume : {SearchVolume::Sphere, SearchVolume::Slice, SearchVolume::Cylinder})
            for (const AreaEstimate area : {AreaEstimate::Disc, AreaEstimate::Hull, AreaEstimate::True}) {
                Split tree(*rooms.scene, rooms.tree, by, rooms.points, rooms.photons);
                Split exact(*rooms.scene, rooms.tree, by, rooms.points, rooms.photons, maps::Search::Exact);
                for (Split* map : {&tree, &exact}) {
                    map->options.volume = volume;
                    map->options.area = area;
                }
                const auto a = tree.estimate();
                const auto b = exact.estimate();
                for (std::size_t i = 0; i < a.size(); ++i) {
                    ASSERT_FLOAT_EQ(a[i].x, b[i].x)
                        << "split " << static_cast<int>(by) << ", volume " << static_cast<int>(volume) << ", area "
                        << static_cast<int>(area) << ", receiver " << i;
                }
            }
}

TEST(SplitMaps, ByNormalChangesNothingWhereNormalsDecideAnyway) {
    const Rooms rooms;
    Split one(*rooms.scene, rooms.tree, SplitBy::None, rooms.points, rooms.photons);
    Split several(*rooms.scene, rooms.tree, SplitBy::Normal, rooms.points, rooms.photons);
    one.options.area = several.options.area = AreaEstimate::True;
    const auto a = one.estimate();
    const auto b = several.estimate();
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_FLOAT_EQ(a[i].x, b[i].x) << i;
    EXPECT_LT(several.visits().photons, one.visits().photons);
}

TEST(SplitMaps, ByCellKeepLightOnItsSideOfAWall) {
    // Receivers at the floor's edge to a darker room, whose floor is four units away in the same plane.
    const Rooms rooms;
    std::vector<scene::Receiver> points;
    for (int i = 0; i < 60; ++i) {
        points.push_back(receiverAt({104.0F, 10.0F + static_cast<float>(i), 0.0F}, up));
        points.back().inset.x += 1.0F;
    }
    const auto mean = [&](SplitBy by, AreaEstimate area) {
        Split split(*rooms.scene, rooms.tree, by, points, rooms.photons);
        split.options.area = area;
        split.options.maxCount = 200;
        double sum = 0;
        for (const Rgb& e : split.estimate()) sum += static_cast<double>(e.x);
        return sum / static_cast<double>(points.size());
    };
    // The room has 2 W per square unit, the other 1. 30,000 photons on 3 · 62,000 square units: about 230 per disc of
    // radius 30, half of them there; 60 estimates that overlap, standard error below 3 %.
    EXPECT_NEAR(mean(SplitBy::Cell, AreaEstimate::True), 2.0, 0.2);
    EXPECT_NEAR(mean(SplitBy::Both, AreaEstimate::True), 2.0, 0.2);
    EXPECT_NEAR(mean(SplitBy::Cell, AreaEstimate::Disc), 1.0, 0.1) << "half of the disc is not there";
    EXPECT_LT(mean(SplitBy::None, AreaEstimate::True), 1.7) << "else there is nothing to see";
    EXPECT_GT(mean(SplitBy::None, AreaEstimate::Disc), 1.2);
}

TEST(SplitMaps, ByNormalKeepOtherSurfacesOutOfASphere) {
    SceneBuilder builder;
    builder.room(Vec3(0.0F), Vec3(100.0F));
    const auto room = builder.make();
    std::vector<Photon> photons;
    for (int i = 0; i < 100; ++i)
        photons.push_back(photonOn(*room, 4, {0.0F, 50.0F, 1.0F + 0.01F * static_cast<float>(i)}, 100.0F)); // a wall
    photons.push_back(photonOn(*room, 0, {3.0F, 50.0F, 0.0F}, 1.0F));
    for (Photon& photon : photons) photon.direction = -glm::normalize(Vec3(1.0F, 0.0F, 1.0F));
    const auto ask = [&](SplitBy by) {
        Split split(*room, {}, by, {receiverAt({1.0F, 50.0F, 0.0F}, up)}, photons);
        split.options.volume = SearchVolume::Sphere;
        split.options.maxRadius = 10.0F;
        split.options.maxCount = 500;
        return std::pair(split.estimate()[0].x, split.visits().photons);
    };
    const float disc = std::numbers::pi_v<float> * 100.0F;
    EXPECT_FLOAT_EQ(ask(SplitBy::None).first, 10'001.0F / disc);
    EXPECT_FLOAT_EQ(ask(SplitBy::Normal).first, 1.0F / disc);
    EXPECT_EQ(ask(SplitBy::None).second, 101U);
    EXPECT_EQ(ask(SplitBy::Normal).second, 1U) << "photons of the wall are not even looked at";
    EXPECT_FLOAT_EQ(ask(SplitBy::Cell).first, 10'001.0F / disc) << "without a tree there is one cell";
}

TEST(SplitMaps, SameBitsOnAnyNumberOfThreads) {
    const Rooms rooms;
    for (const AreaEstimate area : {AreaEstimate::Disc, AreaEstimate::True}) {
        std::vector<Rgb> one;
        for (const unsigned threads : {1U, 2U}) {
            setThreads(threads);
            Split split(*rooms.scene, rooms.tree, SplitBy::Both, rooms.points, rooms.photons);
            split.options.area = area;
            const auto irradiance = split.estimate();
            if (threads == 1) one = irradiance;
            EXPECT_EQ(irradiance, one);
        }
        setThreads(0);
    }
}

} // namespace
} // namespace pie::gather
