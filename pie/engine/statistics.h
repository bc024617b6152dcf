#pragma once
// What the engine has done so far.

#include <cstddef>
#include <cstdint>
#include <string>

namespace pie::engine {

/// Times are wall clock, in milliseconds.
struct Statistics {
    std::uint64_t frames = 0;       ///< calls of advance()
    std::uint64_t framesTraced = 0; ///< of these, frames in which photons were traced
    std::uint64_t photonsEmitted = 0, raysTraced = 0, photonsStored = 0, photonsEscaped = 0;
    std::uint64_t photonsInMap = 0;
    std::uint64_t mapNodesVisited = 0, mapPhotonsVisited = 0; ///< by searches of the photon map
    std::uint64_t directRays = 0;
    std::uint64_t directEstimates = 0; ///< receivers whose direct light was computed
    std::uint64_t estimatesMade = 0, estimatesReused = 0;
    std::uint64_t estimatesDeferred = 0; ///< answered by older light, as the frame's time was spent (budget_ms)
    std::uint64_t gatherRays = 0;        ///< of final gathers, with the shadow rays of texels
    std::uint64_t unfinished = 0;        ///< receivers asked for last that will be refined further
    std::size_t receivers = 0, drawnTriangles = 0, coarseTriangles = 0, lights = 0;
    double prepareMs = 0, traceMs = 0, buildMs = 0, directMs = 0, refineMs = 0, estimateMs = 0, uploadMs = 0;
    /// Of the last 256 frames in which there was work: all stages of one frame together.
    double frameMsMedian = 0, frameMs95 = 0;
    /// Relative standard error of what was asked for last, per cent; negative: not known (target_error).
    double errorPercent = -1;
    bool still = false; ///< nothing is left to do until something changes
    std::size_t sceneBytes = 0, intersectorBytes = 0, mapBytes = 0, receiverBytes = 0;
    std::size_t estimatorBytes = 0, directBytes = 0; ///< of the estimator without the map, of direct light at receivers
    /// One JSON object, keys as above in snake_case.
    [[nodiscard]] std::string json() const;
};

} // namespace pie::engine
