// Direct light, areas and estimates in shipped levels: what the fast way costs and how far it is from testing every
// light.

#include "pie/gather/direct.h"
#include "pie/gather/nearest_photons.h"
#include "pie/lights/import.h"
#include "pie/photons/tracer.h"
#include "pie/scene/mesh.h"
#include "tests/gather/scenes.h"
#include "tests/support/game_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pie::gather {
namespace {

struct Shipped {
    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<intersect::Intersector> intersector;
    lights::LightSet lights;
    scene::Receivers receivers; ///< about 200, spread over the level
    level::Tree tree;

    explicit Shipped(const std::string& name) {
        auto loaded = level::loadLevel({pie::test::GameData::instance().files, "maps/" + name + ".bsp"});
        EXPECT_TRUE(loaded) << loaded.error().message();
        const level::Level level = *std::move(loaded);
        scene = std::make_shared<const scene::Scene>(scene::makeScene(level));
        intersector = intersect::makeIntersector(intersect::Kind::Embree, *scene, level.tree);
        lights = lights::LightSet(lights::importLights(level, *scene).lights, scene);
        scene::Mesh mesh = scene::makeMesh(level);
        const scene::Receivers everywhere = scene::makeReceivers(mesh, level);
        const std::size_t step = std::max<std::size_t>(1, everywhere.points.size() / 200);
        for (std::size_t i = 0; i < everywhere.points.size(); i += step)
            receivers.points.push_back(everywhere.points[i]);
        tree = level.tree;
    }
};

TEST(ShippedLevel, DirectLightIsNearTheTestOfEveryLight) {
    PIE_NEED_GAME_DATA();
    const Shipped level("oa_dm1");
    const std::vector<std::uint32_t> which = test::all(level.receivers);
    std::vector<Rgb> fast(which.size());
    std::vector<Rgb> reference(which.size());
    const DirectLight direct(*level.scene, level.lights, *level.intersector, level.receivers);
    direct.estimate(which, fast);
    DirectOptions options;
    options.exhaustive = true;
    options.softness = 8;
    const DirectLight all(*level.scene, level.lights, *level.intersector, level.receivers, options);
    all.estimate(which, reference);
    double sumSquared = 0;
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < which.size(); ++i) {
        const auto truth = static_cast<double>(meanChannel(reference[i]));
        if (truth < 1) continue;
        const double error = static_cast<double>(meanChannel(fast[i])) / truth - 1;
        sumSquared += error * error;
        sum += error;
        ++count;
    }
    ASSERT_GT(count, 30);
    EXPECT_LT(std::sqrt(sumSquared / count), 0.06);
    EXPECT_LT(std::abs(sum / count), 0.02);
    EXPECT_LT(10 * direct.raysTraced(), all.raysTraced());
}

TEST(ShippedLevel, EstimatesAreFiniteAndTheTreeAgreesWithTheExactMap) {
    PIE_NEED_GAME_DATA();
    const Shipped level("oa_dm1");
    std::vector<photons::Photon> photons;
    photons::PhotonTracer(*level.scene, level.lights, *level.intersector, {}).trace(0, 5000, photons);
    ASSERT_GT(photons.size(), 1000U);
    maps::RealtimeMap tree;
    maps::RealtimeMap exact(1, maps::Search::Exact);
    tree.replaceOldest(std::vector(photons));
    exact.replaceOldest(std::move(photons));
    tree.rebuild();
    exact.rebuild();
    const std::vector<std::uint32_t> which = test::all(level.receivers);
    const TrueArea area(*level.scene, Kernel::Epanechnikov, {}, 192);
    const AreaTable table(area, level.receivers);
    int lit = 0;
    for (const bool trueArea : {false, true}) {
        std::vector<std::vector<Rgb>> results;
        for (const maps::RealtimeMap* map : {&tree, &exact}) {
            std::vector<Rgb> e(which.size());
            if (trueArea)
                NearestPhotons(*level.scene, level.receivers, *map, {}, area, table).estimate(which, e);
            else
                NearestPhotons(*level.scene, level.receivers, *map, {}).estimate(which, e);
            results.push_back(std::move(e));
        }
        for (std::size_t i = 0; i < which.size(); ++i) {
            EXPECT_TRUE(std::isfinite(results[0][i].x) && results[0][i].x >= 0.0F);
            EXPECT_FLOAT_EQ(results[0][i].x, results[1][i].x);
            if (results[0][i].x > 0.0F) ++lit;
        }
    }
    EXPECT_GT(lit, 100);
}

TEST(ShippedLevel, SeveralMapsAgreeWithTheExactMapAndLookAtFewerPhotons) {
    PIE_NEED_GAME_DATA();
    const Shipped level("oa_dm1");
    std::vector<photons::Photon> photons;
    photons::PhotonTracer(*level.scene, level.lights, *level.intersector, {}).trace(0, 5000, photons);
    const auto partition = std::make_shared<const maps::Partition>(*level.scene, level.tree, maps::SplitBy::Both);
    ASSERT_GT(partition->cells(), 30U) << "the level has visibility";
    maps::RealtimeMap whole;
    maps::RealtimeMap split(1, maps::Search::KdTree, partition);
    maps::RealtimeMap exact(1, maps::Search::Exact, partition);
    for (maps::RealtimeMap* map : {&whole, &split, &exact}) {
        map->replaceOldest(std::vector(photons));
        map->rebuild();
    }
    const std::vector<std::uint32_t> which = test::all(level.receivers);
    for (const AreaEstimate area : {AreaEstimate::Disc, AreaEstimate::True}) {
        NearestOptions options;
        options.area = area;
        std::vector<std::vector<Rgb>> results;
        std::vector<maps::Visits> visits;
        for (const maps::RealtimeMap* map : {&whole, &split, &exact}) {
            const NearestPhotons estimator(*level.scene, level.receivers, *map, options);
            results.emplace_back(which.size());
            estimator.estimate(which, results.back());
            visits.push_back(estimator.visits());
        }
        std::size_t lit = 0;
        for (std::size_t i = 0; i < which.size(); ++i) {
            EXPECT_FLOAT_EQ(results[1][i].x, results[2][i].x) << i;
            if (results[1][i].x > 0.0F) ++lit;
        }
        EXPECT_GT(lit, 50U);
        EXPECT_LT(visits[1].photons, visits[0].photons);
        EXPECT_LT(visits[0].photons, visits[2].photons);
        EXPECT_EQ(visits[2].nodes + visits[2].leaves, 0U);
    }
}

} // namespace
} // namespace pie::gather
