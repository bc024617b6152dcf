#pragma once
// What a Transport consists of, and the steps of a frame. Inside pie/engine only.

#include "pie/engine/changing_lights.h"
#include "pie/engine/convergence.h"
#include "pie/engine/frame_budget.h"
#include "pie/engine/transport.h"
#include "pie/gather/cached_gather.h"
#include "pie/gather/direct.h"
#include "pie/maps/realtime.h"
#include "pie/photons/tracer.h"

#include <atomic>
#include <mutex>

namespace pie::engine {

/// Parts of a frame of photons, where light is gathered.
inline constexpr unsigned partsOfFrame = gather::PhotonSums::batches;

/// The paper's estimate cache by index: what a receiver's light was, and of which revision it is.
struct EstimateCache {
    std::vector<Rgb> irradiance;
    std::vector<std::uint64_t> revision; ///< 0: never estimated

    explicit EstimateCache(std::size_t receivers) : irradiance(receivers), revision(receivers, 0) {}
    [[nodiscard]] std::size_t bytes() const { return revision.size() * (sizeof(Rgb) + sizeof(std::uint64_t)); }
};

struct Transport::State {
    std::shared_ptr<const scene::Scene> scene;
    lights::LightSet lights; ///< those that stand still; with a photon map, all
    std::unique_ptr<const intersect::Intersector> intersector;
    const scene::Receivers& receivers;
    Settings settings;
    photons::PhotonTracer tracer;
    maps::RealtimeMap map;
    std::unique_ptr<gather::DirectLight> direct;  ///< null: direct light comes from photons
    std::unique_ptr<gather::Estimator> estimator; ///< light from the map, or all light where it gathers
    gather::CachedGather* gathering = nullptr;    ///< the estimator, when it is one: then there is no map
    /// Null until a light changes.
    std::unique_ptr<ChangingLights> changing;
    std::size_t levelLights, lightCount;
    std::vector<std::uint32_t> toMute;                   ///< level lights that are to leave those that stand still
    std::vector<std::optional<lights::Light>> mapLights; ///< with a photon map: all lights, once one has changed
    bool mapLightsChanged = false;
    EstimateCache cache;
    std::vector<std::uint64_t> asked;  ///< by receiver: round of its last question
    std::vector<std::uint32_t> inView; ///< asked for in the last round, in order
    std::vector<std::uint32_t> wanted; ///< of these, to be refined
    std::uint32_t nextInView = 0;      ///< receiver whose answer is the oldest
    /// What is asked for and not known, and its light: kept from question to question for their memory.
    std::vector<std::uint32_t> missing;
    std::vector<Rgb> answers, directAnswers;
    /// Questions between two frames are a round. Frames without any go on with the last.
    std::uint64_t round = 1;
    bool askedInRound = false;
    FrameBudget budget;
    Convergence convergence;
    bool behind = false;                         ///< answers to what is in view may be older than the light
    std::size_t framesTraced = 0;                ///< into the map
    std::uint64_t partsTraced = 0, partsToTrace; ///< of frames, where light is gathered
    std::vector<photons::Photon> spent;          ///< memory for the next frame of a gather
    std::atomic<std::uint64_t> lightRevision{0};
    std::mutex mutex; ///< map, cache and statistics: advance() swaps a frame in while no estimate runs
    Statistics statistics;

    State(Surroundings&& around, std::vector<lights::Light> theLights, const level::Tree& tree,
          const scene::Receivers& theReceivers, const Settings& theSettings);
    void estimate(std::span<const std::uint32_t> which, std::uint64_t revision);
    [[nodiscard]] FrameBudget::Plan plan();
    [[nodiscard]] std::uint64_t photonIndex(std::uint64_t part) const;
    void aim(gather::CachedGather& gather);
    void setLight(std::size_t number, std::optional<lights::Light> light);
    void mute(std::uint32_t light);
    bool changeLights();
    void count(const photons::TraceCounts& counts);
    photons::TraceCounts traceStill(unsigned parts, std::vector<photons::Photon>& photons) const;
    void take(std::vector<photons::Photon>&& photons, unsigned parts);
    void ask(std::span<const std::uint32_t> which);
    void collect();
    bool refine(std::uint64_t rays);
    void explain(std::span<const std::uint32_t> which, std::span<gather::Estimate> out);
    void judge(bool refined);
    bool answer(std::uint64_t most);
};

} // namespace pie::engine
