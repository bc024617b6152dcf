#include "pie/photons/tracer.h"
#include "pie/core/parallel.h"
#include "pie/photons/wavefront.h"

#include <algorithm>

namespace pie::photons {
namespace {

// Paths that advance together: their rays, hits and states stay in the second-level cache.
constexpr std::size_t chunkPaths = 2048;
constexpr std::size_t mostKept = 1'000'000; // photons
// Chunks that are held before they are joined: enough for all threads, and few enough that their memory is used again.
std::size_t chunksAtOnce() { return std::max<std::size_t>(16, 8 * std::size_t{threads()}); }

void add(double (&sum)[3], const double (&terms)[3]) {
    for (int i = 0; i < 3; ++i) sum[i] += terms[i];
}

sampling::Sequence sequence(const TracerOptions& options, sampling::Distribution distribution) {
    const bool splits = options.scattering == TracerOptions::Scattering::Splitting;
    return sampling::makeSequence(distribution,
                                  {options.seed, options.photonsPerFrame, splits ? splitChildren(options) : 1});
}

} // namespace

TraceCounts& TraceCounts::operator+=(const TraceCounts& other) {
    emitted += other.emitted;
    rays += other.rays;
    stored += other.stored;
    escaped += other.escaped;
    absorbed += other.absorbed;
    cut += other.cut;
    backHits += other.backHits;
    filtered += other.filtered;
    add(emittedFlux, other.emittedFlux);
    add(absorbedFlux, other.absorbedFlux);
    add(escapedFlux, other.escapedFlux);
    add(cutFlux, other.cutFlux);
    return *this;
}

PhotonTracer::PhotonTracer(const scene::Scene& scene, const lights::LightSet& lights,
                           const intersect::Intersector& intersector, const TracerOptions& options)
    : scene_(scene), lights_(lights), intersector_(intersector), options_(options),
      emission_(sequence(options, options.lightDistribution)),
      reflection_(sequence(options, options.diffuseDistribution)),
      surroundings_(std::make_shared<Surroundings>(scene)) {}

TraceCounts PhotonTracer::trace(std::uint64_t first, std::uint64_t count, std::uint64_t frame,
                                std::vector<Photon>& out) const {
    TraceCounts counts;
    if (lights_.empty()) return counts;
    const Wavefront wavefront(scene_, lights_, intersector_, options_, emission_, reflection_, *surroundings_, frame);
    const std::size_t grain = std::max<std::size_t>(1, chunkPaths * 16 / std::max<std::size_t>(16, wavefront.widest()));
    const std::size_t firstStored = out.size();
    const std::size_t atOnce = grain * chunksAtOnce();
    // Kept for the thread's next frame, as memory that is new costs about as much as what is written into it.
    static thread_local std::vector<WavefrontResult> kept;
    std::vector<WavefrontResult> results = std::move(kept);
    for (std::uint64_t done = 0; done < count; done += atOnce) {
        const auto batch = static_cast<std::size_t>(std::min<std::uint64_t>(count - done, atOnce));
        results.resize((batch - 1) / grain + 1);
        parallelChunks(batch, grain, [&](std::size_t begin, std::size_t end) {
            wavefront.run(first + done + begin, end - begin, results[begin / grain]);
        });
        // Chunks and the sums over them are joined in index order, whichever thread made them.
        std::vector<std::size_t> starts;
        std::size_t size = out.size();
        for (const auto& result : results) {
            starts.push_back(size);
            size += result.photons.size();
            counts += result.counts;
        }
        out.resize(size);
        parallelChunks(results.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                results[i].writeTo(out.data() + starts[i], static_cast<std::uint32_t>(starts[i] - firstStored));
        });
    }
    if (out.size() - firstStored <= mostKept) kept = std::move(results);
    return counts;
}

} // namespace pie::photons
