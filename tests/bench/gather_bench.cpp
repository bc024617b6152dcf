// What a steady frame of the cached gather costs: photons added to texels, and the light of every receiver estimated
// anew from rows that are made. Processor time, medians.
//
//   gather_bench [photons] [max_edge] [rounds]
//
// The level is $PIE_BENCH_LEVEL, else ctf_inyard. Prints what rows hold, then milliseconds on one thread and on two.

#include "pie/core/parallel.h"
#include "pie/gather/cached_gather.h"
#include "pie/lights/import.h"
#include "pie/photons/tracer.h"
#include "tests/bench/bench_level.h"
#include "tests/bench/timing.h"

#include <fmt/format.h>

#include <cstdlib>
#include <limits>
#include <numeric>
#include <vector>

namespace {

using pie::Rgb;
using pie::bench::median;
using pie::bench::milliseconds;

double argument(int count, char** arguments, int number, double otherwise) {
    return count > number ? std::atof(arguments[number]) : otherwise;
}

template <class Work> double medianOf(int rounds, const Work& work) {
    std::vector<double> times;
    for (int round = 0; round < rounds; ++round) times.push_back(milliseconds(work));
    return median(std::move(times));
}

} // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): what goes wrong may end a measurement
int main(int argumentCount, char** arguments) {
    const auto photonCount = static_cast<std::uint64_t>(argument(argumentCount, arguments, 1, 25'600));
    const auto maxEdge = static_cast<float>(argument(argumentCount, arguments, 2, 192));
    const int rounds = static_cast<int>(argument(argumentCount, arguments, 3, 31));

    const pie::level::Level& level = pie::bench::benchLevel();
    pie::scene::Mesh mesh = pie::scene::makeMesh(level);
    pie::scene::RefineOptions refinement;
    refinement.maxEdge = maxEdge;
    pie::scene::refine(mesh, refinement);
    const pie::scene::Receivers receivers = pie::scene::makeReceivers(mesh, level);
    const auto scene = std::make_shared<const pie::scene::Scene>(pie::scene::makeScene(level));
    const auto intersector = makeIntersector(pie::intersect::Kind::Embree, *scene, level.tree);
    const pie::lights::LightSet lights(pie::lights::importLights(level, *scene).lights, scene);

    pie::photons::TracerOptions tracing;
    tracing.storeDirectLight = true;
    tracing.recursionDepth = 31;
    const pie::photons::PhotonTracer tracer(*scene, lights, *intersector, tracing);
    std::vector<pie::photons::Photon> photons;
    std::uint64_t emitted = 0;
    while (photons.size() < photonCount) {
        constexpr std::uint64_t some = 500;
        tracer.trace(emitted, some, photons);
        emitted += some;
    }
    photons.resize(photonCount);

    pie::gather::DirectLight direct(*scene, lights, *intersector, receivers);
    pie::gather::GatherOptions options;
    options.texelsByPhotons = true;
    pie::gather::CachedGather gather(*scene, lights, *intersector, receivers, &direct, options);
    gather.aim(photons);
    gather.add(photons);
    std::vector<std::uint32_t> all(receivers.points.size());
    std::iota(all.begin(), all.end(), 0U);
    gather.refine(all, std::numeric_limits<std::uint64_t>::max());

    const auto count = static_cast<double>(all.size());
    fmt::print("{} receivers, {} photons, {} texels of edge {}, {:.1f} MB: {:.0f} bytes a receiver\n", all.size(),
               photons.size(), gather.texels().texels().size(), gather.texels().edge(),
               static_cast<double>(gather.bytes()) * 1e-6, static_cast<double>(gather.bytes()) / count);
    std::vector<Rgb> light(all.size());
    for (const unsigned threads : {1U, 2U}) {
        pie::setThreads(threads);
        const double adding = medianOf(rounds, [&] {
            gather.add(photons);
            gather.update();
        });
        const double estimating = medianOf(rounds, [&] { gather.estimate(all, light); });
        fmt::print("{} threads: add {:.2f} ms, estimate {:.2f} ms of processor time, {:.3f} per 1,000 receivers\n",
                   threads, adding, estimating, estimating / count * 1000);
    }
    return 0;
}
