// Searching allocates nothing.

#include "pie/maps/exact.h"
#include "pie/maps/kd_tree.h"
#include "tests/maps/clouds.h"
#include "tests/support/allocations.h"

#include <gtest/gtest.h>

namespace pie::maps {
namespace {

template <class Map> void expectNoAllocation() {
    const auto cloud = test::clouds(2000, 500).front();
    Map map;
    map.build(cloud.photons);
    NearestQueue queue;
    queue.reserve(200);
    std::size_t found = 0;
    const std::size_t before = pie::test::allocations();
    for (const Vec3& query : cloud.queries) {
        map.nearest(
            query, 200, 3.0F, [](const photons::Photon&) { return true; }, queue);
        found += queue.found().size();
        map.forEachWithin(query, 1.0F, [&](const photons::Photon&, float) { ++found; });
    }
    EXPECT_EQ(pie::test::allocations() - before, 0U);
    EXPECT_GT(found, 50000U);
}

TEST(Allocations, AreCounted) {
    const std::size_t before = pie::test::allocations();
    const std::vector<int> some(100);
    EXPECT_EQ(some.size(), 100U);
    EXPECT_EQ(pie::test::allocations() - before, 1U);
}

TEST(Allocations, NoneWhileSearchingTheKdTree) { expectNoAllocation<KdTree>(); }
TEST(Allocations, NoneWhileSearchingTheExactMap) { expectNoAllocation<ExactMap>(); }

} // namespace
} // namespace pie::maps
