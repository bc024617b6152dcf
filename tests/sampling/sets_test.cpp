// What each kind of set promises beyond uniformity.

#include "pie/sampling/sequence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

namespace pie::sampling {
namespace {

TEST(Hash, PermutationsAreOnes) {
    for (const std::uint64_t count : {1U, 2U, 3U, 36U, 1000U, 1024U, 1025U, 4099U})
        for (const std::uint64_t key : {0U, 1U, 99U}) {
            std::vector<bool> seen(count, false);
            for (std::uint64_t i = 0; i < count; ++i) {
                const std::uint64_t to = permuted(i, count, mix(key));
                ASSERT_LT(to, count);
                ASSERT_FALSE(seen[to]) << count << ' ' << key;
                seen[to] = true;
            }
        }
    std::set<std::uint64_t> places;
    for (std::uint64_t key = 0; key < 500; ++key) places.insert(permuted(17, 1000, mix(key)));
    EXPECT_GT(places.size(), 350U) << "keys make permutations of their own"; // 394 are expected of random ones
    EXPECT_LT(permuted(~std::uint64_t{0} - 1, ~std::uint64_t{0}, 5), ~std::uint64_t{0});
}

/// The first points as published: dimension 1 mirrors the bits, dimension 2 goes 0, 1/2, 3/4, 1/4, 3/8 …
TEST(Sobol, StartsAsItShould) {
    const std::vector<double> second{0, 0.5, 0.75, 0.25, 0.375, 0.875, 0.625, 0.125};
    const std::vector<double> third{0, 0.5, 0.25, 0.75, 0.375, 0.875, 0.125, 0.625};
    // Columns as indices run; Sobol's original order, not that of Gray codes.
    const std::vector<double> first{0, 0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875};
    std::vector<double> columns[3];
    for (std::uint32_t i = 0; i < 8; ++i)
        for (unsigned c = 0; c < 3; ++c) columns[c].push_back(sobolBits(i, c) * 0x1p-32);
    EXPECT_EQ(columns[0], first);
    const auto sorted = [](std::vector<double> v) { return std::sort(v.begin(), v.end()), v; };
    EXPECT_EQ(sorted(columns[1]), sorted(second));
    EXPECT_EQ(sorted(columns[2]), sorted(third));
    EXPECT_EQ(columns[1][1], 0.5);
    EXPECT_EQ(columns[1][2], 0.75);
    EXPECT_EQ(columns[1][3], 0.25);
}

/// Any aligned 2^k indices fall one into each of 2^k spans, in every dimension and for padded ones too.
TEST(Sobol, EveryDimensionIsStratified) {
    const Sobol sobol(12);
    for (unsigned d = 0; d < 40; ++d)
        for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{7} * 1024, std::uint64_t{5} << 40U}) {
            std::vector<bool> taken(1024, false);
            for (std::uint64_t i = 0; i < 1024; ++i) {
                const auto span = static_cast<std::size_t>(1024.0F * sobol(first + i, d));
                ASSERT_FALSE(taken[span]) << d << ' ' << first;
                taken[span] = true;
            }
        }
}

/// The direction of emission, and that of every padded reflection, is a (0, 2)-sequence: each of 2^k indices lies in a
/// cell of its own, whatever the cells' proportions.
TEST(Sobol, DirectionsAreNets) {
    const Sobol sobol(3);
    for (const unsigned d : {1U, 11U, 17U})
        for (unsigned across = 0; across <= 8; ++across) {
            std::vector<bool> taken(256, false);
            for (std::uint64_t i = 0; i < 256; ++i) {
                const Vec2 u = sobol.pair(1024 + i, d);
                const auto x = static_cast<std::size_t>(std::ldexp(u.x, static_cast<int>(across)));
                const auto y = static_cast<std::size_t>(std::ldexp(u.y, 8 - static_cast<int>(across)));
                const std::size_t cell = (x << (8 - across)) + y;
                ASSERT_FALSE(taken[cell]) << d << ' ' << across;
                taken[cell] = true;
            }
        }
}

/// Owen's scrambling: a value's leading bits depend on its leading bits alone, so spans stay spans.
TEST(Sobol, ScramblingIsNested) {
    for (std::uint32_t key = 1; key < 2000; key += 97)
        for (std::uint32_t x = 0; x < 4000; x += 13) {
            const std::uint32_t value = x * 2654435761U;
            for (unsigned bits = 1; bits < 32; bits += 3) {
                const std::uint32_t mask = ~std::uint32_t{0} << (32 - bits);
                const std::uint32_t other = value ^ ((x + 1) * 2246822519U >> bits);
                const auto scrambled = [&](std::uint32_t v) {
                    return detail::reversed(detail::scrambleReversed(detail::reversed(v), key * 0x9e3779b9U));
                };
                ASSERT_EQ((scrambled(value) ^ scrambled(other)) & mask, 0U);
            }
        }
}

/// R2: the smallest distance between n points, wrapped, stays near that of a lattice; random ones have 1/n of it.
TEST(Kronecker, PointsKeepTheirDistance) {
    const Kronecker r2(1);
    for (const unsigned d : {1U, 5U, 8U, 32U}) {
        constexpr std::size_t count = 512;
        double smallest = 1.0;
        std::vector<Vec2> points;
        for (std::uint64_t i = 0; i < count; ++i) points.push_back(r2.pair(i, d));
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < i; ++k) {
                glm::dvec2 off = glm::abs(glm::dvec2(points[i]) - glm::dvec2(points[k]));
                off = glm::min(off, 1.0 - off);
                smallest = std::min(smallest, glm::length(off));
            }
        EXPECT_GT(smallest * std::sqrt(static_cast<double>(count)), d == 1 || d == 5 ? 0.15 : 0.5) << d;
    }
}

/// One point in each stratum, for numbers of photons with and without factors.
TEST(Stratified, OnePointAStratum) {
    for (const std::uint64_t count : {1U, 2U, 7U, 36U, 1009U, 10'000U}) {
        const Stratified stratified(4, count);
        for (const unsigned d : {0U, 1U, 5U, 7U, 300U})
            for (const std::uint64_t frame : {0U, 3U}) {
                std::vector<float> numbers;
                std::vector<float> heights;
                for (std::uint64_t i = 0; i < count; ++i) {
                    numbers.push_back(stratified(frame * count + i, d));
                    heights.push_back(stratified.pair(frame * count + i, d).x);
                }
                std::sort(numbers.begin(), numbers.end());
                for (std::size_t i = 0; i < numbers.size(); ++i) {
                    ASSERT_GE(numbers[i] * static_cast<double>(count), static_cast<double>(i) - 1e-3);
                    ASSERT_LE(numbers[i] * static_cast<double>(count), static_cast<double>(i + 1) + 1e-3);
                }
                // Rings: the share of points below a ring's bound is the bound.
                std::sort(heights.begin(), heights.end());
                const double ring = std::sqrt(3.0 / static_cast<double>(count)) + 2.0 / static_cast<double>(count);
                for (std::size_t i = 0; i < heights.size(); ++i)
                    ASSERT_NEAR(heights[i], (static_cast<double>(i) + 0.5) / static_cast<double>(count), ring);
            }
    }
}

/// Points of the spiral are as far apart as a triangular lattice would have them, all over the sphere.
TEST(Spiral, PointsKeepTheirDistance) {
    for (const std::uint64_t count : {36U, 500U, 2000U}) {
        const Spiral spiral(1, count, 36);
        std::vector<Vec3> points;
        for (std::uint64_t i = 0; i < count; ++i) points.push_back(uniformSphere(spiral.pair(i, 5)));
        double mean = 0.0;
        for (const Vec3& p : points) {
            double nearest = 4.0;
            for (const Vec3& q : points)
                if (&p != &q) nearest = std::min<double>(nearest, glm::length(p - q));
            mean += nearest / static_cast<double>(count);
        }
        // sqrt(8 π / (√3 n)) is the lattice's distance; random points have sqrt(π / n), under half of it.
        EXPECT_NEAR(mean / std::sqrt(8.0 * std::numbers::pi / (std::sqrt(3.0) * static_cast<double>(count))), 0.9, 0.12)
            << count;
    }
}

/// Photons of one light are a run of a frame: they have the spread of a set, not of a heap.
TEST(Framed, RunsOfAFrameAreSpread) {
    const Spiral spiral(2, 10'000, 36);
    const Stratified stratified(2, 10'000);
    for (const std::uint64_t first : {100U, 4000U, 9500U}) {
        std::vector<float> heights;
        std::vector<float> strata;
        for (std::uint64_t i = first; i < first + 200; ++i) {
            const float step = spiral(i + 1, 0) - spiral(i, 0);
            EXPECT_NEAR(step < 0.0F ? step + 1.0F : step, 1e-4F, 2e-7F) << "a light's photons are a run";
            heights.push_back(spiral.pair(i, 1).x);
            strata.push_back(stratified.pair(i, 1).x);
        }
        std::sort(heights.begin(), heights.end());
        std::sort(strata.begin(), strata.end());
        for (std::size_t i = 0; i < heights.size(); ++i) {
            EXPECT_NEAR(heights[i], (static_cast<float>(i) + 0.5F) / 200.0F, 0.015F);
            EXPECT_NEAR(strata[i], (static_cast<float>(i) + 0.5F) / 200.0F, 0.03F);
        }
    }
}

} // namespace
} // namespace pie::sampling
