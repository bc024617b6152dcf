#pragma once
// The engine of one level: reads like the data flow in doc/architecture.md. Two calls per frame:
//
//   advance()     update stage: traces the photons of this frame and renews the photon map;
//   irradiance()  draw stage, any thread, several at once: light at the receivers that are about to be drawn.
//
// The tracer is a pure function of scene revision and photon index, so a scene that stands still is traced for
// `accumulation_frames` frames and then costs nothing: advance() returns at once and irradiance() copies what the cache
// holds.

#include "pie/core/vec.h"
#include "pie/engine/settings.h"
#include "pie/level/level.h"
#include "pie/lights/import.h"
#include "pie/photons/tracer.h"
#include "pie/scene/mesh.h"
#include "pie/scene/receivers.h"

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
    std::uint64_t directRays = 0;
    std::uint64_t directEstimates = 0; ///< receivers whose direct light was computed
    std::uint64_t estimatesMade = 0, estimatesReused = 0;
    std::size_t receivers = 0, drawnTriangles = 0, coarseTriangles = 0, lights = 0;
    double prepareMs = 0, traceMs = 0, buildMs = 0, directMs = 0, estimateMs = 0, uploadMs = 0;
    std::size_t sceneBytes = 0, intersectorBytes = 0, mapBytes = 0, receiverBytes = 0;
    /// One JSON object, keys as above in snake_case.
    [[nodiscard]] std::string json() const;
};

class Engine {
public:
    /// Refines the drawn mesh at once (the renderer needs it); scene, lights and intersector are built by the first
    /// advance() or prepare().
    Engine(std::shared_ptr<const level::Level> level, const Settings& settings);
    ~Engine();
    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;

    [[nodiscard]] const level::Level& level() const;
    [[nodiscard]] const std::shared_ptr<const level::Level>& sharedLevel() const;
    [[nodiscard]] const Settings& settings() const;
    /// The mesh that is drawn: refined when the view shows our light, else as it is in the level.
    [[nodiscard]] const scene::Mesh& mesh() const;
    /// Empty when the view does not show our light.
    [[nodiscard]] const scene::Receivers& receivers() const;

    /// Builds what tracing needs, once; later calls return at once. Safe from any thread.
    void prepare();
    /// What light was found; empty before prepare().
    [[nodiscard]] const lights::ImportedLights& lights() const;

    /// Next frame of photons. Returns whether the light changed. One thread at a time.
    bool advance();
    /// Light at receivers.points[which[i]] in watts per square unit (lightmap units U). Zero before the first
    /// advance().
    void irradiance(std::span<const std::uint32_t> which, std::span<Rgb> out);
    /// Number of the light that irradiance() answers with; grows whenever advance() changed it.
    [[nodiscard]] std::uint64_t lightRevision() const;

    [[nodiscard]] Statistics statistics() const;
    /// For renderers: time spent on sending light to the graphics card.
    void countUpload(double milliseconds);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace pie::engine
