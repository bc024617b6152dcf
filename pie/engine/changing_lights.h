#pragma once
// Lights that may change any moment, beside those that stand still: the flashlight, a lamp that is dragged.
//
// Their photons are a ring of `renewalFrames` frames, in pieces of a quarter frame. When a light changes, the ring is
// traced again, oldest piece first, each piece in place of what it was: every photon keeps its index, and with it its
// random numbers (frame coherence, pi-engine 5.2.2), so that what has not moved does not flicker. Once the whole ring
// is of the present lights and nothing changes, further photons are added until there are `stillFrames` frames of them;
// the next change drops these again. Their direct light is by shadow rays, made anew at once.
//
// Protocol, per frame: commit() and apply() while nobody asks, trace() in between, beside those who ask.

#include "pie/gather/cached_gather.h"
#include "pie/gather/direct.h"
#include "pie/intersect/intersector.h"
#include "pie/lights/light_set.h"
#include "pie/photons/tracer.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace pie::engine {

struct ChangingOptions {
    photons::TracerOptions tracer; ///< first hits are stored whatever it says
    bool shadowRays = true;        ///< else direct light comes from photons
    gather::DirectOptions direct;
    std::uint64_t photonsPerFrame = 10'000;
    std::size_t renewalFrames = 10, stillFrames = 100;
};

class ChangingLights {
public:
    /// Pieces of a frame, and parts (gather::PhotonSums) of a piece.
    static constexpr unsigned pieces = 4, partsOfPiece = gather::PhotonSums::batches / pieces;

    /// References must outlive it.
    ChangingLights(std::shared_ptr<const scene::Scene> scene, const intersect::Intersector& intersector,
                   const scene::Receivers& receivers, const ChangingOptions& options);

    /// Light number `number`, from 0; nullopt: there is none any more.
    void set(std::size_t number, std::optional<lights::Light> light);
    [[nodiscard]] const std::vector<std::optional<lights::Light>>& lights() const { return wanted_; }

    /// Makes what was set since the last time the present lights. Returns whether anything was.
    bool commit(gather::CachedGather& gather);
    /// Pieces that are left to trace: 0 when all is as good as it gets.
    [[nodiscard]] std::size_t pending() const;
    /// Traces the next pieces, at most pending().
    photons::TraceCounts trace(std::size_t count);
    /// The first `count` photons of one frame of the present lights, for looking at.
    void sample(std::uint64_t count, std::vector<photons::Photon>& out) const { tracer_.trace(0, count, out); }
    /// Hands them over. Returns the number of photons that are now in the sums of `gather`, less those before.
    std::int64_t apply(gather::CachedGather& gather);
    /// Null where photons bring direct light.
    [[nodiscard]] const gather::DirectLight* direct() const { return direct_.get(); }
    [[nodiscard]] std::size_t bytes() const;

private:
    struct Piece {
        std::vector<photons::Photon> photons;
        std::uint64_t revision = 0; ///< of the lights it was traced with; 0: never
    };
    [[nodiscard]] static unsigned firstPart(std::size_t piece) {
        return static_cast<unsigned>(piece % pieces) * partsOfPiece;
    }

    std::shared_ptr<const scene::Scene> scene_;
    ChangingOptions options_;
    std::uint64_t photonsOfPiece_;
    std::vector<std::optional<lights::Light>> wanted_;
    bool changed_ = false;
    lights::LightSet lights_;
    photons::PhotonTracer tracer_;
    std::unique_ptr<gather::DirectLight> direct_;
    double power_ = 0; ///< of the sums' unit, watts
    std::uint64_t revision_ = 0;
    std::vector<Piece> ring_;
    std::size_t next_ = 0;    ///< oldest of the ring
    std::size_t stale_ = 0;   ///< of the ring
    std::size_t surplus_ = 0; ///< pieces beyond the ring
    std::vector<std::vector<photons::Photon>> fresh_;
    std::size_t freshCount_ = 0;
};

} // namespace pie::engine
