#include "pie/gather/gather_row.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <vector>

namespace pie::gather {
namespace {

constexpr std::uint32_t dark = 500;

std::vector<TexelLight::Radiosity> lights() {
    std::vector<TexelLight::Radiosity> radiosity(501);
    for (std::uint32_t i = 0; i < dark; ++i) {
        const auto light = static_cast<float>(i + 1);
        radiosity[i] = {light, 2 * light, 0.5F * light, 0.0F};
    }
    return radiosity;
}

std::map<std::uint32_t, float> partsOf(const GatherRow& row) {
    std::map<std::uint32_t, float> parts;
    row.forEach(1.0F, [&](std::uint32_t number, float rays) {
        EXPECT_TRUE(parts.emplace(number, rays).second) << number << " stands twice";
    });
    return parts;
}

TEST(GatherRow, KeepsWholeRaysExactly) {
    for (const std::uint32_t count : {0U, 1U, 2U, 3U, 4U, 5U, 7U, 129U}) {
        std::vector<GatherRow::Part> parts;
        for (std::uint32_t i = 0; i < count; ++i) parts.push_back({3 * i, static_cast<float>(i % 3 == 0 ? 1 : i)});
        const GatherRow row(parts, dark);
        const auto kept = partsOf(row);
        ASSERT_EQ(kept.size(), count);
        double exact = 0;
        for (const GatherRow::Part& part : parts) {
            EXPECT_EQ(kept.at(part.number), part.rays);
            exact += static_cast<double>(part.rays) * (part.number + 1);
        }
        const Rgb light = row.gathered(lights(), 1.0F / 1024);
        EXPECT_NEAR(light.x, exact / 1024, 1e-6 * exact / 1024);
        EXPECT_NEAR(light.y, exact / 512, 1e-6 * exact / 512);
        EXPECT_NEAR(light.z, exact / 2048, 1e-6 * exact / 2048);
        EXPECT_LE(row.bytes(), 4 * (count + std::size_t{4}));
    }
}

// More than a weight can say: in pieces, of which nobody hears.
TEST(GatherRow, ManyRaysAreOneNumber) {
    for (const float rays : {255.0F, 1000.0F, 65'536.0F}) {
        const std::vector<GatherRow::Part> parts{{7, rays}, {8, 3.0F}};
        const auto kept = partsOf(GatherRow(parts, dark));
        ASSERT_EQ(kept.size(), 2U);
        EXPECT_NEAR(kept.at(7) / rays, 1.0F, 1e-5F);
    }
}

// 64 steps an octave: a share is off by 1/128 at most, and by as much again from what its neighbour lost.
TEST(GatherRow, SharesOfRaysAddUp) {
    std::mt19937 random(3);
    std::vector<GatherRow::Part> parts;
    double sum = 0;
    for (std::uint32_t i = 0; i < dark; ++i) {
        const float rays = 0.02F + 3.0F * static_cast<float>(random() % 1000) / 1000.0F;
        parts.push_back({i, rays});
        sum += static_cast<double>(rays);
    }
    double kept = 0;
    GatherRow(parts, dark).forEach(1.0F, [&](std::uint32_t number, float rays) {
        EXPECT_NEAR(rays, parts[number].rays, 0.03F);
        kept += static_cast<double>(rays);
    });
    EXPECT_NEAR(kept, sum, 0.02);
    EXPECT_TRUE(partsOf(GatherRow(std::vector<GatherRow::Part>{{1, 1e-6F}}, dark)).empty());
}

TEST(GatherRow, PackedAndRenumberedIsTheSameRow) {
    std::vector<GatherRow> rows;
    for (std::uint32_t n = 0; n < 20; ++n) {
        std::vector<GatherRow::Part> parts;
        for (std::uint32_t i = 0; i < n; ++i) parts.push_back({i + n, 0.5F * static_cast<float>(i + 1)});
        rows.emplace_back(parts, dark);
    }
    std::vector<std::map<std::uint32_t, float>> before;
    for (const GatherRow& row : rows) before.push_back(partsOf(row));
    const std::vector<std::uint32_t> some{3, 0, 19, 4};
    GatherRow::pack(some, rows);
    GatherRow::pack(std::vector<std::uint32_t>{19, 7}, rows); // one of them moves on
    rows[3] = GatherRow();
    for (const std::uint32_t i : {0U, 19U, 4U, 7U}) {
        EXPECT_EQ(partsOf(rows[i]), before[i]);
        rows[i].renumber([](std::uint32_t number) { return 400 - number; });
        for (const auto& [number, rays] : partsOf(rows[i])) EXPECT_EQ(before[i].at(400 - number), rays);
    }
    EXPECT_EQ(rows[3].gathered(lights(), 1.0F), Rgb(0.0F));
}

} // namespace
} // namespace pie::gather
