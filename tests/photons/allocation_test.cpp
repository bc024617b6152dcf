// A steady frame allocates nothing: every operator new of this program is counted.

#include "pie/core/parallel.h"
#include "tests/photons/traced.h"
#include "tests/support/allocations.h"

#include <gtest/gtest.h>

namespace pie::photons {
namespace {

/// Frames of the same size, of which the first few find out how much memory they need.
void expectSteady(const TracerOptions& options, std::uint64_t count) {
    test::RoomBuilder room;
    const auto grey = room.material(test::opaque(Rgb(0.7F, 0.6F, 0.5F)));
    const auto open = room.material(test::sky());
    room.inside({0, 0, 0}, {256, 256, 128}, {grey, grey, grey, grey, grey, open});
    const lights::SkyLight dome{{{0, 0, 1}, glm::normalize(Vec3(1, 0, 1))}, Rgb(3.0F)};
    test::Traced traced(
        room.build(),
        {test::lamp({100, 90, 60}, Rgb(1e4F)), dome,
         lights::SunLight{glm::normalize(Vec3(0.2F, 0.3F, 1.0F)), Rgb(50.0F), 0.05F},
         lights::makeAreaLight({{30, 30, 100}, {30, 90, 100}, {90, 90, 100}, {90, 30, 100}}, Rgb(50.0F))},
        options);
    std::vector<Photon> photons;
    photons.reserve(20 * count); // the output is the caller's
    std::uint64_t frame = 0;
    const auto trace = [&] {
        photons.clear();
        traced.tracer().trace(frame++ * count, count, photons);
        return photons.size();
    };
    for (int i = 0; i < 8; ++i) trace();
    const std::size_t before = test::allocations();
    std::size_t stored = 0;
    for (int i = 0; i < 4; ++i) stored += trace();
    EXPECT_EQ(test::allocations() - before, 0U);
    EXPECT_GT(stored, count);
}

class Steady : public testing::Test {
protected:
    // Which thread gets which chunk is chance, and so is when each has had its largest.
    Steady() { setThreads(1); }
    ~Steady() override { setThreads(0); }
};

TEST_F(Steady, FramesAllocateNothing) {
    expectSteady(test::roulette(false, 32), 10'000);
    expectSteady(test::roulette(true, 32), 40'000);
}
TEST_F(Steady, SplitFramesAllocateNothing) { expectSteady(test::splitting(4, false, 3), 500); }

TEST(Allocations, AreCounted) {
    const std::size_t before = test::allocations();
    const std::vector<int> some(100);
    EXPECT_EQ(some.size(), 100U);
    EXPECT_EQ(test::allocations() - before, 1U);
}

} // namespace
} // namespace pie::photons
