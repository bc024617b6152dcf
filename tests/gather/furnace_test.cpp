// Closed boxes have an exact answer: mean irradiance Φ / (A (1 − ρ)), of which Φ / A is direct.

#include "pie/gather/direct.h"
#include "pie/gather/nearest_photons.h"
#include "pie/photons/tracer.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace pie::gather {
namespace {

using test::all;
using test::receiverAt;
using test::SceneBuilder;

constexpr float side = 64;
constexpr float rho = 0.6F;
constexpr float watts = 1000;

struct Furnace {
    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<intersect::Intersector> intersector;
    lights::LightSet lights;
    scene::Receivers inside, edges, corners; ///< evenly over the six faces; on edges; in corners
    scene::Receivers besideEdges;            ///< 3 units from an edge, where the whole disc of an estimate exists
    maps::RealtimeMap map;

    explicit Furnace(bool storeDirectLight, std::uint64_t count = 200'000) {
        SceneBuilder builder;
        builder.grey(rho);
        builder.room(Vec3(0.0F), Vec3(side));
        scene = builder.make();
        intersector = intersect::makeIntersector(intersect::Kind::BruteForce, *scene, {});
        lights::PointLight lamp;
        lamp.position = Vec3(0.5F * side);
        lamp.power = Rgb(watts);
        lamp.falloff.minDistance = 0;
        lights = lights::LightSet({lamp}, scene);

        photons::TracerOptions options;
        options.storeDirectLight = storeDirectLight;
        options.recursionDepth = 60;
        std::vector<photons::Photon> photons;
        photons::PhotonTracer(*scene, lights, *intersector, options).trace(1, count, photons);
        map.replaceOldest(std::move(photons));
        map.rebuild();
        place();
    }

    /// Every face with its axes: a grid of cell middles, its edges, its corners.
    void place() {
        constexpr int cells = 24;
        for (int face = 0; face < 6; ++face) {
            Vec3 normal(0.0F);
            normal[face / 2] = face % 2 == 0 ? 1.0F : -1.0F;
            const auto at = [&](float u, float v) {
                Vec3 p(0.0F);
                p[face / 2] = face % 2 == 0 ? 0.0F : side;
                p[(face / 2 + 1) % 3] = u * side;
                p[(face / 2 + 2) % 3] = v * side;
                return receiverAt(p, normal);
            };
            for (int y = 0; y < cells; ++y) {
                const float v = (static_cast<float>(y) + 0.5F) / cells;
                for (int x = 0; x < cells; ++x) inside.points.push_back(at((static_cast<float>(x) + 0.5F) / cells, v));
                for (const float border : {0.0F, 1.0F}) {
                    if (v < 0.25F || v > 0.75F) continue; // away from the corners
                    edges.points.push_back(at(border, v));
                    edges.points.push_back(at(v, border));
                    const float beside = border == 0.0F ? 3.0F / side : 1.0F - 3.0F / side;
                    besideEdges.points.push_back(at(beside, v));
                    besideEdges.points.push_back(at(v, beside));
                }
            }
            for (const float u : {0.0F, 1.0F})
                for (const float v : {0.0F, 1.0F}) corners.points.push_back(at(u, v));
        }
    }

    [[nodiscard]] double mean(const scene::Receivers& receivers, bool trueArea,
                              const Estimator* direct = nullptr) const {
        NearestOptions options;
        options.maxCount = 100;
        options.maxRadius = 16;
        options.slice.halfThickness = 0.05F;
        const std::vector<std::uint32_t> which = all(receivers);
        std::vector<Rgb> irradiance(which.size());
        if (trueArea) {
            const TrueArea area(*scene, Kernel::Epanechnikov, options.slice, options.maxRadius);
            const AreaTable table(area, receivers);
            NearestPhotons(*scene, receivers, map, options, area, table, direct).estimate(which, irradiance);
        } else {
            NearestPhotons(*scene, receivers, map, options, direct).estimate(which, irradiance);
        }
        double sum = 0;
        for (const Rgb& e : irradiance) sum += static_cast<double>(e.x);
        return sum / static_cast<double>(irradiance.size());
    }
};

constexpr double area = 6.0 * side * side;
constexpr double whole = watts / (area * (1 - rho));

TEST(Furnace, TrueAreaFindsTheExactMean) {
    const Furnace furnace(true);
    EXPECT_NEAR(furnace.mean(furnace.inside, true) / whole, 1.0, 0.02);
}

TEST(Furnace, TrueAreaWithShadowRaysFindsTheExactMean) {
    const Furnace furnace(false);
    const DirectLight direct(*furnace.scene, furnace.lights, *furnace.intersector, furnace.inside);
    EXPECT_NEAR(furnace.mean(furnace.inside, true, &direct) / whole, 1.0, 0.02);
    const std::vector<std::uint32_t> which = all(furnace.inside);
    std::vector<Rgb> irradiance(which.size());
    direct.estimate(which, irradiance);
    double sum = 0;
    for (const Rgb& e : irradiance) sum += static_cast<double>(e.x);
    // No noise: the light is in full view, the grid integrates 24 × 24 cells of a smooth function.
    EXPECT_NEAR(sum / static_cast<double>(irradiance.size()) / (watts / area), 1.0, 0.002);
    EXPECT_EQ(direct.raysTraced(), irradiance.size());
}

TEST(Furnace, NearestLosesHalfAtEdgesAndThreeQuartersInCorners) {
    const Furnace furnace(true);
    const double edge = furnace.mean(furnace.edges, false) / furnace.mean(furnace.edges, true);
    const double corner = furnace.mean(furnace.corners, false) / furnace.mean(furnace.corners, true);
    EXPECT_NEAR(edge, 0.5, 0.04);
    EXPECT_NEAR(corner, 0.25, 0.04);
    // A little beside the edge both see their whole disc. There the truth is nearly that of the edge; what is left is
    // the fall of direct light towards the edge, 4 % on 3 of 64 units.
    const double beside = furnace.mean(furnace.besideEdges, true);
    EXPECT_NEAR(furnace.mean(furnace.besideEdges, false) / beside, 1.0, 0.03);
    EXPECT_NEAR(furnace.mean(furnace.edges, true) / beside, 0.97, 0.04);
    EXPECT_NEAR(furnace.mean(furnace.edges, false) / beside, 0.485, 0.04);
}

} // namespace
} // namespace pie::gather
