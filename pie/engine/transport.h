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
//
// Lights may be changed between frames (setLight). Where light is gathered, what has not changed keeps its photons and
// answers, and what has is renewed within `accumulation_frames` frames; elsewhere all photons are renewed.
//
// With `budget_ms` a frame does as much as fits into that time, both calls together; what is settled does not depend on
// it. With `target_error` photons are traced until the standard error of what is in view is that small.

#include "pie/core/vec.h"
#include "pie/engine/settings.h"
#include "pie/engine/statistics.h"
#include "pie/gather/gather.h"
#include "pie/gather/texels.h"
#include "pie/intersect/intersector.h"
#include "pie/level/level.h"
#include "pie/lights/light_set.h"
#include "pie/photons/photon.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace pie::engine {

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

    /// Light number `number` from now on: below the number of lights it was made with, one of those; from there on,
    /// lights of one's own. nullopt: none. Shows in the next frame. By the thread that calls advance().
    void setLight(std::size_t number, std::optional<lights::Light> light);
    /// Of the lights there have been so far: the number a light of one's own may get next.
    [[nodiscard]] std::size_t lightCount() const;

    /// Next frame of photons. Returns whether the light changed. One thread at a time.
    bool advance();
    /// Light at receivers.points[which[i]] in watts per square unit, as good as it is known. Zero before the first
    /// advance(). What was asked for since the last advance() is what advance() refines (estimator = gather). Returns
    /// whether the answers are of lightRevision(): with budget_ms those of some frame before may come again.
    bool irradiance(std::span<const std::uint32_t> which, std::span<Rgb> out);
    /// Refines these to the end now, however long it takes. Counts as asking for them.
    void finish(std::span<const std::uint32_t> which);
    /// The same with standard error, bias, photons and radius: slow, for tools. Not while advance() runs.
    void explain(std::span<const std::uint32_t> which, std::span<gather::Estimate> out);
    /// For looking at: rays, or photons of the search, that each answer rests on so far.
    void samples(std::span<const std::uint32_t> which, std::span<std::uint32_t> out);
    /// For looking at: where the first `count` photons of the lights as they are land, all hits of them, first ones
    /// included. By the thread that calls advance().
    [[nodiscard]] std::vector<photons::Photon> photons(std::uint64_t count);
    /// Number of the light that irradiance() answers with; grows whenever advance() changed it. 0: none yet.
    [[nodiscard]] std::uint64_t lightRevision() const;

    [[nodiscard]] Statistics statistics() const;
    void countUpload(double milliseconds);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace pie::engine
