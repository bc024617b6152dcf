// The three intersectors against each other on shipped levels: a million rays each where the judge can keep up.

#include "pie/core/parallel.h"
#include "tests/intersect/rays.h"
#include "tests/support/game_data.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace pie::test {
namespace {

using intersect::Hit;
using intersect::Kind;
using intersect::makeIntersector;
using intersect::Ray;

constexpr std::size_t million = 1'000'000;

struct Loaded {
    level::Level level;
    scene::Scene scene;
};

Loaded load(const std::string& name) {
    Loaded loaded;
    level::LoadOptions options;
    options.images = false;
    Result<level::Level> level = level::loadLevel({GameData::instance().files, "maps/" + name + ".bsp"}, options);
    if (!level) {
        ADD_FAILURE() << level.error().message();
        return loaded;
    }
    loaded.level = std::move(*level);
    loaded.scene = scene::makeScene(loaded.level);
    return loaded;
}

std::vector<Hit> closestInParallel(const intersect::Intersector& intersector, std::span<const Ray> rays) {
    std::vector<Hit> hits(rays.size());
    parallelChunks(rays.size(), 4096, [&](std::size_t begin, std::size_t end) {
        intersector.closest(rays.subspan(begin, end - begin), std::span(hits).subspan(begin, end - begin));
    });
    return hits;
}

std::vector<std::uint8_t> occludedInParallel(const intersect::Intersector& intersector, std::span<const Ray> rays) {
    std::vector<std::uint8_t> blocked(rays.size());
    parallelChunks(rays.size(), 4096, [&](std::size_t begin, std::size_t end) {
        intersector.occluded(rays.subspan(begin, end - begin), std::span(blocked).subspan(begin, end - begin));
    });
    return blocked;
}

/// Allowed is rounding at shared edges, a few rays in a million.
void expectSame(const std::string& what, std::span<const Hit> a, std::span<const Hit> b) {
    const Agreement agreement = compare(a, b);
    testing::Test::RecordProperty(what, agreement.text());
    std::puts((what + ": " + agreement.text()).c_str());
    EXPECT_EQ(agreement.wrong, 0U) << agreement.text();
    EXPECT_LE(agreement.edges + agreement.ties, a.size() / 100'000) << agreement.text();
}

class ShippedLevel : public testing::TestWithParam<const char*> {};

TEST_P(ShippedLevel, AllIntersectorsGiveTheSameAnswer) {
    PIE_NEED_GAME_DATA();
    if (!GameData::instance().has(GetParam())) GTEST_SKIP() << GameData::missing;
    const Loaded loaded = load(GetParam());
    ASSERT_GT(loaded.scene.triangles.size(), 1000U);
    const auto bruteForce = makeIntersector(Kind::BruteForce, loaded.scene, loaded.level.tree);
    const auto bsp = makeIntersector(Kind::Bsp, loaded.scene, loaded.level.tree);
    const auto embree = makeIntersector(Kind::Embree, loaded.scene, loaded.level.tree);
    const std::vector<Ray> rays = randomRays(loaded.scene, million, 1);
    const std::vector<Hit> byBsp = closestInParallel(*bsp, rays);
    expectSame("Embree and BSP", closestInParallel(*embree, rays), byBsp);
    const std::span<const Ray> some = std::span(rays).first(5000);
    expectSame("BSP and brute force", std::span(byBsp).first(some.size()), closestInParallel(*bruteForce, some));

    const std::vector<std::uint8_t> blockedBsp = occludedInParallel(*bsp, rays);
    const std::vector<std::uint8_t> blockedEmbree = occludedInParallel(*embree, rays);
    const std::vector<std::uint8_t> blockedBrute = occludedInParallel(*bruteForce, some);
    std::size_t different = 0;
    std::size_t blocked = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        different += blockedBsp[i] != blockedEmbree[i] ? 1 : 0;
        blocked += blockedBsp[i];
    }
    EXPECT_LE(different, rays.size() / 100'000);
    EXPECT_GT(blocked, rays.size() / 4);
    for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(blockedBrute[i], blockedBsp[i]) << i;
}

TEST_P(ShippedLevel, EmbreeAnswersAloneAsInABatch) {
    PIE_NEED_GAME_DATA();
    if (!GameData::instance().has(GetParam())) GTEST_SKIP() << GameData::missing;
    const Loaded loaded = load(GetParam());
    const auto embree = makeIntersector(Kind::Embree, loaded.scene, loaded.level.tree);
    for (const std::vector<Ray>& rays :
         {coherentRays(loaded.scene, million, 2), randomRays(loaded.scene, 100'000, 3)}) {
        const std::vector<Hit> together = closestInParallel(*embree, rays);
        const std::vector<std::uint8_t> blockedTogether = occludedInParallel(*embree, rays);
        std::size_t different = 0;
        std::size_t differentlyBlocked = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            Hit hit;
            std::uint8_t blocked = 0;
            embree->closest({&rays[i], 1}, {&hit, 1});
            embree->occluded({&rays[i], 1}, {&blocked, 1});
            different +=
                hit.triangle != together[i].triangle || hit.t != together[i].t || hit.u != together[i].u ? 1 : 0;
            differentlyBlocked += blocked != blockedTogether[i] ? 1 : 0;
        }
        EXPECT_EQ(different, 0U) << "of " << rays.size();
        EXPECT_EQ(differentlyBlocked, 0U) << "of " << rays.size();
    }
}

INSTANTIATE_TEST_SUITE_P(Levels, ShippedLevel, testing::Values("oa_dm1", "ctf_inyard", "aggressor"),
                         [](const auto& level) { return std::string(level.param); });

TEST(Room, AMillionRaysAllThreeWays) {
    const Furnished room = furnishedRoom();
    const std::vector<Ray> rays = randomRays(room.scene, million, 4);
    const std::vector<Hit> expected =
        closestInParallel(*makeIntersector(Kind::BruteForce, room.scene, room.tree), rays);
    for (const Kind kind : {Kind::Bsp, Kind::Embree}) {
        const auto intersector = makeIntersector(kind, room.scene, room.tree);
        const Agreement agreement = compare(expected, closestInParallel(*intersector, rays));
        std::puts(agreement.text().c_str());
        EXPECT_EQ(agreement.wrong, 0U) << agreement.text();
        EXPECT_LE(agreement.edges + agreement.ties, 10U) << agreement.text();
    }
}

} // namespace
} // namespace pie::test
