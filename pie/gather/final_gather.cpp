#include "pie/gather/final_gather.h"

#include "pie/core/parallel.h"
#include "pie/gather/direct.h"
#include "pie/gather/gather_rays.h"
#include "pie/gather/irradiance_cache.h"
#include "pie/gather/numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numeric>

namespace pie::gather {
namespace {

using glm::dvec3;
using photons::Photon;

constexpr std::size_t together = 16;     // receivers whose rays are traced
constexpr std::size_t recordRound = 128; // receivers that may become records together

/// About the golden section of the count, and without a common factor: multiples of it visit every number once.
std::size_t strideThrough(std::size_t count) {
    auto stride = std::max<std::size_t>(1, static_cast<std::size_t>(0.6180339887498949 * static_cast<double>(count)));
    while (std::gcd(stride, count) != 1) ++stride;
    return stride;
}

} // namespace

struct FinalGather::State {
    const scene::Scene& scene;
    const scene::Receivers& receivers;
    const maps::RealtimeMap& map;
    const scene::Receivers none; ///< rays end anywhere
    NearestPhotons atHits;
    FinalGatherOptions options;
    GatherRays rays;

    std::mutex mutex; ///< of all that follows; what is read outside does not change until the map is rebuilt
    // The cache: decided once.
    bool placed = false;
    std::vector<std::uint32_t> recordOf; ///< receivers that are records
    std::vector<Bundle> bundles;         ///< of the records
    std::vector<std::size_t> rowEnds;    ///< of each receiver in `weights`
    std::vector<IrradianceCache::Weight> weights;
    std::size_t cacheBytes = 0;
    // Of one revision of the map.
    std::uint64_t revision = 0;
    maps::KdTree precomputed;                  ///< photons that carry irradiance in place of flux
    std::vector<Rgb> values;                   ///< of the records
    std::vector<std::array<Rgb, 3>> gradients; ///< of these, per unit along x, y and z

    State(const scene::Scene& theScene, const intersect::Intersector& intersector, const scene::Receivers& theReceivers,
          const maps::RealtimeMap& theMap, const NearestOptions& hits, const FinalGatherOptions& theOptions,
          GatherRays::Direct direct)
        : scene(theScene), receivers(theReceivers), map(theMap), atHits(theScene, none, theMap, hits),
          options(theOptions), rays(theScene, intersector, theOptions, std::move(direct)) {}

    void place();
    void refresh();
    void precompute();
    [[nodiscard]] Rgb lookUp(const scene::Receiver& point, maps::NearestQueue& queue) const;
    void light(std::span<const Bundle> some, std::span<Rgb> irradiance,
               std::span<std::array<Rgb, 3>> gradient = {}) const;
    [[nodiscard]] Rgb interpolate(std::uint32_t receiver) const;
    [[nodiscard]] Estimate explain(const Bundle& bundle) const;
};

FinalGather::FinalGather(const scene::Scene& scene, const intersect::Intersector& intersector,
                         const scene::Receivers& receivers, const maps::RealtimeMap& map, const NearestOptions& atHits,
                         const FinalGatherOptions& options, const lights::LightSet* lights) {
    GatherRays::Direct direct;
    if (lights != nullptr)
        direct = [&scene, &intersector, lights, seed = options.seed](const scene::Receivers& points,
                                                                     std::span<Rgb> irradiance) {
            DirectOptions directOptions;
            directOptions.seed = seed;
            std::vector<std::uint32_t> which(points.points.size());
            std::iota(which.begin(), which.end(), 0U);
            DirectLight(scene, *lights, intersector, points, directOptions).estimate(which, irradiance);
        };
    else
        direct = [this](const scene::Receivers& points, std::span<Rgb> irradiance) {
            state_->atHits.estimateAt(points.points, irradiance, NearestPhotons::Bounces::Direct);
        };
    state_ = std::make_unique<State>(scene, intersector, receivers, map, atHits, options, std::move(direct));
}

FinalGather::~FinalGather() = default;

/// Which receivers are records, and from which each receiver interpolates. In rounds: those of a round that no record
/// covers are gathered in parallel; then, in order, each becomes a record unless one of the same round covers it.
void FinalGather::State::place() {
    if (placed) return;
    placed = true;
    IrradianceCache cache(options.cacheAccuracy);
    const auto& points = receivers.points;
    std::vector<IrradianceCache::Weight> found;
    const auto covered = [&](const scene::Receiver& at) {
        cache.interpolate(at.position, at.normal, at.twoSided, found);
        return !found.empty();
    };
    std::vector<scene::Receiver> candidates;
    std::vector<std::uint32_t> numbers;
    std::vector<Bundle> some;
    // Numbers side by side lie side by side. A stride spreads the first records over the level, so that most receivers
    // lie between records rather than behind the last.
    const std::size_t stride = strideThrough(points.size());
    for (std::size_t begin = 0; begin < points.size(); begin += recordRound) {
        candidates.clear();
        numbers.clear();
        for (std::size_t i = begin; i < std::min(points.size(), begin + recordRound); ++i) {
            const std::size_t number = i * stride % points.size();
            if (!maps::isFinite(points[number].position) || covered(points[number])) continue;
            candidates.push_back(points[number]);
            numbers.push_back(static_cast<std::uint32_t>(number));
        }
        some.assign(candidates.size(), {});
        parallelChunks(candidates.size(), together, [&](std::size_t from, std::size_t to) {
            rays.shoot(std::span(candidates).subspan(from, to - from), std::span(some).subspan(from, to - from));
        });
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            if (covered(candidates[i])) continue;
            const float radius = std::clamp(some[i].meanDistance(), std::max(options.cacheSpacing, 1e-3F),
                                            std::max(16 * options.cacheSpacing, 1e-3F));
            cache.add(candidates[i].position, candidates[i].normal, radius, candidates[i].twoSided);
            recordOf.push_back(numbers[i]);
            bundles.push_back(std::move(some[i]));
        }
    }
    for (const scene::Receiver& at : points) {
        found.clear();
        if (maps::isFinite(at.position)) cache.interpolate(at.position, at.normal, at.twoSided, found);
        weights.insert(weights.end(), found.begin(), found.end());
        rowEnds.push_back(weights.size());
    }
    cacheBytes = rowEnds.capacity() * sizeof(std::size_t) + weights.capacity() * sizeof(IrradianceCache::Weight);
    for (const Bundle& bundle : bundles) cacheBytes += sizeof(bundle) + bundle.terms.capacity() * sizeof(Bundle::Term);
}

/// What depends on the photons, once a revision.
void FinalGather::State::refresh() {
    const std::lock_guard lock(mutex);
    if (options.cacheAccuracy > 0.0F) place();
    if (revision == map.revision()) return;
    revision = map.revision();
    if (options.precompute > 0) precompute();
    if (!placed) return;
    values.assign(bundles.size(), Rgb(0.0F));
    gradients.assign(bundles.size(), {});
    light(bundles, values, gradients);
}

void FinalGather::State::precompute() {
    std::vector<Photon> some;
    std::vector<scene::Receiver> points;
    const auto photons = map.photons();
    for (std::size_t i = 0; i < photons.size(); i += options.precompute) {
        some.push_back(photons[i]);
        const Vec3 normal = litNormal(scene, photons[i]);
        points.push_back({photons[i].position, normal, photons[i].position, false});
    }
    std::vector<Rgb> irradiance(points.size());
    atHits.estimateAt(points, irradiance);
    for (std::size_t i = 0; i < some.size(); ++i) some[i].flux = irradiance[i];
    precomputed.build(std::move(some));
}

/// Irradiance of the nearest photon on the surface of the point.
Rgb FinalGather::State::lookUp(const scene::Receiver& point, maps::NearestQueue& queue) const {
    const SliceOptions& slice = atHits.slice();
    const SurfaceTest test{scene, point.position, point.normal, slice, false};
    precomputed.nearest(
        point.position, 1, atHits.searchRadius(), {point.normal, slice.halfThickness},
        [&](const Photon& photon) { return test(photon) == SurfaceTest::Side::Front; }, queue);
    return queue.found().empty() ? Rgb(0.0F) : precomputed.photons()[queue.found().front().photon].flux;
}

/// Light of bundles, in parallel.
void FinalGather::State::light(std::span<const Bundle> some, std::span<Rgb> irradiance,
                               std::span<std::array<Rgb, 3>> gradient) const {
    parallelChunks(some.size(), together, [&](std::size_t begin, std::size_t end) {
        maps::NearestQueue queue;
        std::vector<scene::Receiver> points;
        std::vector<Rgb> found;
        for (std::size_t i = begin; i < end; ++i) {
            const Bundle& bundle = some[i];
            dvec3 sum(0);
            for (const Rgb& base : bundle.base) sum += dvec3(base);
            points.clear();
            for (const Bundle::Term& term : bundle.terms) points.push_back(rays.pointOf(term));
            found.assign(points.size(), Rgb(0.0F));
            if (options.precompute > 0)
                for (std::size_t j = 0; j < points.size(); ++j) found[j] = lookUp(points[j], queue);
            else
                atHits.estimateAt(points, found);
            for (std::size_t j = 0; j < points.size(); ++j) sum += dvec3(bundle.terms[j].factor) * dvec3(found[j]);
            irradiance[i] = finite(sum);
            if (gradient.empty()) continue;
            gradient[i] = bundle.baseGradient;
            for (std::size_t j = 0; j < points.size(); ++j)
                for (int axis = 0; axis < 3; ++axis)
                    gradient[i][static_cast<std::size_t>(axis)] +=
                        bundle.terms[j].factor * found[j] * bundle.terms[j].growth[axis];
        }
    });
}

/// Σ weight · (value + gradient · way from the record), each at most twice the value and not below 0.
Rgb FinalGather::State::interpolate(std::uint32_t receiver) const {
    dvec3 sum(0);
    for (std::size_t j = receiver == 0 ? 0 : rowEnds[receiver - 1]; j < rowEnds[receiver]; ++j) {
        const std::uint32_t record = weights[j].record;
        const Vec3 way = receivers.points[receiver].position - receivers.points[recordOf[record]].position;
        const dvec3 value(values[record]);
        dvec3 moved = value;
        for (int axis = 0; axis < 3; ++axis)
            moved += static_cast<double>(way[axis]) * dvec3(gradients[record][static_cast<std::size_t>(axis)]);
        sum += static_cast<double>(weights[j].weight) * glm::clamp(moved, dvec3(0), 2.0 * value);
    }
    return finite(sum);
}

void FinalGather::estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const {
    reflected(which, irradiance);
    if (!state_->options.addDirect) return;
    std::vector<scene::Receiver> points;
    for (const std::uint32_t i : which) points.push_back(state_->receivers.points[i]);
    std::vector<Rgb> direct(points.size());
    state_->atHits.estimateAt(points, direct, NearestPhotons::Bounces::Direct);
    for (std::size_t i = 0; i < which.size(); ++i) irradiance[i] = finite(dvec3(irradiance[i]) + dvec3(direct[i]));
}

void FinalGather::reflected(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const {
    State& s = *state_;
    if (s.options.samples == 0) {
        std::fill(irradiance.begin(), irradiance.end(), Rgb(0.0F));
        return;
    }
    s.refresh();
    if (s.placed) {
        for (std::size_t i = 0; i < which.size(); ++i) irradiance[i] = s.interpolate(which[i]);
        return;
    }
    parallelChunks(which.size(), together, [&](std::size_t begin, std::size_t end) {
        std::vector<scene::Receiver> points;
        for (std::size_t i = begin; i < end; ++i) points.push_back(s.receivers.points[which[i]]);
        std::vector<Bundle> bundles(points.size());
        s.rays.shoot(points, bundles);
        s.light(bundles, irradiance.subspan(begin, end - begin));
    });
}

Estimate FinalGather::State::explain(const Bundle& bundle) const {
    std::vector<scene::Receiver> points;
    std::vector<Rgb> factors;
    for (const Bundle::Term& term : bundle.terms) {
        points.push_back(rays.pointOf(term));
        factors.push_back(term.factor);
    }
    std::vector<double> batches;
    Estimate estimate;
    const double radii = atHits.splitAt(points, factors, batches);
    estimate.photons = bundle.rays;
    estimate.radius = points.empty() ? 0.0F : static_cast<float>(radii / static_cast<double>(points.size()));

    std::vector<Rgb> found(points.size());
    atHits.estimateAt(points, found);
    std::array<double, Bundle::groups> groups{};
    for (std::size_t g = 0; g < groups.size(); ++g) groups[g] = meanChannel(dvec3(bundle.base[g]));
    for (std::size_t j = 0; j < points.size(); ++j)
        groups[bundle.terms[j].group] += meanChannel(dvec3(factors[j]) * dvec3(found[j]));
    const std::size_t used = std::min<std::size_t>(Bundle::groups, options.samples);
    const double noise = variance(batches) + variance(std::span(groups).first(used));
    estimate.standardError = static_cast<float>(std::min(std::sqrt(noise), double{std::numeric_limits<float>::max()}));
    return estimate;
}

void FinalGather::explain(std::span<const std::uint32_t> which, std::span<Estimate> estimates) const {
    State& s = *state_;
    std::vector<Rgb> irradiance(which.size());
    estimate(which, irradiance);
    parallelChunks(which.size(), together, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            estimates[i] = {};
            if (s.options.samples > 0) {
                Bundle bundle;
                s.rays.shoot({&s.receivers.points[which[i]], 1}, {&bundle, 1});
                estimates[i] = s.explain(bundle);
            }
            estimates[i].irradiance = irradiance[i];
        }
    });
}

maps::Visits FinalGather::visits() const { return state_->atHits.visits(); }
std::uint64_t FinalGather::raysTraced() const { return state_->rays.raysTraced(); }
std::size_t FinalGather::records() const { return state_->recordOf.size(); }
std::size_t FinalGather::bytes() const {
    return state_->cacheBytes + state_->precomputed.bytes() + state_->values.capacity() * 4 * sizeof(Rgb);
}

} // namespace pie::gather
