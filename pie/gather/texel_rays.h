#pragma once
// The rays of a final gather: which texels a receiver sees, by cosine-distributed rays (pi-engine 3.2.2, eq 3.10).
//
// The hemisphere is cut into n / 2 strata of equal weight, each with two independent rays. Stratification makes the
// mean of n rays much better than n random ones; the difference between the two rays of a stratum is what its error is
// estimated from, without bias. Rays are a pure function of the receiver's position and normal, n and the seed: they
// need not be kept to be had again. Two-sided receivers shoot n rays on each side.

#include "pie/core/vec.h"
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
    float distance = 0;
    Vec3 point{0.0F};
};

class TexelRays {
public:
    /// `offset`: how far off the surface rays start, units. References must outlive it.
    TexelRays(const scene::Scene& scene, const intersect::Intersector& intersector, const SurfaceTexels& texels,
              const scene::Receivers& receivers, float offset, std::uint64_t seed);

    /// Rays of a receiver with n of them: n, or 2 n when it is two-sided. n: a power of two, at least 2.
    [[nodiscard]] std::size_t count(std::uint32_t receiver, unsigned n) const;
    /// Appends the hits of these receivers, one after the other, the two rays of a stratum together. One thread.
    void shoot(std::span<const std::uint32_t> which, unsigned n, std::vector<TexelHit>& hits) const;

private:
    void trace(std::vector<intersect::Ray>& rays, std::span<TexelHit> hits) const;

    const scene::Scene& scene_;
    const intersect::Intersector& intersector_;
    const SurfaceTexels& texels_;
    const scene::Receivers& receivers_;
    float offset_;
    std::uint64_t seed_;
    bool filters_;
};

} // namespace pie::gather
