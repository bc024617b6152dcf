// Every distribution: in range, addressed, uniform over seeds and frames, of the promised law over indices.

#include "pie/sampling/sequence.h"
#include "tests/sampling/distributions.h"
#include "tests/sampling/statistics.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace pie::sampling {
namespace {

constexpr std::uint64_t largest = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t frame = 1000;
constexpr std::array<unsigned, 8> someDimensions{0, 1, 3, 5, 7, 9, 17, 200};

Sequence make(Distribution distribution, std::uint64_t seed = 0) {
    return makeSequence(distribution, {seed, frame, 36});
}

float number(const Sequence& sequence, std::uint64_t index, unsigned dimension) {
    return std::visit([&](const auto& s) { return s(index, dimension); }, sequence);
}
Vec2 pair(const Sequence& sequence, std::uint64_t index, unsigned dimension) {
    return std::visit([&](const auto& s) { return s.pair(index, dimension); }, sequence);
}
Vec3 cosineDirection(const Sequence& sequence, std::uint64_t index, unsigned dimension) {
    return std::visit([&](const auto& s) { return cosine(s, index, dimension); }, sequence);
}
Vec3 sphereDirection(const Sequence& sequence, std::uint64_t index, unsigned dimension) {
    Vec2 u;
    fillDirections(sequence, index, dimension, std::span(&u.x, 1), std::span(&u.y, 1));
    return uniformSphere(u);
}

/// Cells of equal measure: of the sphere, or of the hemisphere under a cosine law.
constexpr int rings = 8;
constexpr int sectors = 12;
std::size_t cellOf(double share, const Vec3& d) {
    const double turn = std::atan2(d.y, d.x) / (2.0 * std::numbers::pi);
    const int ring = std::clamp(static_cast<int>(share * rings), 0, rings - 1);
    const int sector = std::clamp(static_cast<int>((turn < 0.0 ? turn + 1.0 : turn) * sectors), 0, sectors - 1);
    return static_cast<std::size_t>(ring * sectors + sector);
}
std::size_t sphereCell(const Vec3& d) { return cellOf(0.5 * (1.0 - static_cast<double>(d.z)), d); }
std::size_t cosineCell(const Vec3& d) { return cellOf(1.0 - static_cast<double>(d.z) * d.z, d); }

/// Counts what `cell` gives for 0 … count - 1 and compares with equal shares; 5 is passed once in 3.5 million.
template <class Cell> double deviate(std::size_t cells, std::size_t count, const Cell& cell) {
    std::vector<double> observed(cells, 0.0);
    const std::vector<double> expected(cells, static_cast<double>(count) / static_cast<double>(cells));
    for (std::size_t i = 0; i < count; ++i) ++observed[cell(i)];
    return test::chiSquareDeviate(observed, expected);
}

class EveryDistribution : public testing::TestWithParam<Distribution> {};
INSTANTIATE_TEST_SUITE_P(Sequence, EveryDistribution, testing::ValuesIn(test::allDistributions),
                         [](const auto& test) { return pie::test::distributionName(test.param); });

TEST_P(EveryDistribution, NumbersLieInTheUnitInterval) {
    std::mt19937_64 random(1);
    for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{7}, largest}) {
        const Sequence sequence = make(GetParam(), seed);
        for (int i = 0; i < 5000; ++i) {
            const std::uint64_t index = i < 100 ? largest - static_cast<unsigned>(i) : random() >> (random() % 64);
            for (const unsigned d : someDimensions) {
                const float u = number(sequence, index, d);
                ASSERT_TRUE(u >= 0.0F && u < 1.0F) << index << ' ' << d;
                const Vec2 p = pair(sequence, index, d);
                ASSERT_TRUE(p.x >= 0.0F && p.x < 1.0F && p.y >= 0.0F && p.y < 1.0F) << index << ' ' << d;
                const Vec3 w = cosineDirection(sequence, index, d);
                ASSERT_NEAR(glm::length(w), 1.0F, 3e-7F);
                ASSERT_GE(w.z, 0.0F);
                ASSERT_NEAR(glm::length(sphereDirection(sequence, index, d)), 1.0F, 3e-7F);
            }
        }
    }
}

TEST_P(EveryDistribution, RunsOfIndicesEqualSingleOnes) {
    const Sequence sequence = make(GetParam(), 5);
    std::vector<float> x(700);
    std::vector<float> y(700);
    for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{990}, std::uint64_t{4294966900}, largest - 700})
        for (const unsigned d : someDimensions) {
            fill(sequence, first, d, x);
            for (std::size_t i = 0; i < x.size(); ++i) ASSERT_EQ(x[i], number(sequence, first + i, d)) << d << ' ' << i;
            fillPairs(sequence, first, d, x, y);
            for (std::size_t i = 0; i < x.size(); ++i) ASSERT_EQ(Vec2(x[i], y[i]), pair(sequence, first + i, d));
            fillDirections(sequence, first, d, x, y);
            for (std::size_t i = 0; i < x.size(); ++i)
                ASSERT_EQ(uniformSphere({x[i], y[i]}), sphereDirection(sequence, first + i, d));
        }
}

TEST_P(EveryDistribution, TheSameSeedGivesTheSameNumbersAndAnotherOthers) {
    const Sequence one = make(GetParam(), 3);
    const Sequence same = make(GetParam(), 3);
    const Sequence other = make(GetParam(), 4);
    int differ = 0;
    for (std::uint64_t i = 1; i < 500; ++i) {
        ASSERT_EQ(pair(one, 7 * i, 9), pair(same, 7 * i, 9));
        differ += pair(one, 7 * i, 9) != pair(other, 7 * i, 9) ? 1 : 0;
    }
    EXPECT_GT(differ, 450);
}

/// Over indices of many frames directions follow their law.
TEST_P(EveryDistribution, DirectionsFollowTheirLaw) {
    constexpr std::size_t cells = rings * sectors;
    const Sequence sequence = make(GetParam(), 11);
    for (const unsigned d : {1U, 5U, 8U, 26U, 150U}) {
        EXPECT_LT(
            deviate(cells, 100 * frame, [&](std::size_t i) { return cosineCell(cosineDirection(sequence, i, d)); }),
            5.0)
            << "cosine, dimension " << d;
        EXPECT_LT(
            deviate(cells, 100 * frame, [&](std::size_t i) { return sphereCell(sphereDirection(sequence, i, d)); }),
            5.0)
            << "sphere, dimension " << d;
    }
    for (const unsigned d : {0U, 7U, 10U, 151U})
        EXPECT_LT(deviate(64, 100 * frame,
                          [&](std::size_t i) { return static_cast<std::size_t>(64.0F * number(sequence, i, d)); }),
                  5.0)
            << "number, dimension " << d;
}

/// A single index is uniform over seeds (over frames, where it has one): estimates are right in the mean, whatever the
/// number of photons. (Halton's seeds: halton_test.)
TEST_P(EveryDistribution, OneIndexIsUniformOverSeedsAndFrames) {
    if (GetParam() == Distribution::Halton) GTEST_SKIP() << "500 seeds of it are tested in Halton.IsUniformOverSeeds";
    constexpr std::size_t repetitions = 40'000;
    constexpr std::size_t cells = rings * sectors;
    for (const std::uint64_t index : {std::uint64_t{0}, std::uint64_t{999}, std::uint64_t{123'456}})
        for (const unsigned d : {1U, 5U, 11U, 200U})
            EXPECT_LT(deviate(cells, repetitions,
                              [&](std::size_t i) {
                                  const Sequence sequence = makeSequence(GetParam(), {i, 50, 1});
                                  return cosineCell(cosineDirection(sequence, index, d));
                              }),
                      5.0)
                << index << ' ' << d;
    if (GetParam() != Distribution::Stratified && GetParam() != Distribution::Spiral) return;
    const Sequence sequence = make(GetParam(), 2);
    for (const std::uint64_t within : {std::uint64_t{0}, frame / 3, frame - 1})
        for (const unsigned d : {5U, 11U, 200U})
            EXPECT_LT(
                deviate(cells, repetitions,
                        [&](std::size_t i) { return cosineCell(cosineDirection(sequence, within + i * frame, d)); }),
                5.0)
                << within << ' ' << d;
}

/// Two reflections of a photon know nothing of each other: over indices each pair of cells is as likely.
TEST_P(EveryDistribution, ReflectionsAreUnrelated) {
    const Sequence sequence = make(GetParam(), 6);
    const auto coarse = [](const Vec3& w) {
        return static_cast<std::size_t>((w.z * w.z < 0.5F ? 1 : 0) + (w.x < 0.0F ? 2 : 0) + (w.y < 0.0F ? 4 : 0));
    };
    for (const auto& [a, b] : {std::pair(1U, 5U), std::pair(5U, 8U), std::pair(8U, 11U), std::pair(11U, 14U),
                               std::pair(11U, 23U), std::pair(128U, 131U)})
        EXPECT_LT(deviate(64, 100 * frame,
                          [&, a = a, b = b](std::size_t i) {
                              return 8 * coarse(cosineDirection(sequence, i, a)) +
                                     coarse(cosineDirection(sequence, i, b));
                          }),
                  5.0)
            << a << ' ' << b;
}

TEST_P(EveryDistribution, ChildrenOfASplitFollowTheirLawAndDiffer) {
    constexpr std::size_t cells = rings * sectors;
    constexpr std::uint32_t children = 36;
    const Sequence sequence = make(GetParam(), 8);
    for (const std::uint32_t branch : {0U, 17U}) {
        EXPECT_LT(
            deviate(cells, 36 * 3000,
                    [&](std::size_t i) {
                        const auto child = static_cast<std::uint32_t>(i % children);
                        return std::visit(
                            [&](const auto& s) { return cosineCell(fan(s, i / children, 5, branch, children)(child)); },
                            sequence);
                    }),
            5.0)
            << branch;
        // One child as well, where the bound on paths is reached.
        EXPECT_LT(deviate(cells, 100'000,
                          [&](std::size_t i) {
                              return std::visit([&](const auto& s) { return cosineCell(fan(s, i, 11, branch, 1)(0)); },
                                                sequence);
                          }),
                  5.0)
            << branch;
    }
    std::visit(
        [&](const auto& s) {
            const auto one = fan(s, 5, 8, 0, children);
            const auto sister = fan(s, 5, 8, 1, children);
            for (std::uint32_t j = 0; j < children; ++j) {
                EXPECT_NE(one(j), sister(j));
                EXPECT_NE(one(j), one((j + 1) % children));
            }
        },
        sequence);
}

/// What they are for: in a frame directions are spread more evenly than random ones, whose discrepancy is 1 here.
TEST_P(EveryDistribution, SpreadOfAFrame) {
    const bool random = GetParam() == Distribution::Explicit || GetParam() == Distribution::Rejection;
    for (const unsigned d : {1U, 5U}) {
        double ratio = 0.0;
        for (std::uint64_t seed = 1; seed <= 10; ++seed) {
            const Sequence sequence = make(GetParam(), seed);
            std::vector<Vec2> points;
            for (std::uint64_t i = 0; i < frame; ++i) points.push_back(pair(sequence, frame * seed + i, d));
            ratio += 0.1 * test::starDiscrepancy(points) / test::randomStarDiscrepancy(frame);
        }
        if (random)
            EXPECT_NEAR(ratio, 1.0, 0.25) << d;
        else
            EXPECT_LT(ratio, 0.45) << d;
    }
}

} // namespace
} // namespace pie::sampling
