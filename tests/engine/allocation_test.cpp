// A steady frame, from photons to answers, allocates nothing.

#include "pie/core/parallel.h"
#include "pie/engine/transport.h"
#include "tests/gather/scenes.h"
#include "tests/support/allocations.h"

#include <gtest/gtest.h>

#include <numeric>

namespace pie::engine {
namespace {

// With one thread: which thread gets which photons is chance, and each has memory of its own to fill.
TEST(EngineAllocations, NoneInASteadyFrame) {
    gather::test::SceneBuilder builder;
    builder.grey(0.5F);
    builder.room(Vec3(0.0F), Vec3(256.0F));
    scene::Receivers receivers;
    for (int i = 0; i < 1000; ++i)
        receivers.points.push_back(gather::test::receiverAt(
            Vec3(4.0F * static_cast<float>(i % 64), static_cast<float>(i - i % 64) / 8.0F, 0.0F), Vec3(0, 0, 1)));
    std::vector<std::uint32_t> which(receivers.points.size());
    std::iota(which.begin(), which.end(), 0U);
    lights::PointLight lamp;
    lamp.position = Vec3(100.0F);
    lamp.power = Rgb(1e6F);
    setThreads(1);
    const level::Tree none;
    Settings settings;
    settings.stillFrames = 100;
    Transport transport(makeSurroundings(builder.make(), none, settings), {lamp}, none, receivers, settings);
    transport.finish(which);
    std::vector<Rgb> light(which.size());
    const auto frame = [&] {
        transport.advance();
        transport.irradiance(which, light);
    };
    for (int i = 0; i < 40; ++i) frame(); // vectors grow to the largest frame so far
    int without = 0;
    for (int i = 0; i < 40; ++i) {
        const std::size_t before = pie::test::allocations();
        frame();
        without += pie::test::allocations() == before ? 1 : 0;
    }
    setThreads(0);
    // A frame with more photons than any before may make room for them.
    EXPECT_GE(without, 35);
    EXPECT_EQ(transport.statistics().framesTraced, 80U);
}

} // namespace
} // namespace pie::engine
