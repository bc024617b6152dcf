#include "pie/maps/realtime.h"
#include "tests/maps/clouds.h"

#include <gtest/gtest.h>

#include <random>

namespace pie::maps {
namespace {

using photons::Photon;

/// A frame of `count` photons that share `watts` equally.
std::vector<Photon> frame(std::size_t count, float watts, std::uint32_t id) {
    std::vector<Photon> photons(count, test::photonAt({static_cast<float>(id), 0.0F, 0.0F}));
    for (Photon& photon : photons) {
        photon.flux = Rgb(watts / static_cast<float>(count));
        photon.id = id;
    }
    return photons;
}

double flux(const RealtimeMap& map) {
    double sum = 0;
    for (const Photon& photon : map.photons()) sum += static_cast<double>(photon.flux.x);
    return sum * static_cast<double>(map.fluxScale());
}

std::vector<std::uint32_t> idsOf(const RealtimeMap& map) {
    std::vector<std::uint32_t> ids;
    for (const Photon& photon : map.photons())
        if (ids.empty() || ids.back() != photon.id) ids.push_back(photon.id);
    return ids;
}

TEST(RealtimeMap, IsRightFromTheFirstFrameOn) {
    RealtimeMap map(4);
    EXPECT_EQ(map.fluxScale(), 0.0F);
    for (std::uint32_t i = 1; i <= 20; ++i) {
        map.replaceOldest(frame(10 + i, 60.0F, i));
        map.rebuild();
        EXPECT_EQ(map.framesPresent(), std::min(i, 4U));
        EXPECT_NEAR(flux(map), 60.0, 1e-4) << "frame " << i;
    }
    EXPECT_EQ(idsOf(map), (std::vector<std::uint32_t>{17, 18, 19, 20}));
    EXPECT_EQ(map.photons().size(), 27U + 28U + 29U + 30U);
}

TEST(RealtimeMap, AnEmptyFrameIsAFrame) {
    RealtimeMap map(2);
    map.replaceOldest(frame(5, 10.0F, 1));
    map.replaceOldest({});
    map.rebuild();
    EXPECT_EQ(map.framesPresent(), 2U);
    EXPECT_NEAR(flux(map), 5.0, 1e-5); // the mean over a frame of 10 W and a frame without light
}

TEST(RealtimeMap, ReplacingReturnsWhatWasThere) {
    RealtimeMap map(3);
    for (std::uint32_t i = 1; i <= 3; ++i) EXPECT_TRUE(map.replaceOldest(frame(i, 1.0F, i)).empty());
    EXPECT_EQ(map.oldestSlot(), 0U);
    EXPECT_EQ(map.replaceFrame(1, frame(7, 1.0F, 9)).size(), 2U);
    EXPECT_EQ(map.replaceOldest(frame(8, 1.0F, 10)).size(), 1U);
    EXPECT_EQ(map.replaceOldest(frame(8, 1.0F, 11)).size(), 3U); // slot 1 is newer than slot 2
    map.rebuild();
    EXPECT_EQ(idsOf(map), (std::vector<std::uint32_t>{10, 9, 11}));
}

TEST(RealtimeMap, RemovalLeavesNothing) {
    RealtimeMap map(5);
    for (std::uint32_t i = 1; i <= 5; ++i) map.replaceOldest(frame(100, 3.0F, i));
    map.rebuild();
    for (const std::size_t slot : {2U, 0U, 4U}) {
        EXPECT_EQ(map.removeFrame(slot).size(), 100U);
        map.rebuild();
        EXPECT_NEAR(flux(map), 3.0, 1e-4);
    }
    EXPECT_EQ(idsOf(map), (std::vector<std::uint32_t>{2, 4}));
    map.clear();
    map.rebuild();
    EXPECT_TRUE(map.photons().empty());
    EXPECT_EQ(map.framesPresent(), 0U);
    EXPECT_EQ(map.fluxScale(), 0.0F);
    EXPECT_TRUE(map.bounds().empty());
    NearestQueue queue;
    map.visit([&](const auto& photons) {
        photons.nearest(
            Vec3(0.0F), 10, 1e9F, [](const Photon&) { return true; }, queue);
    });
    EXPECT_TRUE(queue.found().empty());
}

TEST(RealtimeMap, ChangingTheNumberOfFramesKeepsTheNewest) {
    RealtimeMap map(5);
    for (std::uint32_t i = 1; i <= 8; ++i) map.replaceOldest(frame(2, 1.0F, i)); // slots hold 6 7 8 4 5
    map.setAccumulationFrames(3);
    map.rebuild();
    EXPECT_EQ(idsOf(map), (std::vector<std::uint32_t>{6, 7, 8}));
    EXPECT_NEAR(flux(map), 1.0, 1e-6);
    map.setAccumulationFrames(6);
    for (std::uint32_t i = 9; i <= 11; ++i) map.replaceOldest(frame(2, 1.0F, i));
    map.rebuild();
    EXPECT_EQ(map.framesPresent(), 6U);
    EXPECT_EQ(idsOf(map), (std::vector<std::uint32_t>{6, 7, 8, 9, 10, 11}));
    map.setAccumulationFrames(0);
    map.rebuild();
    EXPECT_EQ(map.accumulationFrames(), 1U);
    EXPECT_EQ(idsOf(map), (std::vector<std::uint32_t>{11}));
}

TEST(RealtimeMap, ShrinkingDropsEmptySlotsBeforeFrames) {
    RealtimeMap map(8);
    map.replaceFrame(6, frame(2, 1.0F, 3));
    map.replaceFrame(1, frame(2, 1.0F, 4));
    map.setAccumulationFrames(2);
    map.rebuild();
    EXPECT_EQ(idsOf(map), (std::vector<std::uint32_t>{4, 3}));
}

TEST(RealtimeMap, BothSearchesSeeTheSame) {
    RealtimeMap tree(3);
    RealtimeMap exact(3, Search::Exact);
    for (std::size_t i = 0; i < 7; ++i) {
        const auto photons = test::clouds(50 + 13 * i, 0)[i % 3].photons;
        tree.replaceOldest(std::vector<Photon>(photons));
        exact.replaceOldest(std::vector<Photon>(photons));
    }
    const auto before = tree.photons().size();
    EXPECT_EQ(before, 0U) << "searches see the last rebuilt state";
    tree.rebuild();
    exact.rebuild();
    EXPECT_EQ(tree.photons().size(), exact.photons().size());
    EXPECT_EQ(tree.fluxScale(), exact.fluxScale());
    std::mt19937 random(4);
    std::uniform_real_distribution<float> place(-1.0F, 11.0F);
    const auto all = [](const Photon&) { return true; };
    NearestQueue a;
    NearestQueue b;
    for (int i = 0; i < 500; ++i) {
        const Vec3 point(place(random), place(random), place(random));
        tree.visit([&](const auto& map) { map.nearest(point, 9, 5.0F, all, a); });
        exact.visit([&](const auto& map) { map.nearest(point, 9, 5.0F, all, b); });
        std::vector<Neighbour> left(a.found().begin(), a.found().end());
        std::vector<Neighbour> right(b.found().begin(), b.found().end());
        std::sort(left.begin(), left.end());
        std::sort(right.begin(), right.end());
        ASSERT_EQ(left, right);
    }
}

} // namespace
} // namespace pie::maps
