#include "apps/piebench/embree_rays.h"

#include "apps/piebench/bare_embree.h"
#include "apps/piebench/frames.h"
#include "pie/core/clock.h"
#include "pie/core/parallel.h"
#include "pie/intersect/intersector.h"

#include <algorithm>
#include <atomic>
#include <mutex>

namespace piebench {
namespace {

using pie::intersect::Hit;
using pie::intersect::Ray;

constexpr std::size_t taskSize = 1024; // rays, whole packets

/// Keeps the rays that it passes on.
class Recorder final : public pie::intersect::Intersector {
public:
    explicit Recorder(const Intersector& inner) : inner_(inner) {}
    void closest(std::span<const Ray> asked, std::span<Hit> hits) const override {
        {
            const std::lock_guard lock(mutex_);
            rays.insert(rays.end(), asked.begin(), asked.end());
        }
        inner_.closest(asked, hits);
    }
    void occluded(std::span<const Ray> asked, std::span<std::uint8_t> blocked) const override {
        inner_.occluded(asked, blocked);
    }
    [[nodiscard]] std::string_view name() const override { return "recorder"; }
    [[nodiscard]] std::size_t bytes() const override { return 0; }

    mutable std::vector<Ray> rays;

private:
    const Intersector& inner_;
    mutable std::mutex mutex_;
};

} // namespace

struct EmbreeRays::State {
    State(const LoadedLevel& level, const pie::engine::Settings& settings, const pie::photons::TracerOptions& options,
          std::uint64_t emitted)
        : count(emitted), lights(level.lights, level.scene),
          intersector(pie::intersect::makeIntersector(settings.intersector, *level.scene, level.level->tree)),
          tracer(*level.scene, lights, *intersector, options), bare(*level.scene) {}
    std::uint64_t count;
    pie::lights::LightSet lights;
    std::unique_ptr<pie::intersect::Intersector> intersector;
    pie::photons::PhotonTracer tracer;
    BareEmbree bare;
    std::vector<pie::photons::Photon> photons;
    std::vector<Ray> rays;
    std::atomic<std::size_t> hits{0}; ///< so that no ray is left out as useless

    /// Milliseconds of wall clock and of the processor.
    template <class Trace> std::pair<double, double> time(const Trace& trace) {
        const auto start = pie::Clock::now();
        const double processor = pie::processorMilliseconds();
        pie::parallelChunks(rays.size(), taskSize, [&](std::size_t begin, std::size_t end) {
            hits += trace(std::span<const Ray>(rays).subspan(begin, end - begin));
        });
        return {pie::millisecondsSince(start), pie::processorMilliseconds() - processor};
    }
};

EmbreeRays::EmbreeRays(const LoadedLevel& level, const pie::engine::Settings& settings,
                       const pie::photons::TracerOptions& options, std::uint64_t count)
    : state_(std::make_unique<State>(level, settings, options, count)) {
    State& s = *state_;
    const Recorder recorder(*s.intersector);
    // In the order of one thread, in which neighbours in a batch stay neighbours.
    const unsigned threads = pie::threads();
    pie::setThreads(1);
    pie::photons::PhotonTracer(*level.scene, s.lights, recorder, options).trace(0, count, s.photons);
    pie::setThreads(threads);
    s.rays = std::move(recorder.rays);
}

EmbreeRays::~EmbreeRays() = default;

std::size_t EmbreeRays::rays() const { return state_->rays.size(); }
std::size_t EmbreeRays::stored() const { return state_->photons.size(); }

EmbreeRays::Times EmbreeRays::run() const {
    State& s = *state_;
    const auto [single, singleProcessor] = s.time([&](std::span<const Ray> rays) { return s.bare.single(rays); });
    const auto [packets, packetsProcessor] = s.time([&](std::span<const Ray> rays) { return s.bare.packets(rays); });
    const auto start = pie::Clock::now();
    const double processor = pie::processorMilliseconds();
    s.photons.clear();
    s.tracer.trace(0, s.count, s.photons);
    const double tracer = pie::millisecondsSince(start);
    return {single, packets, tracer, singleProcessor, packetsProcessor, pie::processorMilliseconds() - processor};
}

} // namespace piebench
