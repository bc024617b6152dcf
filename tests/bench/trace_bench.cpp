// Photons traced against the bare cost of their rays, in one run and one thread: the tracer traces a frame of a shipped
// level, its rays are recorded, and the same rays go through Embree 3 alone (default scene, default build, no hits
// looked at), one by one and in packets of 16 in the order the tracer made them. Rounds alternate; ratios are of
// medians of processor time: 1 would be a tracer that takes as long as Embree does for its rays. What the intersector
// needs for the same rays in the same batches is timed too, and says how the rest splits.
//
// Then the tracer on two threads and on one by turns, by the clock, with the load of the machine: on a busy one the
// second thread has to wait. So the same is measured of arithmetic that needs no memory, which says what the machine
// has to give, and the processor time that the two spend together, over that of one: what the work loses by being
// shared.
//
//   trace_bench [photons] [rounds] [level …]       prints one line of JSON per level

#include "apps/piebench/bare_embree.h"
#include "pie/core/parallel.h"
#include "pie/lights/import.h"
#include "pie/photons/tracer.h"
#include "tests/bench/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using pie::bench::median;
using pie::bench::milliseconds;
using pie::intersect::Hit;
using pie::intersect::Ray;

/// Keeps the rays of every batch it passes on.
class Recorder final : public pie::intersect::Intersector {
public:
    explicit Recorder(const Intersector& inner) : inner_(inner) {}
    void closest(std::span<const Ray> rays, std::span<Hit> hits) const override {
        batches.emplace_back(rays.begin(), rays.end());
        inner_.closest(rays, hits);
    }
    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const override {
        inner_.occluded(rays, blocked);
    }
    [[nodiscard]] std::string_view name() const override { return "recorder"; }
    [[nodiscard]] std::size_t bytes() const override { return 0; }

    mutable std::vector<std::vector<Ray>> batches;

private:
    const Intersector& inner_;
};

struct Times {
    std::vector<double> tracer, intersector, single, packets;
};

/// Medians over pairs of runs next to each other.
struct Scaling {
    double throughput = 0; ///< of two threads over one
    double processor = 0;  ///< time of two threads together over that of one
};

template <class Work> Scaling scaling(std::size_t rounds, const Work& work) {
    std::vector<double> throughput, processor;
    double clock[2]{}, spent[2]{};
    for (std::size_t round = 0; round < rounds; ++round) {
        for (const unsigned threads : {1U, 2U}) {
            pie::setThreads(threads);
            const auto begin = std::chrono::steady_clock::now();
            spent[threads - 1] = milliseconds(work);
            clock[threads - 1] =
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
        }
        throughput.push_back(clock[0] / clock[1]);
        processor.push_back(spent[1] / spent[0]);
    }
    pie::setThreads(1);
    return {median(throughput), median(processor)};
}

/// Sixteen equal pieces that share nothing.
void compute() {
    pie::parallelChunks(16, 1, [](std::size_t begin, std::size_t /*end*/) {
        static std::atomic<double> sink;
        auto x = static_cast<double>(begin);
        for (int i = 0; i < 1'000'000; ++i) x = x * 0.5 + 1.0;
        sink = x;
    });
}

/// Programs that want a processor, over the last minute.
double machineLoad() {
    double load = 0;
    return getloadavg(&load, 1) == 1 ? load : -1;
}

bool benchmark(const std::string& name, std::uint64_t photons, std::size_t rounds) {
    auto location = pie::level::locate(name, "/usr/share/games/openarena/baseoa");
    if (!location) return fmt::print(stderr, "{}\n", location.error().message()), false;
    const auto level = pie::level::loadLevel(*std::move(location));
    if (!level) return fmt::print(stderr, "{}\n", level.error().message()), false;
    const auto scene = std::make_shared<pie::scene::Scene>(pie::scene::makeScene(*level));
    const pie::lights::LightSet lights(pie::lights::importLights(*level, *scene).lights, scene);
    const auto embree = makeIntersector(pie::intersect::Kind::Embree, *scene, level->tree);
    const piebench::BareEmbree bare(*scene);
    const pie::photons::TracerOptions options;
    const pie::photons::PhotonTracer tracer(*scene, lights, *embree, options);

    std::vector<pie::photons::Photon> stored;
    const Recorder recorder(*embree);
    const pie::photons::TraceCounts counts =
        pie::photons::PhotonTracer(*scene, lights, recorder, options).trace(0, photons, stored);
    std::vector<Ray> rays;
    for (const auto& batch : recorder.batches) rays.insert(rays.end(), batch.begin(), batch.end());
    std::vector<Hit> hits(rays.size());

    Times times;
    std::size_t sink = 0;
    for (std::size_t round = 0; round < rounds; ++round) {
        times.tracer.push_back(milliseconds([&] {
            stored.clear();
            tracer.trace(0, photons, stored);
        }));
        times.single.push_back(milliseconds([&] { sink += bare.single(rays); }));
        times.packets.push_back(milliseconds([&] { sink += bare.packets(rays); }));
        times.intersector.push_back(milliseconds([&] {
            for (const auto& batch : recorder.batches) embree->closest(batch, std::span(hits).first(batch.size()));
        }));
    }
    const Scaling two = scaling(rounds, [&] {
        stored.clear();
        tracer.trace(0, photons, stored);
    });
    const Scaling machine = scaling(rounds, compute);
    const auto count = static_cast<double>(rays.size());
    const double own = median(times.tracer);
    fmt::print(
        "{{\"level\": \"{}\", \"triangles\": {}, \"lights\": {}, \"photonsEmitted\": {}, \"photonsStored\": {}, "
        "\"rays\": {}, \"rounds\": {}, \"photonsStoredPerSecond\": {:.0f}, \"nanosecondsPerRay\": {{\"tracer\": "
        "{:.1f}, "
        "\"intersector\": {:.1f}, \"bareSingle\": {:.1f}, \"barePackets\": {:.1f}}}, \"ratioToBareSingle\": {:.3f}, "
        "\"ratioToFasterBare\": {:.3f}, \"twoThreadsOverOne\": {{\"throughput\": {:.2f}, \"processorTime\": {:.2f}, "
        "\"machine\": {:.2f}}}, "
        "\"machineLoad\": {:.1f}}}\n",
        name, scene->triangles.size(), lights.lights().size(), photons, counts.stored, rays.size(), rounds,
        1e3 * static_cast<double>(counts.stored) / own, 1e6 * own / count, 1e6 * median(times.intersector) / count,
        1e6 * median(times.single) / count, 1e6 * median(times.packets) / count, median(times.single) / own,
        std::min(median(times.single), median(times.packets)) / own, two.throughput, two.processor, machine.throughput,
        machineLoad());
    return sink > 0;
}

} // namespace

int main(int argumentCount, char** arguments) {
    const std::uint64_t photons = argumentCount > 1 ? std::strtoull(arguments[1], nullptr, 10) : 100'000;
    const std::size_t rounds =
        std::max<std::size_t>(1, argumentCount > 2 ? std::strtoull(arguments[2], nullptr, 10) : 11);
    std::vector<std::string> levels(arguments + std::min(argumentCount, 3), arguments + argumentCount);
    if (levels.empty()) levels = {"ctf_inyard", "kaos2", "oa_dm1"};
    pie::setThreads(1);
    bool good = true;
    for (const std::string& level : levels) good = benchmark(level, photons, rounds) && good;
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
