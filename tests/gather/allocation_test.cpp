// A steady frame of the cached gather allocates nothing: photons are added, light is made of them, receivers are asked.

#include "pie/core/parallel.h"
#include "pie/gather/cached_gather.h"
#include "pie/photons/tracer.h"
#include "tests/gather/scenes.h"
#include "tests/support/allocations.h"

#include <gtest/gtest.h>

#include <limits>

namespace pie::gather {
namespace {

TEST(Allocations, NoneInASteadyFrame) {
    test::SceneBuilder builder;
    builder.grey(0.5F);
    builder.room(Vec3(0.0F), Vec3(256.0F));
    const std::shared_ptr<const scene::Scene> scene = builder.make();
    const auto intersector = intersect::makeIntersector(intersect::Kind::Embree, *scene, {});
    lights::PointLight lamp;
    lamp.position = Vec3(100.0F);
    lamp.power = Rgb(1e6F);
    const lights::LightSet lights({lamp}, scene);
    scene::Receivers receivers;
    for (int i = 0; i < 2000; ++i)
        receivers.points.push_back(test::receiverAt(
            Vec3(4.0F * static_cast<float>(i % 64), 8.0F * static_cast<float>(i / 64), 0.0F), Vec3(0, 0, 1)));
    const std::vector<std::uint32_t> which = test::all(receivers);
    for (const bool byPhotons : {false, true}) {
        DirectLight direct(*scene, lights, *intersector, receivers);
        GatherOptions options;
        options.texelsByPhotons = byPhotons;
        CachedGather gather(*scene, lights, *intersector, receivers, &direct, options);
        photons::TracerOptions tracing;
        tracing.storeDirectLight = byPhotons;
        std::vector<photons::Photon> photons;
        photons::PhotonTracer(*scene, lights, *intersector, tracing).trace(0, 20'000, photons);
        std::vector<Rgb> light(which.size());
        gather.add(photons);
        gather.refine(which, std::numeric_limits<std::uint64_t>::max());
        for (const unsigned threadCount : {1U, 2U}) {
            setThreads(threadCount);
            gather.add(photons);
            gather.update();
            gather.estimate(which, light);
            const Rgb first = light.front();
            [[maybe_unused]] const std::size_t before = pie::test::allocations();
            gather.add(photons);
            gather.update();
            gather.estimate(which, light);
            // The thread sanitizer gets threads of our own making, see parallel.cpp.
#ifndef __SANITIZE_THREAD__
            EXPECT_EQ(pie::test::allocations() - before, 0U) << byPhotons << ' ' << threadCount;
#endif
            EXPECT_NEAR(light.front().x, first.x, 1e-4F * first.x);
            EXPECT_GT(first.x, 0.0F);
        }
    }
    setThreads(0);
}

} // namespace
} // namespace pie::gather
