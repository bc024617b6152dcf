#include "pie/core/vec.h"
#include "pie/sampling/halton.h"
#include "tests/sampling/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <vector>

namespace pie::sampling {
namespace {

constexpr std::uint64_t largest = std::numeric_limits<std::uint64_t>::max();
constexpr double rounding = 0x1p-23;

TEST(Halton, BasesAreTheFirstPrimes) {
    EXPECT_EQ(haltonBase(0), 2U);
    EXPECT_EQ(haltonBase(5), 13U);
    EXPECT_EQ(haltonBase(127), 719U);
    for (unsigned d = 0; d < haltonDimensions; ++d) {
        for (std::uint32_t divisor = 2; divisor * divisor <= haltonBase(d); ++divisor)
            EXPECT_NE(haltonBase(d) % divisor, 0U);
        if (d > 0) {
            EXPECT_GT(haltonBase(d), haltonBase(d - 1));
        }
    }
}

TEST(Halton, RadicalInverseMirrorsTheDigits) {
    EXPECT_EQ(radicalInverse(0, 0), 0.0F);
    EXPECT_EQ(radicalInverse(1, 0), 0.5F);
    EXPECT_EQ(radicalInverse(6, 0), 0.375F);
    EXPECT_FLOAT_EQ(radicalInverse(5, 1), 7.0F / 9.0F);     // 12 in base 3 becomes 0.21
    EXPECT_FLOAT_EQ(radicalInverse(38, 2), 86.0F / 125.0F); // 123 in base 5 becomes 0.321
}

TEST(Halton, SeedZeroIsThePlainSequenceInSixDimensions) {
    const Halton halton;
    std::mt19937_64 random(1);
    for (int i = 0; i < 20'000; ++i) {
        const std::uint64_t index = random() >> static_cast<unsigned>(random() % 64);
        for (unsigned d = 0; d < 6; ++d)
            ASSERT_NEAR(halton(index, d), radicalInverse(index, d), 2e-7) << index << ' ' << d;
    }
}

TEST(Halton, StaysBelowOne) {
    std::mt19937_64 random(2);
    for (const std::uint64_t seed : {0U, 1U, 77U}) {
        const Halton halton(seed);
        for (unsigned d = 0; d < haltonDimensions + 40; ++d) {
            std::uint64_t power = 1;
            for (unsigned k = 0; k < 64; ++k, power *= haltonBase(d))
                for (const std::uint64_t index : {power - 1, power, largest - k, random()}) {
                    const float u = halton(index, d);
                    ASSERT_GE(u, 0.0F);
                    ASSERT_LT(u, 1.0F);
                    ASSERT_LT(radicalInverse(index, d), 1.0F);
                }
        }
    }
}

/// Any b^k consecutive indices fall one into each of b^k spans: what makes the sequence well distributed, and true of
/// permuted digits only if every permutation is one.
TEST(Halton, ConsecutiveIndicesAreStratified) {
    std::mt19937_64 random(3);
    for (const std::uint64_t seed : {0U, 5U}) {
        const Halton halton(seed);
        for (unsigned d = 0; d < haltonDimensions + 8; ++d) {
            std::uint64_t spans = haltonBase(d);
            while (spans * haltonBase(d) <= 2048) spans *= haltonBase(d);
            for (const std::uint64_t start :
                 {std::uint64_t{0}, random() % 100'000, random() % (std::uint64_t{1} << 40U)}) {
                std::vector<float> values;
                for (std::uint64_t i = 0; i < spans; ++i) values.push_back(halton(start + i, d));
                std::sort(values.begin(), values.end());
                for (std::size_t i = 0; i < values.size(); ++i) {
                    ASSERT_GE(values[i] * static_cast<double>(spans),
                              static_cast<double>(i) - rounding * static_cast<double>(spans))
                        << d;
                    ASSERT_LE(values[i] * static_cast<double>(spans),
                              static_cast<double>(i + 1) + rounding * static_cast<double>(spans))
                        << d;
                }
            }
        }
    }
}

/// Selective photon tracing, eq 3: |Φ(i) − Φ(i + m l b^k)| < b^-k, for permuted digits too.
TEST(Halton, IndicesThatDifferByAMultipleOfAPowerAgreeInTheLeadingDigits) {
    std::mt19937_64 random(4);
    for (const std::uint64_t seed : {0U, 9U}) {
        const Halton halton(seed);
        for (unsigned d = 0; d < haltonDimensions + 8; ++d) {
            std::uint64_t power = 1;
            for (unsigned k = 0; power < 1'000'000; ++k, power *= haltonBase(d))
                for (int repeat = 0; repeat < 20; ++repeat) {
                    const std::uint64_t index = random() % (std::uint64_t{1} << 36U);
                    const std::uint64_t other = index + (random() % 1000) * power;
                    ASSERT_LE(std::abs(static_cast<double>(halton(index, d)) - halton(other, d)),
                              1.0 / static_cast<double>(power) + rounding)
                        << "dimension " << d << " digits " << k << " indices " << index << ' ' << other;
                }
        }
    }
}

/// eq 5: one step N_g keeps the leading digits of several dimensions at once.
TEST(Halton, GroupsAreCoherentInAllTheirDimensions) {
    const Halton halton(0);
    constexpr std::uint64_t group = 32ULL * 9 * 5 * 7; // 10,080, as in the paper
    constexpr std::array<double, 4> spans{32, 9, 5, 7};
    for (std::uint64_t index = 0; index < 5000; index += 7)
        for (std::uint64_t m = 1; m < 40; m += 3)
            for (unsigned d = 0; d < spans.size(); ++d)
                ASSERT_LE(std::abs(static_cast<double>(halton(index, d)) - halton(index + m * group, d)),
                          1.0 / spans[d] + rounding);
}

TEST(Halton, RunsOfIndicesEqualSingleOnes) {
    const Halton halton(6);
    std::vector<float> run(3000);
    for (const unsigned d : {0U, 1U, 6U, 40U, 127U, 131U})
        for (const std::uint64_t first :
             {std::uint64_t{0}, std::uint64_t{1023}, std::uint64_t{4294966000}, largest - 3000}) {
            halton.fill(first, d, run);
            for (std::size_t i = 0; i < run.size(); ++i)
                ASSERT_EQ(run[i], halton(first + i, d)) << d << ' ' << first + i;
        }
}

TEST(Halton, PairsOfDimensionsAreSpreadBetterThanRandomPoints) {
    constexpr std::size_t count = 1024;
    for (const std::uint64_t seed : {0U, 3U}) {
        const Halton halton(seed);
        for (unsigned d = 0; d + 1 < 32; ++d) {
            std::vector<Vec2> points;
            for (std::uint64_t i = 0; i < count; ++i) points.emplace_back(halton(i, d), halton(i, d + 1));
            // Small bases have walked through all their pairs of digits many times; large ones have not.
            EXPECT_LT(test::starDiscrepancy(points), (d < 3   ? 0.25
                                                      : d < 6 ? 0.5
                                                              : 1.0) *
                                                         test::randomStarDiscrepancy(count))
                << d << ' ' << seed;
        }
    }
}

TEST(Halton, SeedsAndDimensionsPastTheTableHaveTheirOwnPermutations) {
    std::set<float> seen;
    for (std::uint64_t seed = 0; seed < 50; ++seed) seen.insert(Halton(seed)(123456, 20));
    EXPECT_GT(seen.size(), 45U);
    const Halton halton(0);
    int differ = 0;
    for (std::uint64_t i = 1; i < 100; ++i) differ += halton(i, 3) != halton(i, 3 + haltonDimensions) ? 1 : 0;
    EXPECT_GT(differ, 80);
}

/// Over seeds a number is uniform whatever its address: seeds are usable as independent repetitions.
TEST(Halton, IsUniformOverSeeds) {
    constexpr std::size_t seeds = 500;
    constexpr std::size_t bins = 16;
    constexpr std::array<unsigned, 5> dimensions{0, 1, 2, 7, 130};
    std::array<std::array<double, bins>, dimensions.size()> observed{};
    std::array<double, bins> expected{};
    expected.fill(static_cast<double>(seeds) / bins);
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        const Halton halton(seed);
        for (std::size_t k = 0; k < dimensions.size(); ++k)
            ++observed[k][static_cast<std::size_t>(halton(4711, dimensions[k]) * bins)];
    }
    for (std::size_t k = 0; k < dimensions.size(); ++k)
        EXPECT_LT(test::chiSquareDeviate(observed[k], expected), 5.0) << dimensions[k]; // false alarm 3e-7 each
}

TEST(Halton, HashIsUniformInBothArguments) {
    constexpr std::size_t bins = 64;
    for (const bool second : {false, true}) {
        std::array<double, bins> observed{};
        std::array<double, bins> expected{};
        expected.fill(65536.0 / bins);
        for (std::uint64_t i = 0; i < 65536; ++i) {
            const float u = second ? hash01(5, i) : hash01(i, 5);
            ASSERT_GE(u, 0.0F);
            ASSERT_LT(u, 1.0F);
            ++observed[static_cast<std::size_t>(u * bins)];
        }
        EXPECT_LT(test::chiSquareDeviate(observed, expected), 5.0);
    }
    EXPECT_NE(hash01(1, 2), hash01(2, 1));
}

} // namespace
} // namespace pie::sampling
