#include "pie/maps/nearest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace pie::maps {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

std::vector<Neighbour> sorted(std::span<const Neighbour> found) {
    std::vector<Neighbour> list(found.begin(), found.end());
    std::sort(list.begin(), list.end());
    return list;
}

TEST(NearestQueue, KeepsTheSmallestOfRandomOffers) {
    std::mt19937 random(11);
    for (int round = 0; round < 2000; ++round) {
        const std::size_t k = random() % 20;
        std::vector<Neighbour> offers(random() % 60);
        for (std::size_t i = 0; i < offers.size(); ++i)
            offers[i] = {static_cast<float>(random() % 10), static_cast<std::uint32_t>(i)};
        std::shuffle(offers.begin(), offers.end(), random);
        NearestQueue queue;
        queue.reset(k, infinity);
        for (const Neighbour& offer : offers) queue.offer(offer);
        std::sort(offers.begin(), offers.end());
        offers.resize(std::min(k, offers.size()));
        ASSERT_EQ(sorted(queue.found()), offers);
        if (queue.full()) {
            ASSERT_EQ(queue.farthest(), offers.back());
            ASSERT_EQ(queue.reach(), offers.back().distanceSquared);
        }
    }
}

TEST(NearestQueue, ReachIncludesItsBorderAndShrinksOnceFull) {
    NearestQueue queue;
    queue.reset(2, 4.0F);
    queue.offer({4.5F, 0});
    EXPECT_TRUE(queue.found().empty());
    queue.offer({4.0F, 7});
    EXPECT_EQ(queue.reach(), 4.0F);
    queue.offer({1.0F, 8});
    EXPECT_TRUE(queue.full());
    EXPECT_EQ(queue.reach(), 4.0F);
    queue.offer({4.0F, 3}); // as far as photon 7, but before it
    EXPECT_EQ(queue.farthest(), (Neighbour{4.0F, 3}));
    queue.offer({2.0F, 9});
    EXPECT_EQ(queue.reach(), 2.0F);
}

TEST(NearestQueue, AcceptsNothingForNoneOrNoReach) {
    NearestQueue queue;
    queue.reset(0, infinity);
    queue.offer({0.0F, 0});
    EXPECT_TRUE(queue.found().empty());
    EXPECT_FALSE(queue.full());
    for (const float reach : {-1.0F, std::numeric_limits<float>::quiet_NaN()}) {
        queue.reset(3, reach);
        queue.offer({0.0F, 0});
        EXPECT_TRUE(queue.found().empty());
    }
}

TEST(NearestQueue, AHugeKCostsNothing) {
    NearestQueue queue;
    queue.reset(std::numeric_limits<std::size_t>::max(), infinity);
    for (std::uint32_t i = 0; i < 10000; ++i) queue.offer({1.0F, i});
    EXPECT_EQ(queue.found().size(), 10000U);
    EXPECT_FALSE(queue.full());
}

TEST(Neighbour, OrdersByDistanceThenNumber) {
    const float denormal = std::numeric_limits<float>::denorm_min();
    const std::vector<Neighbour> ascending{{0.0F, 0}, {0.0F, 4000000000U}, {denormal, 0}, {1e-30F, 5},  {1.0F, 1},
                                           {1.0F, 2}, {3e38F, 0},          {infinity, 0}, {infinity, 9}};
    for (std::size_t i = 0; i < ascending.size(); ++i)
        for (std::size_t j = 0; j < ascending.size(); ++j)
            EXPECT_EQ(ascending[i] < ascending[j], i < j) << i << " " << j;
}

} // namespace
} // namespace pie::maps
