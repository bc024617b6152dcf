#pragma once
// The rays of a final gather: which texels a receiver sees, by cosine-distributed rays (pi-engine 3.2.2, eq 3.10).
//
// The hemisphere is cut into n / 2 strata of equal weight, each with two independent rays. Stratification makes the
// mean of n rays much better than n random ones; the difference between the two rays of a stratum is what its error is
// estimated from, without bias. Where there are bright texels, a quarter as many rays again are aimed at those, in
// strata and pairs likewise. Every hit has a weight, by which the light of its texel counts: 1/n, less where the other
// kind of rays leads to the same place too (balance heuristic). Rays are a pure function of the receiver's position and
// normal, n and the seed: they need not be kept to be had again. Two-sided receivers shoot n rays on each side.

#include "pie/core/vec.h"
#include "pie/gather/bright_texels.h"
#include "pie/gather/texels.h"
#include "pie/intersect/intersector.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <span>
#include <vector>

namespace pie::gather {

/// Where a ray ended.
struct TexelHit {
    std::uint32_t texel = SurfaceTexels::none; ///< none: sky, the back of a surface, nothing
    float weight = 0;                          ///< irradiance from the texel's radiosity
    float distance = 0;
    Vec3 point{0.0F};
    Vec3 direction{0.0F}; ///< of the ray
    float cosine = 0;     ///< between ray and surface, positive
};

class TexelRays {
public:
    /// `offset`: how far off the surface rays start, units. References must outlive it.
    TexelRays(const scene::Scene& scene, const intersect::Intersector& intersector, const SurfaceTexels& texels,
              const BrightTexels& bright, const scene::Receivers& receivers, float offset, std::uint64_t seed);

    /// Rays of a receiver with n of them: n, or 2 n when it is two-sided, and those aimed at bright texels. n: a power
    /// of two, at least 2.
    [[nodiscard]] std::size_t count(std::uint32_t receiver, unsigned n) const;
    /// Appends the hits of these receivers, one after the other, the two rays of a stratum together. One thread.
    void shoot(std::span<const std::uint32_t> which, unsigned n, std::vector<TexelHit>& hits) const;

private:
    [[nodiscard]] unsigned aimed(unsigned n) const { return bright_.empty() ? 0 : std::max(2U, n / 8 * 2); }
    void addHemisphere(const scene::Receiver& receiver, unsigned n, std::vector<intersect::Ray>& rays) const;
    /// `targets`: number among the bright texels of each ray, and where on it; the sum of chances is returned.
    struct Target {
        std::uint32_t texel = SurfaceTexels::none;
        Vec3 point{0.0F};
    };
    float addAimed(const scene::Receiver& receiver, unsigned count, std::vector<float>& sums,
                   std::vector<intersect::Ray>& rays, std::vector<Target>& targets) const;
    void weigh(const scene::Receiver& receiver, unsigned n, float chances, std::span<TexelHit> hits,
               std::span<const Target> targets) const;
    void trace(std::vector<intersect::Ray>& rays, std::span<TexelHit> hits) const;

    const scene::Scene& scene_;
    const intersect::Intersector& intersector_;
    const SurfaceTexels& texels_;
    const BrightTexels& bright_;
    const scene::Receivers& receivers_;
    float offset_;
    std::uint64_t seed_;
    bool filters_;
};

} // namespace pie::gather
