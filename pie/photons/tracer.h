#pragma once
// The photon tracer (pi-engine 3.1.1, 5.2, fig 5.3). It is handed photon indices, never counts; tracing index 17 twice
// gives the same path, on any number of threads, in any order: every random number has an address (index, dimension),
// with dimensions 0 to 4 for the emission and three more for every bounce (two for the direction, one for roulette).
// Photons keep their numbers from frame to frame and revision to revision (frame coherence, 5.2.2): where nothing has
// moved, the same index takes the same path.
//
// Batches of paths advance together, so that the intersector gets many rays per call. The next ray starts at a point
// moved back along the incoming direction, not along the normal (fig 5.4: in narrow corners the normal leads outside).
// The step is as small as the precision of the coordinates allows and never reaches behind the ray's own origin.
//
// A one-sided surface stores and reflects light on its front only and absorbs what comes from behind; a two-sided one
// does both on both sides. A filter surface lets a photon pass by roulette and is opaque to the rest. Sky lets it go.
// A light that lies on a surface shines to both sides of it.

#include "pie/intersect/intersector.h"
#include "pie/lights/light_set.h"
#include "pie/photons/photon.h"
#include "pie/sampling/sequence.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace pie::photons {

struct TracerOptions {
    enum class Scattering : std::uint8_t {
        /// One photon goes on, with the probability that keeps its largest channel: few rays, equal powers. Where
        /// direct light is not stored the first reflection always survives and carries the reflectance in its flux:
        /// that nearly doubles the photons stored per ray.
        RussianRoulette,
        Splitting, ///< the paper's: `diffuseReflections` photons go on, each with reflectance / diffuseReflections of
                   ///< the power
    };
    Scattering scattering = Scattering::RussianRoulette;
    /// Splitting only: photons that every hit sends on, as in fig 5.3. Hits deeper than maxPathsPerPhoton allows (36:
    /// from the third on) send on one each, so that a photon costs at most maxPathsPerPhoton × recursionDepth rays. How
    /// the children of a hit are spread among themselves: sampling::fan.
    unsigned diffuseReflections = 36;
    unsigned recursionDepth = 32;  ///< bounces at most; 0: direct light only
    bool storeDirectLight = false; ///< store first hits as well (needed unless direct light comes from shadow rays)
    std::uint64_t seed = 0;
    /// Where numbers come from: for which light, place and direction of emission; for reflections and roulette.
    sampling::Distribution lightDistribution = sampling::Distribution::Halton;
    sampling::Distribution diffuseDistribution = sampling::Distribution::Halton;
    /// Stratified and Spiral only: points of a set, indices [n p, (n + 1) p) sharing one. Batches need not be frames:
    /// which point an index means does not depend on what is traced with it.
    std::uint64_t photonsPerFrame = 10'000;
};

/// Paths one photon may branch into (Splitting).
inline constexpr unsigned maxPathsPerPhoton = 4096;

struct TraceCounts {
    std::uint64_t emitted = 0, rays = 0, stored = 0;
    std::uint64_t escaped = 0, absorbed = 0, cut = 0; ///< how paths ended: left the level, swallowed, recursionDepth
    std::uint64_t backHits = 0;                       ///< of `absorbed`: on the back of a one-sided surface
    std::uint64_t filtered = 0;                       ///< filter surfaces passed
    /// Watts per channel, for the books: emitted = absorbed + escaped + cut, up to rounding of the sums. What roulette
    /// and the compiler's falloff add to or take from a photon is booked under `absorbed`.
    double emittedFlux[3]{}, absorbedFlux[3]{}, escapedFlux[3]{}, cutFlux[3]{};
    TraceCounts& operator+=(const TraceCounts& other);
};

struct Surroundings;

class PhotonTracer {
public:
    /// Keeps references: scene, lights and intersector must outlive it. Costs a pass over the triangles: make one per
    /// revision of the scene, not per frame.
    PhotonTracer(const scene::Scene& scene, const lights::LightSet& lights, const intersect::Intersector& intersector,
                 const TracerOptions& options);
    /// Appends the hits of indices [first, first + count) to `out`, in index order; each photon carries its share of a
    /// frame of `count` emitted photons. Nothing is emitted without lights.
    TraceCounts trace(std::uint64_t first, std::uint64_t count, std::vector<Photon>& out) const {
        return trace(first, count, count, out);
    }
    /// The same, each photon with its share of a frame of `frame`: parts of a frame that are traced apart are, put
    /// together, the frame to the bit.
    TraceCounts trace(std::uint64_t first, std::uint64_t count, std::uint64_t frame, std::vector<Photon>& out) const;

private:
    const scene::Scene& scene_;
    const lights::LightSet& lights_;
    const intersect::Intersector& intersector_;
    TracerOptions options_;
    sampling::Sequence emission_, reflection_;
    std::shared_ptr<const Surroundings> surroundings_;
};

} // namespace pie::photons
