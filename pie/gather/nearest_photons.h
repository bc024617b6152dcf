#pragma once
// Irradiance from the photons near a receiver (pi-engine 3.1.4, eq 3.3): their flux over the area they lie on. Four
// choices that do not depend on each other:
//
//   volume   where photons count: SearchVolume. Photons of other surfaces are kept out while searching, not afterwards.
//   radius   how large it is: RadiusRule.
//   area     what flux is divided by: AreaEstimate. At an edge half of the paper's pi r² is not there, in a corner
//   three
//            quarters; the estimate loses as much.
//   kernel   how much a photon counts by its distance.
//
// With AreaEstimate::True exactly the photons on the surface that is counted are accepted, and the two sides of a
// two-sided receiver are estimated each over their own surface and added. With the others, photons that came from
// behind the receiver are refused (`incomingDirection`), which keeps out the back of thin walls (3.5.1).
//
// Where the map is several (maps::Partition), only those that matter to the receiver are searched. By normal: photons
// on surfaces that face like the receiver, up to SliceOptions::minCosine, whatever the area; by cell: photons of the
// cells that the receiver may see. The answer is that of one map with these two conditions as a filter.
//
// With fewer than k photons within the largest radius, that is the radius. No photons: 0. Results are finite and not
// negative whatever the photons carry. Photons that carry the border of what is divided by are left out of the sum
// (`dropBorder`), above all the k-th: (k - 1)/(pi r_k²) is unbiased where k/(pi r_k²) is k/(k - 1) times too bright.
//
// Floors: the radius is at least maxRadius / 1000, the area at least 1/256 of the disc. Where they bind, the estimate
// is too dark rather than infinite. Where photons are too few for a shape (PhotonShape), the disc stands in.
//
// `explain` adds the standard error: the frames in the map are batches, and with the radius fixed by the whole each
// gives an estimate of its own. Their spread holds for the noise of the radius, too: k photons that differ by chance
// and a radius that does have the same variance. With fewer than four frames it takes photons for independent, which
// is too much for Halton points. The bias is guessed from a second estimate within r / sqrt(2): a bias that grows
// with r² is twice the difference. What noise explains of the difference is taken off first.

#include "pie/gather/area.h"
#include "pie/gather/gather.h"
#include "pie/gather/photon_shape.h"
#include "pie/gather/search_volume.h"
#include "pie/maps/realtime.h"
#include "pie/scene/scene.h"

#include <atomic>
#include <cstddef>
#include <memory>

namespace pie::gather {

enum class RadiusRule : std::uint8_t {
    Nearest, ///< that of the k-th nearest photon, at most maxRadius
    Fixed,   ///< maxRadius; every photon within it
    /// As Nearest, with k growing as frames^alpha and maxRadius shrinking as frames^((alpha - 1) / 2): the rule of
    /// progressive photon mapping (Hachisuka, Ogaki and Jensen 2008) for a map that still has all photons. Noise and
    /// bias both vanish as frames come in, where a fixed k keeps its noise for ever and a fixed radius its bias.
    Progressive,
};

struct NearestOptions {
    std::size_t maxCount = 50; ///< k, the paper's max_search_count; 0: no light from photons. Not for RadiusRule::Fixed
    float maxRadius = 192;     ///< units; cut down to the diagonal of the scene. 0 or less: no light from photons
    RadiusRule radius = RadiusRule::Nearest;
    float progressiveAlpha = 0.7F; ///< 0 to 1. 0: k does not grow; 1: the radius does not shrink
    /// Shrinks maxRadius where there are many photons, to sqrt(k r_n² / (alpha n)) (eq 3.7), with r_n half the diagonal
    /// of the photons' bounding box.
    bool radiusHeuristic = false;
    float heuristicAlpha =
        0.1F; ///< a result below this share of the mean irradiance counts as dark; larger: smaller radius
    SearchVolume volume = SearchVolume::Slice;
    SliceOptions slice; ///< of AreaEstimate::True; the others use its thickness, the cosine with split maps only
    bool incomingDirection = true; ///< but for AreaEstimate::True: photons from behind the receiver do not count
    AreaEstimate area = AreaEstimate::Disc;
    Kernel kernel = Kernel::Constant;
    bool dropBorder = true;    ///< the k-th photon with kernels that do not vanish there, and corners of a PhotonShape
    bool indirectOnly = false; ///< skips photons of bounce 0. Always so when direct light is added
};

class NearestPhotons final : public Estimator {
public:
    /// Which photons count: those the options say, or first hits alone.
    enum class Bounces : std::uint8_t { OfOptions, Direct };

    /// Any area but True, which is taken for Disc. All references must outlive the estimator; `direct` may be null:
    /// then direct light has to come from photons. The map may be rebuilt between calls, not during one.
    NearestPhotons(const scene::Scene& scene, const scene::Receivers& receivers, const maps::RealtimeMap& map,
                   const NearestOptions& options, const Estimator* direct = nullptr);
    /// AreaEstimate::True with a table that others share. `area` brings volume, kernel, slice and largest radius; those
    /// of `options` are ignored. It must know the partition of the map.
    NearestPhotons(const scene::Scene& scene, const scene::Receivers& receivers, const maps::RealtimeMap& map,
                   const NearestOptions& options, const TrueArea& area, const AreaTable& table,
                   const Estimator* direct = nullptr);

    void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const override;
    void explain(std::span<const std::uint32_t> which, std::span<Estimate> estimates) const override;
    [[nodiscard]] const SliceOptions& slice() const { return options_.slice; }
    /// Of the area tables that it made itself.
    [[nodiscard]] std::size_t bytes() const override;
    [[nodiscard]] maps::Visits visits() const override;
    [[nodiscard]] std::string_view name() const override { return table_ != nullptr ? "true_area" : "nearest"; }
    /// The same at any points; AreaEstimate::True computes each area anew, which costs more than the search. Direct
    /// light is not added.
    void estimateAt(std::span<const scene::Receiver> points, std::span<Rgb> irradiance,
                    Bounces bounces = Bounces::OfOptions) const;
    /// Adds the channel mean of Σ factors[i] · estimate at points[i] to `batches`, split by the frames of the map
    /// (RealtimeMap::frameEnds); returns the sum of the radii. In the calling thread.
    double splitAt(std::span<const scene::Receiver> points, std::span<const Rgb> factors,
                   std::vector<double>& batches) const;
    /// Radius a search starts with, after heuristic and progression.
    [[nodiscard]] float searchRadius() const;
    /// Photons a search looks for, after progression.
    [[nodiscard]] std::size_t searchCount() const;

private:
    struct Search;
    template <class Use> void forEach(std::span<const std::uint32_t> which, const Use& use) const;
    template <class At, class Use>
    void forEachIn(std::size_t begin, std::size_t end, const At& at, const Use& use) const;
    [[nodiscard]] bool finds() const;
    [[nodiscard]] double areaShare(const Search& search, bool back) const;
    template <class Map> void find(const Map& map, Search& search) const;
    template <class Map> void ask(const Map& map, Search& search) const;
    void readArea(const TrueArea& area);
    void weigh(Search& search) const;
    void weighByShape(Search& search, double least) const;

    const scene::Scene& scene_;
    const scene::Receivers& receivers_;
    const maps::RealtimeMap& map_;
    NearestOptions options_;
    std::unique_ptr<const TrueArea> ownArea_;
    std::unique_ptr<const AreaTable> ownTable_;
    const TrueArea* area_ = nullptr;
    const AreaTable* table_ = nullptr;
    const Estimator* direct_;
    /// Sums of Visits.
    struct Counters {
        std::atomic<std::uint64_t> nodes{0}, leaves{0}, photons{0};
    };
    mutable Counters counters_;
};

} // namespace pie::gather
