#pragma once
// The photon tracer (pi-engine 3.1.1, 5.2, fig 5.3). It is handed photon indices, never counts; tracing index 17 twice
// gives the same path, on any number of threads, in any order: every random number is halton(index, dimension).
//
// Batches of paths advance together, bounce by bounce, so that the intersector gets many rays per call. The next ray
// starts at a point moved back along the incoming direction, not along the normal (fig 5.4: in narrow corners the
// normal leads outside).

#include "pie/intersect/intersector.h"
#include "pie/lights/light_set.h"
#include "pie/photons/photon.h"
#include "pie/sampling/halton.h"

#include <cstdint>
#include <vector>

namespace pie::photons {

struct TracerOptions {
    enum class Scattering : std::uint8_t {
        RussianRoulette, ///< one photon goes on with probability = reflectance: few rays, equal powers
        Splitting, ///< the paper's: `diffuseReflections` photons go on, each with reflectance / diffuseReflections of
                   ///< the power
    };
    Scattering scattering = Scattering::RussianRoulette;
    unsigned diffuseReflections = 36; ///< Splitting only; of the first hit; further hits send on one each … see source
    unsigned recursionDepth = 8;      ///< bounces at most; 0: direct light only
    bool storeDirectLight = false;    ///< store first hits as well (needed unless direct light comes from shadow rays)
    std::uint64_t seed = 0;
};

struct TraceCounts {
    std::uint64_t emitted = 0, rays = 0, stored = 0, escaped = 0, absorbed = 0, filtered = 0;
    /// Watts per channel, for the books: emitted = absorbed + escaped (+ cut off at recursionDepth).
    double emittedFlux[3]{}, absorbedFlux[3]{}, escapedFlux[3]{}, cutFlux[3]{};
};

class PhotonTracer {
public:
    /// Keeps references: scene, lights and intersector must outlive it.
    PhotonTracer(const scene::Scene& scene, const lights::LightSet& lights, const intersect::Intersector& intersector,
                 const TracerOptions& options);
    /// Appends the hits of indices [first, first + count) to `out`, in index order; each photon carries its share of a
    /// frame of `count` emitted photons. Nothing is emitted without lights.
    TraceCounts trace(std::uint64_t first, std::uint64_t count, std::vector<Photon>& out) const;

private:
    const scene::Scene& scene_;
    const lights::LightSet& lights_;
    const intersect::Intersector& intersector_;
    TracerOptions options_;
    sampling::Halton halton_;
};

} // namespace pie::photons
