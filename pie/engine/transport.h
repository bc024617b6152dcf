#pragma once
// Light transport of one scene to a fixed list of receivers; needs no level and no mesh. Two calls per frame, as in
// Engine, which adds the level around it:
//
//   advance()     traces the photons of this frame and renews what estimators read;
//   irradiance()  light at receivers, any thread, several at once.
//
// explain() answers the same question at leisure, with a standard error.
//
// The tracer is a pure function of scene revision and photon index, so a scene that stands still is traced for
// `still_frames` frames (`accumulation_frames` where the photons themselves are kept) and then costs nothing: once what
// is looked at is refined, advance() returns at once and irradiance() copies what the cache holds. Same scene, lights,
// receivers and settings: same bits, on any number of threads.

#include "pie/core/vec.h"
#include "pie/engine/settings.h"
#include "pie/gather/gather.h"
#include "pie/gather/texels.h"
#include "pie/intersect/intersector.h"
#include "pie/level/level.h"
#include "pie/lights/light_set.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pie::engine {

/// What the engine has done so far. Times are wall clock, in milliseconds.
struct Statistics {
    std::uint64_t frames = 0;       ///< calls of advance()
    std::uint64_t framesTraced = 0; ///< of these, frames in which photons were traced
    std::uint64_t photonsEmitted = 0, raysTraced = 0, photonsStored = 0, photonsEscaped = 0;
    std::uint64_t photonsInMap = 0;
    std::uint64_t mapNodesVisited = 0, mapPhotonsVisited = 0; ///< by searches of the photon map
    std::uint64_t directRays = 0;
    std::uint64_t directEstimates = 0; ///< receivers whose direct light was computed
    std::uint64_t estimatesMade = 0, estimatesReused = 0;
    std::uint64_t gatherRays = 0; ///< of final gathers, with the shadow rays of texels
    std::uint64_t unfinished = 0; ///< receivers asked for last that will be refined further
    std::size_t receivers = 0, drawnTriangles = 0, coarseTriangles = 0, lights = 0;
    double prepareMs = 0, traceMs = 0, buildMs = 0, directMs = 0, refineMs = 0, estimateMs = 0, uploadMs = 0;
    std::size_t sceneBytes = 0, intersectorBytes = 0, mapBytes = 0, receiverBytes = 0;
    std::size_t estimatorBytes = 0, directBytes = 0; ///< of the estimator without the map, of direct light at receivers
    /// One JSON object, keys as above in snake_case.
    [[nodiscard]] std::string json() const;
};

/// What tracing and gathering need of a scene, whatever its lights and receivers.
struct Surroundings {
    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<const intersect::Intersector> intersector;
    std::shared_ptr<const gather::SurfaceTexels> texels; ///< null where nothing is gathered
};
/// `tree` is used by the intersector "bsp" alone and may be empty; it must outlive the result.
[[nodiscard]] Surroundings makeSurroundings(std::shared_ptr<const scene::Scene> scene, const level::Tree& tree,
                                            const Settings& settings);

class Transport {
public:
    /// Keeps references to `receivers` and `tree` (used by `split_maps` alone, may be empty): both must outlive it.
    /// Builds estimators at once. The surroundings were made with the same tree and settings.
    Transport(Surroundings surroundings, std::vector<lights::Light> lights, const level::Tree& tree,
              const scene::Receivers& receivers, const Settings& settings);
    ~Transport();
    Transport(const Transport&) = delete;
    Transport& operator=(const Transport&) = delete;

    [[nodiscard]] const scene::Scene& scene() const;

    /// Next frame of photons. Returns whether the light changed. One thread at a time.
    bool advance();
    /// Light at receivers.points[which[i]] in watts per square unit, as good as it is known. Zero before the first
    /// advance(). What was asked for since the last advance() is what advance() refines (estimator = gather).
    void irradiance(std::span<const std::uint32_t> which, std::span<Rgb> out);
    /// Refines these to the end now, however long it takes.
    void finish(std::span<const std::uint32_t> which);
    /// The same with standard error, bias, photons and radius: slow, for tools. Not while advance() runs.
    void explain(std::span<const std::uint32_t> which, std::span<gather::Estimate> out);
    /// Number of the light that irradiance() answers with; grows whenever advance() changed it. 0: none yet.
    [[nodiscard]] std::uint64_t lightRevision() const;

    [[nodiscard]] Statistics statistics() const;
    void countUpload(double milliseconds);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace pie::engine
