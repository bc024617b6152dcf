#pragma once
// Final gathering (pi-engine 3.2.2): rays over the hemisphere of a receiver, distributed by the cosine, take the light
// that leaves what they meet from the photon map. Errors of the map are averaged over all that is met, so a coarse map
// gives smooth light. Only direct light is left out, which comes from elsewhere; photons of first hits must be in the
// map all the same, because what the rays meet is lit directly.
//
//   E = mean over rays of reflectance · E(hit)
//
// A wall close by fills much of the hemisphere with few photons' error, so hits nearer than `secondaryDistance` do not
// ask the map: they are gathered once more, and their direct light is computed. A receiver on an edge has many of them.
//
// `precompute`: irradiance is estimated at every n-th photon when the map was rebuilt, and a hit takes that of the
// nearest photon on its surface (Christensen 1999).
//
// `cacheAccuracy` above 0: only some receivers, the records, are gathered, and the others interpolate (Ward, Rubinstein
// and Clear 1988): weight 1 / (d/R + sqrt(1 − n·n')), R the harmonic mean of the distances seen from the record, where
// it exceeds 1 / accuracy. Records know how their light changes along the surface: what their rays met stays where it
// is while the receiver moves (Annen et al. 2004). Which receivers are records depends on the geometry alone and is
// decided once for all, so a receiver's answer does not depend on what else is asked.
//
// Rays are traced again for each estimate without the cache (nothing is stored), once with it (48 bytes a ray of a
// record). Rays are Halton points shifted per receiver: what is left of their noise stands still.

#include "pie/gather/gather.h"
#include "pie/gather/nearest_photons.h"
#include "pie/intersect/intersector.h"
#include "pie/lights/light_set.h"

#include <cstddef>
#include <cstdint>
#include <memory>

namespace pie::gather {

struct FinalGatherOptions {
    unsigned samples = 256;         ///< rays a receiver; 0: no light but direct
    float secondaryDistance = 16;   ///< units; 0: never
    unsigned secondarySamples = 16; ///< rays from a near hit
    unsigned precompute = 0;        ///< every how many photons irradiance is precomputed; 0: estimated at each hit
    float cacheAccuracy = 0;        ///< Ward's a: about the relative error of interpolation. 0: no cache
    float cacheSpacing = 8;         ///< units; R of a record is between this and 16 times as much
    bool addDirect = false;         ///< adds direct light at the receivers, from photons of first hits
    std::uint64_t seed = 0;
};

class FinalGather final : public Estimator {
public:
    /// All references must outlive it. `atHits`: how light is estimated where rays end, from all photons, first hits
    /// included. `lights`: direct light of near hits by shadow rays; null: from photons of first hits.
    FinalGather(const scene::Scene& scene, const intersect::Intersector& intersector, const scene::Receivers& receivers,
                const maps::RealtimeMap& map, const NearestOptions& atHits, const FinalGatherOptions& options,
                const lights::LightSet* lights = nullptr);
    ~FinalGather() override;
    FinalGather(const FinalGather&) = delete;
    FinalGather& operator=(const FinalGather&) = delete;

    /// Light from reflections alone, unless `addDirect`.
    void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const override;
    /// Standard error from the frames of the map and the spread of the rays, in quadrature; `photons` are rays,
    /// `radius` is the mean of the searches at hits.
    void explain(std::span<const std::uint32_t> which, std::span<Estimate> estimates) const override;
    [[nodiscard]] maps::Visits visits() const override;
    [[nodiscard]] std::string_view name() const override { return "final_gathering"; }

    [[nodiscard]] std::uint64_t raysTraced() const;
    [[nodiscard]] std::size_t records() const; ///< receivers gathered for the cache
    [[nodiscard]] std::size_t bytes() const override;

private:
    void reflected(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const;

    struct State;
    std::unique_ptr<State> state_;
};

} // namespace pie::gather
