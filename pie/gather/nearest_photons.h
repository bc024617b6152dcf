#pragma once
// Irradiance from the k nearest photons, in two estimators behind one interface.
//
// "nearest" is the paper's (pi-engine eq 3.3): the flux of the k nearest photons within maxRadius over π r², with r the
// distance of the k-th. Photons of other surfaces are kept out while searching by the sphere slice (fig 3.8) and, for
// thin walls, by their incoming direction (3.5.1). At an edge half of π r² is not there, in a corner three quarters:
// the estimate loses as much.
//
// "true_area" divides by the surface that exists instead (TrueArea) and weights photons by a kernel. It accepts exactly
// the photons that lie on that surface; the two sides of a two-sided receiver are estimated each over their own surface
// and added.
//
// Both: with fewer than k photons within maxRadius, r is maxRadius. No photons: 0. Results are finite and not negative
// whatever the photons carry. The last photon lies on the border by construction, so it is left out of the sum
// (`dropFarthest`): (k − 1)/(π r_k²) is unbiased where k/(π r_k²) is k/(k − 1) times too bright. Kernels that vanish at
// the border do that by themselves.
//
// Floors: r is at least maxRadius / 1000, the share of the disc that exists at least 1/256. Where they bind, the
// estimate is too dark rather than infinite.

#include "pie/gather/area.h"
#include "pie/gather/gather.h"
#include "pie/maps/realtime.h"
#include "pie/scene/scene.h"

#include <cstddef>

namespace pie::gather {

struct NearestOptions {
    std::size_t maxCount = 50; ///< k, the paper's max_search_count; 0: no light from photons
    float maxRadius = 192;     ///< units; cut down to the diagonal of the scene. 0 or less: no light from photons
    /// Shrinks maxRadius where there are many photons, to sqrt(k r_n² / (alpha n)) (eq 3.7), with r_n half the diagonal
    /// of the photons' bounding box.
    bool radiusHeuristic = false;
    float heuristicAlpha =
        0.1F; ///< a result below this share of the mean irradiance counts as dark; larger: smaller radius
    bool sphereSlice = true;       ///< "nearest" only; "true_area" always slices
    bool incomingDirection = true; ///< "nearest" only: photons that came from behind the receiver do not count
    SliceOptions slice;
    Kernel kernel = Kernel::Constant;
    bool dropFarthest = true;  ///< Constant, Cone and Gaussian with k > 1
    bool indirectOnly = false; ///< skips photons of bounce 0. Always so when direct light is added
};

class NearestPhotons final : public Estimator {
public:
    /// The paper's estimate. All references must outlive the estimator; `direct` may be null: then direct light has to
    /// come from photons. The map may be rebuilt between calls, not during one.
    NearestPhotons(const scene::Scene& scene, const scene::Receivers& receivers, const maps::RealtimeMap& map,
                   const NearestOptions& options, const Estimator* direct = nullptr);
    /// The true-area estimate. `area` brings kernel, slice and largest radius; those of `options` are ignored.
    NearestPhotons(const scene::Scene& scene, const scene::Receivers& receivers, const maps::RealtimeMap& map,
                   const NearestOptions& options, const TrueArea& area, const AreaTable& table,
                   const Estimator* direct = nullptr);

    void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const override;
    [[nodiscard]] std::string_view name() const override { return table_ != nullptr ? "true_area" : "nearest"; }
    /// Radius a search starts with, after the heuristic.
    [[nodiscard]] float searchRadius() const;

private:
    template <class Map>
    [[nodiscard]] Rgb one(const Map& map, std::uint32_t receiver, float radius, maps::NearestQueue& queue) const;

    const scene::Scene& scene_;
    const scene::Receivers& receivers_;
    const maps::RealtimeMap& map_;
    NearestOptions options_;
    const AreaTable* table_ = nullptr;
    const Estimator* direct_;
};

} // namespace pie::gather
