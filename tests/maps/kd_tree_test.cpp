// The kd-tree answers exactly what the exact map answers.

#include "pie/core/parallel.h"
#include "pie/maps/exact.h"
#include "pie/maps/kd_tree.h"
#include "tests/maps/clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace pie::maps {
namespace {

using photons::Photon;
using test::Cloud;
using test::photonAt;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

const auto everything = [](const Photon&) { return true; };

template <class Map, class Accept>
std::vector<Neighbour> nearest(const Map& map, const Vec3& point, std::size_t k, float radius, Accept accept) {
    static thread_local NearestQueue queue;
    map.nearest(point, k, radius, accept, queue);
    std::vector<Neighbour> found(queue.found().begin(), queue.found().end());
    std::sort(found.begin(), found.end());
    return found;
}

template <class Map> std::vector<Neighbour> within(const Map& map, const Vec3& point, float radius) {
    std::vector<Neighbour> found;
    map.forEachWithin(point, radius, [&](const Photon& photon, float d) {
        found.push_back({d, static_cast<std::uint32_t>(&photon - map.photons().data())});
    });
    std::sort(found.begin(), found.end());
    return found;
}

struct Maps {
    ExactMap exact;
    KdTree tree;
    explicit Maps(const std::vector<Photon>& photons) {
        exact.build(photons);
        tree.build(photons);
    }
};

/// Radii that matter for a query: none, tiny, the very distance of some photon, everything.
float radiusFor(const Cloud& cloud, const Vec3& query, std::mt19937& random) {
    switch (random() % 6) {
    case 0: return 0.0F;
    case 1: return std::numeric_limits<float>::denorm_min();
    case 2: return infinity;
    case 3: return nan;
    default:
        return cloud.photons.empty()
                   ? 1.0F
                   : std::sqrt(distanceSquared(cloud.photons[random() % cloud.photons.size()].position, query));
    }
}

TEST(KdTree, FindsTheSameNearestAsTheExactMap) {
    std::size_t asked = 0;
    for (const std::size_t count : {0, 1, 2, 15, 16, 17, 33, 100, 501}) {
        for (const Cloud& cloud : test::clouds(count, 4000)) {
            const Maps maps(cloud.photons);
            std::mt19937 random(99);
            for (const Vec3& query : cloud.queries) {
                const std::size_t ks[] = {0, 1, 2, 7, 50, count, count + 1};
                const std::size_t k = ks[random() % std::size(ks)];
                const float radius = radiusFor(cloud, query, random);
                ASSERT_EQ(nearest(maps.tree, query, k, radius, everything),
                          nearest(maps.exact, query, k, radius, everything))
                    << cloud.name << ", " << count << " photons, k " << k << ", radius " << radius;
                ++asked;
            }
        }
    }
    EXPECT_EQ(asked, 9U * 10U * 4000U);
}

TEST(KdTree, FindsTheSameWithinARadiusAsTheExactMap) {
    for (const std::size_t count : {0, 1, 17, 300}) {
        for (const Cloud& cloud : test::clouds(count, 300)) {
            const Maps maps(cloud.photons);
            std::mt19937 random(98);
            for (const Vec3& query : cloud.queries) {
                const float radius = radiusFor(cloud, query, random);
                ASSERT_EQ(within(maps.tree, query, radius), within(maps.exact, query, radius)) << cloud.name;
            }
        }
    }
}

TEST(KdTree, FiltersWhileSearching) {
    for (const Cloud& cloud : test::clouds(400, 300)) {
        const Maps maps(cloud.photons);
        for (const std::uint32_t divisor : {2U, 97U, 1000U}) {
            const auto some = [divisor](const Photon& photon) { return photon.id % divisor == 1; };
            for (const Vec3& query : cloud.queries) {
                const auto found = nearest(maps.tree, query, 10, infinity, some);
                ASSERT_EQ(found, nearest(maps.exact, query, 10, infinity, some)) << cloud.name;
                // All that pass are found although hundreds of others are nearer.
                ASSERT_EQ(found.size(), divisor == 2 ? 10U : divisor == 97 ? 5U : 1U);
            }
        }
    }
}

TEST(KdTree, ASlabChangesNothingButTheWork) {
    std::mt19937 random(77);
    for (const Cloud& cloud : test::clouds(700, 1500)) {
        const Maps maps(cloud.photons);
        for (const Vec3& query : cloud.queries) {
            const Vec3 tilted = 2.0F * test::unit3(random) - 1.0F;
            const Vec3 normal = random() % 2 == 0 ? Vec3(0.0F, 0.0F, 1.0F) : tilted / glm::length(tilted);
            // Also borders that photons of the grid lie in exactly, and slabs as thin as rounding.
            const float thicknesses[] = {0.0F, 1.0F, 2.5F, 0.3F * test::unit(random), infinity};
            const Slab slab{normal, thicknesses[random() % 5]};
            std::size_t asked = 0;
            const auto inside = [&](const Photon& photon) {
                ++asked;
                return std::abs(glm::dot(photon.position - query, normal)) <= slab.halfThickness;
            };
            static thread_local NearestQueue queue;
            maps.tree.nearest(query, 20, 6.0F, slab, inside, queue);
            std::vector<Neighbour> found(queue.found().begin(), queue.found().end());
            std::sort(found.begin(), found.end());
            ASSERT_EQ(found, nearest(maps.exact, query, 20, 6.0F, inside)) << cloud.name;
            maps.exact.nearest(query, 20, 6.0F, slab, inside, queue);
            std::vector<Neighbour> exact(queue.found().begin(), queue.found().end());
            std::sort(exact.begin(), exact.end());
            ASSERT_EQ(found, exact);
        }
    }
}

TEST(KdTree, ASlabSparesTheFilterWhatLiesOutside) {
    const auto cloud = test::clouds(5000, 100).front();
    KdTree tree;
    tree.build(cloud.photons);
    NearestQueue queue;
    for (const Vec3& query : cloud.queries) {
        std::size_t outside = 0;
        tree.nearest(
            query, 5000, infinity, {{1.0F, 0.0F, 0.0F}, 0.5F},
            [&](const Photon& photon) {
                if (std::abs(photon.position.x - query.x) > 0.501F) ++outside;
                return true;
            },
            queue);
        EXPECT_EQ(outside, 0U);
    }
}

TEST(KdTree, TiesGoToTheLowestNumbers) {
    const std::vector<Photon> photons(1000, photonAt({1.0F, 2.0F, 3.0F}));
    const Maps maps(photons);
    for (const std::size_t k : {1U, 16U, 250U, 1000U}) {
        const auto found = nearest(maps.tree, {1.0F, 2.0F, 3.5F}, k, 10.0F, everything);
        ASSERT_EQ(found.size(), k);
        for (std::size_t i = 0; i < k; ++i) EXPECT_EQ(found[i], (Neighbour{0.25F, static_cast<std::uint32_t>(i)}));
    }
}

TEST(KdTree, TheBallIncludesItsSurface) {
    const Maps maps({photonAt({0.0F, 0.0F, 0.0F}), photonAt({3.0F, 4.0F, 0.0F})});
    EXPECT_EQ(nearest(maps.tree, {0.0F, 0.0F, 0.0F}, 9, 5.0F, everything).size(), 2U);
    EXPECT_EQ(nearest(maps.tree, {0.0F, 0.0F, 0.0F}, 9, std::nextafter(5.0F, 0.0F), everything).size(), 1U);
    EXPECT_EQ(nearest(maps.tree, {3.0F, 4.0F, 0.0F}, 9, 0.0F, everything).size(), 1U);
    EXPECT_EQ(nearest(maps.tree, {3.0F, 4.0F, 0.0F}, 9, -1.0F, everything).size(), 0U);
}

TEST(KdTree, PhotonsAndPointsThatAreNotFiniteAreNeverFound) {
    std::vector<Photon> photons;
    for (int i = 0; i < 200; ++i) photons.push_back(photonAt(Vec3(static_cast<float>(i), 0.0F, 0.0F)));
    for (const float bad : {nan, infinity, -infinity})
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 position(50.0F);
            position[axis] = bad;
            photons.insert(photons.begin() + 20 * (axis + 1), photonAt(position));
        }
    const Maps maps(photons);
    EXPECT_EQ(maps.tree.photons().size(), 209U);
    const auto found = nearest(maps.tree, {3.0F, 1.0F, 0.0F}, 1000, infinity, everything);
    EXPECT_EQ(found.size(), 200U);
    EXPECT_EQ(found, nearest(maps.exact, {3.0F, 1.0F, 0.0F}, 1000, infinity, everything));
    EXPECT_EQ(within(maps.exact, {3.0F, 1.0F, 0.0F}, infinity).size(), 200U);
    for (const float bad : {nan, infinity, -infinity}) {
        EXPECT_TRUE(nearest(maps.tree, {bad, 0.0F, 0.0F}, 5, infinity, everything).empty());
        EXPECT_TRUE(nearest(maps.exact, {bad, 0.0F, 0.0F}, 5, infinity, everything).empty());
        EXPECT_TRUE(within(maps.tree, {bad, 0.0F, 0.0F}, infinity).empty());
    }
    EXPECT_EQ(maps.tree.bounds().upper.x, 199.0F);
    EXPECT_EQ(maps.exact.bounds().upper.x, 199.0F);
}

/// What a search visits, in its order: shows the tree itself.
std::vector<std::uint32_t> order(const KdTree& tree) {
    std::vector<std::uint32_t> numbers;
    tree.forEachWithin({0.3F, 0.2F, 0.1F}, infinity,
                       [&](const Photon& photon, float) { numbers.push_back(photon.id); });
    return numbers;
}

TEST(KdTree, IsOneTreeOnAnyNumberOfThreads) {
    for (const Cloud& cloud : test::clouds(20000, 0)) {
        std::vector<std::vector<std::uint32_t>> orders;
        for (const unsigned count : {1U, 2U}) {
            setThreads(count);
            KdTree tree;
            tree.build(cloud.photons);
            orders.push_back(order(tree));
        }
        setThreads(0);
        EXPECT_EQ(orders[0].size(), 20000U);
        EXPECT_EQ(orders[0], orders[1]) << cloud.name;
    }
}

TEST(KdTree, CanBeBuiltAgain) {
    const auto cloud = test::clouds(500, 50).front();
    KdTree tree;
    tree.build(std::vector<Photon>(3000, photonAt({9.0F, 9.0F, 9.0F})));
    tree.build(cloud.photons);
    ExactMap exact;
    exact.build(cloud.photons);
    for (const Vec3& query : cloud.queries)
        ASSERT_EQ(nearest(tree, query, 20, infinity, everything), nearest(exact, query, 20, infinity, everything));
    EXPECT_EQ(tree.release().size(), 500U);
    EXPECT_TRUE(nearest(tree, {0.0F, 0.0F, 0.0F}, 20, infinity, everything).empty());
}

} // namespace
} // namespace pie::maps
