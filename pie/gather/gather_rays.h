#pragma once
// The rays of a final gather, and what they meet. Internal to this folder.

#include "pie/gather/final_gather.h"
#include "pie/lights/light_set.h"
#include "pie/sampling/halton.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <vector>

namespace pie::gather {

/// Light of a receiver is Σ base + Σ factor · E(term), of which E changes with the photons.
struct Bundle {
    /// Rays fall into groups by their number; what the groups differ by is the noise of the rays.
    static constexpr unsigned groups = 16;
    struct Term {
        Vec3 position{0.0F};
        std::uint32_t triangle = 0;
        Rgb factor{0.0F};
        Vec3 growth{0.0F};      ///< relative change of the factor per unit that the receiver moves
        bool back = false;      ///< met on the back of a two-sided surface
        std::uint8_t group = 0; ///< of its ray
    };
    std::vector<Term> terms;
    std::array<Rgb, groups> base{};    ///< direct light of near hits, by group
    std::array<Rgb, 3> baseGradient{}; ///< change of all of it per unit along x, y and z
    double inverseDistances = 0;       ///< Σ 1/t over all rays
    std::uint32_t rays = 0;            ///< from the receiver; of both sides of two-sided ones

    /// Harmonic mean of the distances seen; infinite where nothing is.
    [[nodiscard]] float meanDistance() const {
        return static_cast<float>(static_cast<double>(rays) / std::max(1e-30, inverseDistances));
    }
};

class GatherRays {
public:
    /// `direct`: an estimator of light straight from lights for any points, called once per batch.
    using Direct = std::function<void(const scene::Receivers& points, std::span<Rgb> irradiance)>;

    GatherRays(const scene::Scene& scene, const intersect::Intersector& intersector, const FinalGatherOptions& options,
               Direct direct);
    /// bundles[i] of receivers[i]; each depends on that receiver alone.
    void shoot(std::span<const scene::Receiver> receivers, std::span<Bundle> bundles) const;
    [[nodiscard]] std::uint64_t raysTraced() const { return rays_; }
    /// The hit as a point that light can be asked for.
    [[nodiscard]] scene::Receiver pointOf(const Bundle::Term& term) const;

private:
    struct Batch;
    void trace(Batch& batch) const;
    void addHemisphere(Batch& batch, std::uint32_t receiver, const Vec3& origin, const Vec3& normal, std::uint64_t key,
                       unsigned count, const Rgb& factor, const Vec3& growth, int group) const;
    [[nodiscard]] Vec3 litNormal(std::uint32_t triangle, bool back) const;

    const scene::Scene& scene_;
    const intersect::Intersector& intersector_;
    FinalGatherOptions options_;
    Direct direct_;
    sampling::Halton halton_;
    float offset_;
    mutable std::atomic<std::uint64_t> rays_{0};
};

} // namespace pie::gather
