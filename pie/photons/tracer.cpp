#include "pie/photons/tracer.h"
#include "pie/core/parallel.h"
#include "pie/photons/wavefront.h"

#include <algorithm>
#include <span>

namespace pie::photons {
namespace {

// Paths that advance together. The more there are, the more rays meet in each node of the intersector's tree; the
// fewer, the more processors find work in a frame.
constexpr std::size_t leastTogether = 2048;
constexpr std::size_t mostTogether = 8192;
constexpr std::size_t chunksPerFrame = 4;
constexpr std::size_t mostKept = 1'000'000; // photons
// Chunks that are held before they are joined: enough for all threads, and few enough that their memory is used again.
std::size_t chunksAtOnce() { return std::max<std::size_t>(16, 8 * std::size_t{threads()}); }

/// Photons of a chunk. How many threads there are must not show in the sums, which are made chunk by chunk.
std::size_t chunkSize(std::uint64_t count, std::size_t widest) {
    const auto share = static_cast<std::size_t>(
        std::clamp<std::uint64_t>((count + chunksPerFrame - 1) / chunksPerFrame, leastTogether, mostTogether));
    return std::max<std::size_t>(1, share * 16 / std::max<std::size_t>(16, widest));
}

void add(double (&sum)[3], const double (&terms)[3]) {
    for (int i = 0; i < 3; ++i) sum[i] += terms[i];
}

struct Chunks {
    std::vector<WavefrontResult> results;
    std::vector<std::size_t> starts; ///< of their photons in the output
};

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
    const std::size_t grain = chunkSize(count, wavefront.widest());
    const std::size_t firstStored = out.size();
    const std::size_t atOnce = grain * chunksAtOnce();
    // Kept for the thread's next frame: memory that is new costs about as much as what is written into it.
    static thread_local Chunks kept;
    Chunks chunks = std::move(kept);
    for (std::uint64_t done = 0; done < count; done += atOnce) {
        const auto batch = static_cast<std::size_t>(std::min<std::uint64_t>(count - done, atOnce));
        const std::size_t used = (batch - 1) / grain + 1;
        if (chunks.results.size() < used) chunks.results.resize(used);
        const auto traceChunk = [&](std::size_t begin, std::size_t end) {
            wavefront.run(first + done + begin, end - begin, chunks.results[begin / grain]);
        };
        parallelChunks(batch, grain, traceChunk);
        // Chunks and the sums over them are joined in index order, whichever thread made them.
        chunks.starts.clear();
        std::size_t size = out.size();
        for (const WavefrontResult& result : std::span(chunks.results).first(used)) {
            chunks.starts.push_back(size);
            size += result.photons.size();
            counts += result.counts;
        }
        out.resize(size);
        const auto write = [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                chunks.results[i].writeTo(out.data() + chunks.starts[i],
                                          static_cast<std::uint32_t>(chunks.starts[i] - firstStored));
        };
        parallelChunks(used, 1, write);
    }
    if (out.size() - firstStored <= mostKept) kept = std::move(chunks);
    return counts;
}

} // namespace pie::photons
