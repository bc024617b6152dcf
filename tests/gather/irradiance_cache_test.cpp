#include "pie/gather/irradiance_cache.h"
#include "tests/gather/scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace pie::gather {
namespace {

const Vec3 up(0.0F, 0.0F, 1.0F);

TEST(IrradianceCache, WeighsByDistanceAndTurn) {
    IrradianceCache cache(0.25F);
    EXPECT_EQ(cache.add(Vec3(0.0F), up, 40.0F, false), 0U);
    EXPECT_EQ(cache.add({10.0F, 0.0F, 0.0F}, up, 40.0F, false), 1U);
    std::vector<IrradianceCache::Weight> found;
    cache.interpolate({5.0F, 0.0F, 0.0F}, up, false, found);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_FLOAT_EQ(found[0].weight, 0.5F);
    EXPECT_FLOAT_EQ(found[1].weight, 0.5F);
    cache.interpolate({2.0F, 0.0F, 0.0F}, up, false, found);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_GT(found[0].weight, 0.8F);
    cache.interpolate({-9.0F, 0.0F, 0.0F}, up, false, found);
    ASSERT_EQ(found.size(), 1U) << "19 of 40 is past the accuracy";
    EXPECT_EQ(found[0].record, 0U);
    cache.interpolate({5.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}, false, found);
    EXPECT_TRUE(found.empty()) << "another wall";
    cache.interpolate({5.0F, 0.0F, 0.0F}, up, true, found);
    EXPECT_TRUE(found.empty()) << "another kind";
    cache.interpolate({0.0F, 0.0F, -3.0F}, up, false, found);
    EXPECT_TRUE(found.empty()) << "behind the record";
}

Vec3 alongAnAxis(std::mt19937& random) {
    Vec3 normal(0.0F);
    normal[static_cast<int>(random() % 3)] = random() % 2 == 0 ? 1.0F : -1.0F;
    return normal;
}

// Against looking at every record.
TEST(IrradianceCache, FindsEveryRecordThatHolds) {
    std::mt19937 random(9);
    constexpr float accuracy = 0.3F;
    IrradianceCache cache(accuracy);
    struct Record {
        Vec3 position, normal;
        float radius;
    };
    std::vector<Record> records;
    for (int i = 0; i < 3000; ++i) {
        const Record record{1000.0F * test::unit3(random) - 500.0F, alongAnAxis(random),
                            std::exp2(12.0F * test::unit(random) - 2)};
        records.push_back(record);
        cache.add(record.position, record.normal, record.radius, false);
    }
    std::vector<IrradianceCache::Weight> found;
    std::size_t total = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p = 1000.0F * test::unit3(random) - 500.0F;
        const Vec3 n = alongAnAxis(random);
        cache.interpolate(p, n, false, found);
        std::map<std::uint32_t, float> have;
        float sum = 0;
        for (const auto& [record, weight] : found) {
            EXPECT_TRUE(have.emplace(record, weight).second) << "twice";
            sum += weight;
        }
        if (!found.empty()) {
            EXPECT_NEAR(sum, 1.0F, 1e-5F);
        }
        for (std::uint32_t r = 0; r < records.size(); ++r) {
            const Record& record = records[r];
            const float error = glm::length(p - record.position) / record.radius +
                                std::sqrt(std::max(0.0F, 1 - glm::dot(n, record.normal)));
            const bool front = glm::dot(p - record.position, n + record.normal) >= -0.1F * record.radius;
            if (std::abs(error - accuracy) < 1e-4F) continue;
            EXPECT_EQ(have.count(r), error < accuracy && front ? 1U : 0U);
            total += have.count(r);
        }
    }
    EXPECT_GT(total, 500U);
}

} // namespace
} // namespace pie::gather
