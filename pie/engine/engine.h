#pragma once
// The engine of one level: reads like the data flow in doc/architecture.md. Two calls per frame:
//
//   advance()     update stage: traces the photons of this frame and renews the photon map;
//   irradiance()  draw stage, any thread, several at once: light at the receivers that are about to be drawn.
//
// What happens in them is Transport's; the Engine knows the level and the mesh that is drawn.

#include "pie/core/vec.h"
#include "pie/engine/settings.h"
#include "pie/engine/transport.h"
#include "pie/level/level.h"
#include "pie/lights/import.h"
#include "pie/scene/mesh.h"
#include "pie/scene/receivers.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

namespace pie::engine {

/// When the drawn mesh is refined: by the constructor of the engine, or by refine().
enum class Refinement : std::uint8_t { AtOnce, Later };

class Engine {
public:
    /// Scene, lights and intersector are built by the first advance(), prepare() or complete().
    Engine(std::shared_ptr<const level::Level> level, const Settings& settings,
           Refinement refinement = Refinement::AtOnce);
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

    /// With Refinement::Later, to be called once and alone, before everything below: refines the mesh and finds its
    /// receivers. Until then mesh() is as it is in the level. After `stop` it returns soon, and the engine is good for
    /// nothing more.
    void refine(const std::stop_token& stop = {});
    [[nodiscard]] bool refined() const;

    /// Builds what tracing needs, once; later calls return at once. Safe from any thread.
    void prepare();
    /// Like refine() and then prepare(), but side by side as far as that goes.
    void complete(const std::stop_token& stop = {});
    /// What light was found; empty before prepare().
    [[nodiscard]] const lights::ImportedLights& lights() const;

    /// Light number `number` from now on; nullopt: none. Below lights().lights.size(): one of the level's, which so
    /// moves, changes or goes out. From there on: lights of one's own, in any number; directions of any length. Shows
    /// in the next frame; the light it throws back is renewed within `accumulation_frames`. By the thread that calls
    /// advance(). Calls prepare().
    void setLight(std::size_t number, std::optional<lights::Light> light);
    /// The number a further light of one's own may take: one more than the largest so far. Calls prepare().
    [[nodiscard]] std::size_t lightCount();

    /// Next frame of photons. Returns whether there was anything to do: false says that the light stands still, as good
    /// as the settings let it become. One thread at a time.
    bool advance();
    /// Light at receivers.points[which[i]] in watts per square unit (lightmap units U). Zero before the first
    /// advance(). Returns whether it is that of lightRevision(): with budget_ms some of it may be a few frames old.
    bool irradiance(std::span<const std::uint32_t> which, std::span<Rgb> out);
    /// Refines these receivers to the end now, however long it takes. After the first advance() or prepare().
    void finish(std::span<const std::uint32_t> which);
    /// For looking at: rays, or photons of the search, that each answer rests on so far. Zero before the first
    /// advance(). Any thread.
    void samples(std::span<const std::uint32_t> which, std::span<std::uint32_t> out);
    /// For looking at: the first `count` photons of the lights as they are, every hit of theirs. Calls prepare(). By
    /// the thread that calls advance().
    [[nodiscard]] std::vector<photons::Photon> photons(std::uint64_t count);
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
