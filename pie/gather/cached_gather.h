#pragma once
// The default estimator: a final gather over surface texels whose rays are shot once and kept.
//
//   E = direct light by shadow rays + Σ over the texels seen: weights of the rays that hit the texel · its radiosity
//
// The rays of a receiver depend on geometry alone, but for those that are aimed at what is bright once and for all.
// They are kept as a sparse row (texel, number of rays; gather_row.h), so that a new frame of photons costs a sparse
// matrix times a vector of colours: no tree, no search, no kernel, and no boundary bias at edges, where a level's
// vertices are. Photons only have to be right on the mean over what a receiver sees.
//
// A texel that fills much of what a receiver sees (the wall beside an edge) would pass its own noise on, and light
// changes within it. Such texels gather themselves, from points spread over them (the secondary gather of pi-engine
// 3.2.2, cached): each ray that meets one takes reflectance · (direct + gathered) of the nearest of these points in
// place of the photons that fell on the texel.
//
// Rows are made in stages, so that the first picture does not wait: a receiver starts with the light of its own texel,
// gets its direct light, then rows of ever more rays. refine() makes progress on those that are asked for, least
// refined first, about as many rays as it is told; what a receiver has once all stages are done does not depend on the
// order. Protocol: add photons, then refine() or update(), then ask; all but asking by one thread at a time, not while
// others ask.
//
// Lights that may change any moment have photons and direct light of their own (changing()), so that what they do is
// renewed and the rest stands.
//
// Combines photons summed into texels (selective photon tracing; GPU gathering), final gathering (pi-engine 3.2.2) and
// caching. doc/algorithms/cached-gather.md.

#include "pie/gather/direct.h"
#include "pie/gather/gather.h"
#include "pie/gather/gather_row.h"
#include "pie/gather/texel_light.h"
#include "pie/gather/texel_rays.h"
#include "pie/gather/texels.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace pie::gather {

struct GatherOptions {
    TexelOptions texels;
    unsigned texelRays = 256; ///< of a texel that gathers itself, over all its points
    unsigned rays =
        256; ///< of a finished row, rounded up to a power of two, 2 to 65,536. Noise that stays falls with it
    /// Reflections that light arrives by, at most. 0: direct light alone, nothing is gathered. 1: texels do not gather
    /// themselves. More: as many as the photons bring, which must have one less; beside edges one more.
    unsigned reflections = 32;
    /// Direct light of texels from the photons' first hits, not from shadow rays: noisier, and costs nothing however
    /// many lights there are. Photons then must hold first hits. Without `direct` it is always so.
    bool texelsByPhotons = false;
    bool standardErrors = false; ///< keep batches, so that explain() knows the noise of the photons
    std::uint64_t seed = 0;
};

class CachedGather final : public Estimator {
public:
    /// `direct` answers for `receivers`; null: direct light comes from photons, which then hold first hits: as blurred
    /// as the texels around the receiver are large. All
    /// references must outlive it. `texels`: from makeTexels() with the same options; null: it makes its own.
    CachedGather(const scene::Scene& scene, const lights::LightSet& lights, const intersect::Intersector& intersector,
                 const scene::Receivers& receivers, DirectLight* direct, const GatherOptions& options,
                 std::shared_ptr<const SurfaceTexels> texels = nullptr);
    ~CachedGather() override;

    /// They depend on the scene alone, so that they can be made while receivers are still being found.
    [[nodiscard]] static std::shared_ptr<const SurfaceTexels> makeTexels(const scene::Scene& scene,
                                                                         const GatherOptions& options);

    /// Where lights shine: first hits of some photons. From then on a quarter as many rays again are aimed at what is
    /// bright there. Before anything is refined, or not at all.
    void aim(std::span<const photons::Photon> firstHits);
    /// Photons of one more frame, or of so many parts of one (PhotonSums), in the order of their indices.
    void add(std::span<const photons::Photon> photons, unsigned parts = PhotonSums::batches, unsigned firstPart = 0);
    /// Forgets them all.
    void clear();
    /// Light `light` of `lights` gives no direct light any more. `alone` is of this light only.
    void mute(std::uint32_t light, const lights::LightSet& alone);
    /// Takes out photons it sent, in any portions; the parts they were added with stay. Not with standard errors.
    void takeBack(std::span<const photons::Photon> photons);

    /// Lights that may change, apart from those above: their direct light at the receivers, null where photons bring
    /// it, and the watts of all of them (PhotonSums). Clears what photons they had sent. Their photons hold first hits.
    void setChanging(const DirectLight* direct, double power);
    void addChanging(std::span<const photons::Photon> photons, unsigned parts = PhotonSums::batches,
                     unsigned firstPart = 0);
    void removeChanging(std::span<const photons::Photon> photons, unsigned parts = PhotonSums::batches,
                        unsigned firstPart = 0);

    /// Spends about `rays` rays on the receivers of `wanted` that are not finished. Returns the rays spent: 0 when all
    /// are.
    std::uint64_t refine(std::span<const std::uint32_t> wanted, std::uint64_t rays);
    [[nodiscard]] bool finished(std::uint32_t receiver) const;
    /// Rays that its answer rests on so far: 0 while nothing but photons around it is known, 1 with direct light alone.
    [[nodiscard]] unsigned samples(std::uint32_t receiver) const;
    /// Makes what was added visible; refine() does so as well. Costs nothing when there is nothing new.
    void update();

    void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const override;
    void explain(std::span<const std::uint32_t> which, std::span<Estimate> estimates) const override;
    [[nodiscard]] std::string_view name() const override { return "gather"; }

    [[nodiscard]] const SurfaceTexels& texels() const { return texels_; }
    [[nodiscard]] const TexelLight& light() const { return light_; }
    [[nodiscard]] std::uint64_t raysTraced() const { return rays_; } ///< gathering and shadow rays on texels
    [[nodiscard]] std::size_t bytes() const override;

private:
    /// What a receiver has: nothing yet, the light of its own texel, direct light, rows of three sizes.
    enum Stage : std::uint8_t { Unknown, OwnTexel, Direct, Coarse, Medium, Fine };

    using Radiosities = std::vector<TexelLight::Radiosity>;
    static constexpr std::uint32_t enoughFirstHits = 16; ///< where they are all the direct light there is
    /// What the two rays of a stratum met, where they differ.
    struct Pair {
        std::array<std::uint32_t, 2> numbers{};
        std::array<float, 2> weights{};
    };

    [[nodiscard]] unsigned lastStage() const;
    [[nodiscard]] unsigned raysAt(unsigned stage) const;
    [[nodiscard]] unsigned raysOfPoint() const;
    [[nodiscard]] std::uint32_t texelCount() const { return static_cast<std::uint32_t>(texels_.texels().size()); }
    /// Radiosities hold every texel by its photons, then a dark one, then the points that gather themselves, in the
    /// order in which rows first met them.
    [[nodiscard]] std::uint32_t dark() const { return texelCount(); }
    [[nodiscard]] std::uint32_t firstPoint() const { return texelCount() + 1; }
    [[nodiscard]] std::uint32_t texelOfPoint(std::size_t place) const {
        return gatheringPoints_[place] / texels_.pointsPerTexel();
    }
    [[nodiscard]] std::uint32_t nearestPoint(std::uint32_t texel, const Vec3& at) const;
    void survey();
    bool ownTexels(std::span<const std::uint32_t> wanted, const std::function<bool()>& go);
    void makeRows(std::span<const std::uint32_t> which, unsigned n);
    void makePointRows(std::vector<std::uint32_t> points);
    /// Points in a new row are numbered as if all of them gathered; numberPoints() then gives them their places.
    [[nodiscard]] GatherRow makeRow(std::span<const TexelHit> hits, unsigned n, float large) const;
    void numberPoints(GatherRow& row) const;
    [[nodiscard]] Fallen fallen(std::span<const photons::Photon> photons, unsigned parts, unsigned firstPart);
    [[nodiscard]] Hits stillHits() const { return firstHits_ ? Hits::All : Hits::Later; }
    static constexpr std::size_t receiversPerChunk = 512; ///< that one thread estimates at once, here at most
    void putDirect(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const;
    void addChangingDirect(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const;
    /// From radiosities by photons those of everything. `direct`: whether direct light is in them.
    void bothWays(std::span<const TexelLight::Radiosity> byPhotons, bool direct, Radiosities& both) const;
    [[nodiscard]] static GatherOptions checked(GatherOptions options);
    struct Explanation;
    void explainOne(std::uint32_t receiver, const Explanation& with, Estimate& out) const;

    const scene::Receivers& receivers_;
    const scene::Scene& scene_;
    const lights::LightSet& lights_;
    const intersect::Intersector& intersector_;
    DirectLight* direct_;
    const DirectLight* changingDirect_ = nullptr;
    GatherOptions options_;
    std::shared_ptr<const SurfaceTexels> keptTexels_;
    const SurfaceTexels& texels_;
    BrightTexels bright_;
    std::unique_ptr<DirectLight> texelDirect_;
    TexelLight light_;
    std::unique_ptr<PhotonSums> firstHits_; ///< of photons alone, where texels have direct light from those
    TexelRays gatherRays_, texelGatherRays_;
    std::vector<GatherRow> rows_;
    std::vector<std::uint8_t> stage_;
    std::vector<std::uint32_t> own_;             ///< texel a receiver lies on
    std::vector<std::uint32_t> gatheringPoints_; ///< numbers in texels_.points()
    std::vector<std::uint32_t> placeOf_;         ///< by point: in gatheringPoints_; empty: none gathers
    std::vector<GatherRow> pointRows_;           ///< by place, like what follows
    std::vector<Rgb> pointDirect_;
    std::vector<std::vector<Pair>> pointPairs_; ///< for standard errors
    Radiosities radiosity_;                     ///< bothWays
    std::vector<std::uint32_t> found_;          ///< texels of what is being added
    std::uint64_t rays_ = 0;
    bool surveyed_ = false, changed_ = true;
};

} // namespace pie::gather
