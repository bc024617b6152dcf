#include "pie/gather/nearest_photons.h"

#include "pie/core/parallel.h"
#include "pie/gather/area_shape.h"
#include "pie/gather/numbers.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>

namespace pie::gather {
namespace {

using glm::dvec3;
using photons::Photon;
using Side = SurfaceTest::Side;

constexpr float smallestRadiusShare = 1e-3F;
constexpr double smallestAreaShare = 1.0 / 256;
constexpr std::size_t taskSize = 64;     // receivers
constexpr std::size_t fewestBatches = 4; // with fewer, their spread says too little

float radiusWithin(const scene::Scene& scene, float wanted) {
    const float diagonal = glm::length(scene.bounds.size());
    if (!(wanted > 0.0F)) return 0.0F;
    return diagonal > 0.0F ? std::min(wanted, diagonal) : wanted;
}

} // namespace

/// One receiver's search: irradiance is Σ weights[i] · flux of found[i].
struct NearestPhotons::Search {
    const scene::Receiver* at = nullptr;
    std::uint32_t receiver = scene::noReceiver; ///< its number, if it has one
    VolumeAt volume{};
    float maxRadius = 0;
    std::size_t count = 0;
    bool directOnly = false;
    maps::Partition::Seen seen; ///< where maps are split
    maps::NearestQueue queue;
    std::vector<maps::Neighbour> found;
    std::span<const Photon> photons; ///< of the map
    double radius = 0;
    bool bordered = false; ///< the farthest photon made the radius
    std::vector<double> weights;
    std::vector<Vec3> offsets;
    std::vector<std::uint32_t> inside;
    PhotonShape shape;
    std::vector<double> batches, innerBatches;

    [[nodiscard]] const Photon& photon(std::size_t i) const { return photons[found[i].photon]; }
    [[nodiscard]] double kernelArgument(std::size_t i) const {
        return volume.t(photon(i).position, found[i].distanceSquared, radius);
    }
    [[nodiscard]] dvec3 sum() const {
        dvec3 total(0);
        for (std::size_t i = 0; i < found.size(); ++i) total += weights[i] * dvec3(photon(i).flux);
        return total;
    }
    /// Adds the sum times a factor, channel mean, split by the frames the photons came in.
    void split(std::span<const std::uint32_t> ends, const dvec3& factor, std::vector<double>& parts) const {
        for (std::size_t i = 0; i < found.size(); ++i) {
            const auto frame = std::upper_bound(ends.begin(), ends.end(), found[i].photon) - ends.begin();
            parts[static_cast<std::size_t>(frame)] += weights[i] * meanChannel(factor * dvec3(photon(i).flux));
        }
    }
    /// Variance of the sum when photons are independent.
    [[nodiscard]] double poissonVariance() const {
        double sum = 0;
        for (std::size_t i = 0; i < found.size(); ++i)
            sum += std::pow(weights[i] * meanChannel(dvec3(photon(i).flux)), 2);
        return sum;
    }
};

NearestPhotons::NearestPhotons(const scene::Scene& scene, const scene::Receivers& receivers,
                               const maps::RealtimeMap& map, const NearestOptions& options, const Estimator* direct)
    : scene_(scene), receivers_(receivers), map_(map), options_(options), direct_(direct) {
    options_.maxRadius = radiusWithin(scene, options.maxRadius);
    options_.indirectOnly = options.indirectOnly || direct != nullptr;
    options_.progressiveAlpha = std::clamp(options.progressiveAlpha, 0.0F, 1.0F);
    if (options.area != AreaEstimate::True) return;
    ownArea_ = std::make_unique<TrueArea>(scene, options.kernel, options.slice, options.maxRadius, options.volume,
                                          map.partition());
    ownTable_ = std::make_unique<AreaTable>(*ownArea_, receivers);
    table_ = ownTable_.get();
    readArea(*ownArea_);
}

NearestPhotons::NearestPhotons(const scene::Scene& scene, const scene::Receivers& receivers,
                               const maps::RealtimeMap& map, const NearestOptions& options, const TrueArea& area,
                               const AreaTable& table, const Estimator* direct)
    : scene_(scene), receivers_(receivers), map_(map), options_(options), table_(&table), direct_(direct) {
    options_.indirectOnly = options.indirectOnly || direct != nullptr;
    options_.progressiveAlpha = std::clamp(options.progressiveAlpha, 0.0F, 1.0F);
    readArea(area);
}

/// Flux and area must speak of the same surface.
void NearestPhotons::readArea(const TrueArea& area) {
    area_ = &area;
    options_.area = AreaEstimate::True;
    options_.volume = area.volume();
    options_.slice = area.slice();
    options_.kernel = area.kernel();
    options_.maxRadius = area.maxRadius();
}

std::size_t NearestPhotons::bytes() const { return ownTable_ != nullptr ? ownArea_->bytes() + ownTable_->bytes() : 0; }

std::size_t NearestPhotons::searchCount() const {
    if (options_.radius == RadiusRule::Fixed) return std::numeric_limits<std::size_t>::max();
    if (options_.radius == RadiusRule::Nearest) return options_.maxCount;
    const double grown = static_cast<double>(options_.maxCount) *
                         std::pow(static_cast<double>(std::max<std::size_t>(1, map_.framesPresent())),
                                  static_cast<double>(options_.progressiveAlpha));
    return static_cast<std::size_t>(std::lround(std::min(grown, 4e9)));
}

float NearestPhotons::searchRadius() const {
    float radius = options_.maxRadius;
    const auto count = static_cast<float>(map_.photons().size());
    if (options_.radiusHeuristic && count > 0.0F && options_.heuristicAlpha > 0.0F) {
        const float enclosing = 0.5F * glm::length(map_.bounds().size());
        const std::size_t wanted = options_.radius == RadiusRule::Fixed ? options_.maxCount : searchCount();
        const float heuristic =
            enclosing * std::sqrt(static_cast<float>(wanted) / (options_.heuristicAlpha * count)); // eq 3.7
        if (heuristic > 0.0F) radius = std::min(radius, heuristic);
    }
    if (options_.radius == RadiusRule::Progressive)
        radius *= std::pow(static_cast<float>(std::max<std::size_t>(1, map_.framesPresent())),
                           0.5F * (options_.progressiveAlpha - 1.0F));
    return radius;
}

/// Fills the queue from a map, all of whose photons count for the receiver as far as the division of photons into maps
/// decides it; the exact map has no division and asks each photon.
template <class Map> void NearestPhotons::ask(const Map& map, Search& search) const {
    const scene::Receiver& at = *search.at;
    const float thickness = search.volume.halfThickness;
    const VolumeAt volume = search.volume;
    const bool directOnly = search.directOnly;
    const bool indirectOnly = options_.indirectOnly && !directOnly;
    const maps::Partition* const partition = map_.partition().get();
    const maps::Slab slab{at.normal, thickness};
    // Where the radius that a photon needs is its distance, the plain search is a tenth faster.
    const bool plain = options_.volume == SearchVolume::Slice && thickness < std::numeric_limits<float>::infinity();
    const auto look = [&](const auto& accept) {
        const auto counts = [&](const Photon& photon) {
            if constexpr (std::is_same_v<Map, maps::ExactMap>)
                if (partition != nullptr && !search.seen.holds(partition->placeOf(photon))) return false;
            return !(photon.bounce == 0 ? indirectOnly : directOnly) && accept(photon);
        };
        if (plain)
            map.nearest(
                at.position, search.count, search.maxRadius, slab,
                [&](const Photon& photon) {
                    const float height = glm::dot(photon.position - at.position, at.normal); // eq 3.12
                    return height <= thickness && height >= -thickness && counts(photon);
                },
                search.queue);
        else
            map.nearestBy(
                at.position, search.count, search.maxRadius, slab, volume.surplus(),
                [&](const Photon& photon, float distanceSquared) {
                    return counts(photon) ? volume.needed(photon.position, distanceSquared) : -1.0F;
                },
                search.queue);
    };
    const SurfaceTest test{scene_, at.position, at.normal, options_.slice, at.twoSided};
    const auto arrives = [&](const Photon& photon) {
        return !options_.incomingDirection || at.twoSided || glm::dot(photon.direction, at.normal) < 0.0F;
    };
    if (search.seen.allFace) {
        // "Spares the sphere slice calculation" (pi-engine 5.3.4), or at least a look at every photon's triangle.
        if (table_ != nullptr)
            look([](const Photon&) { return true; });
        else
            look(arrives);
    } else if (table_ != nullptr) {
        look([&](const Photon& photon) { return test(photon) != Side::None; });
    } else if (partition != nullptr && partition->byNormal()) {
        look([&](const Photon& photon) { return arrives(photon) && test.facing(photon) != Side::None; });
    } else {
        look(arrives);
    }
}

template <class Map> void NearestPhotons::find(const Map& map, Search& search) const {
    const scene::Receiver& at = *search.at;
    search.volume = {options_.volume, options_.slice.halfThickness, at.position, at.normal};
    if (options_.volume == SearchVolume::Sphere) search.volume.halfThickness = std::numeric_limits<float>::infinity();
    if (map_.partition() != nullptr) search.seen = map_.partition()->seenFrom(at, options_.slice.minCosine);
    if constexpr (std::is_same_v<Map, maps::SplitTree>)
        ask(map.seen(search.seen), search);
    else
        ask(map, search);

    search.photons = map.photons();
    search.found.clear(); // the farthest first, when the queue is full
    for (const maps::Neighbour& neighbour : search.queue.found()) {
        const Photon& photon = search.photons[neighbour.photon];
        search.found.push_back({maps::distanceSquared(photon.position, at.position), neighbour.photon});
    }
    search.bordered = search.queue.full();
    const float reached = search.bordered ? std::sqrt(search.queue.farthest().distanceSquared) : search.maxRadius;
    search.radius = static_cast<double>(std::max(reached, smallestRadiusShare * options_.maxRadius));
}

/// Weights for what was found, with the radius of the search.
void NearestPhotons::weigh(Search& search) const {
    const std::size_t count = search.found.size();
    const double radius = search.radius;
    const auto scale = static_cast<double>(map_.fluxScale());
    search.weights.assign(count, 0.0);
    const std::size_t first = options_.dropBorder && search.bordered && count > 1 ? 1 : 0;
    const double disc = discIntegral(options_.kernel) * radius * radius;
    if (table_ == nullptr && options_.area != AreaEstimate::Disc) {
        search.inside.clear();
        for (std::size_t i = first; i < count; ++i) search.inside.push_back(static_cast<std::uint32_t>(i));
        weighByShape(search, disc);
        return;
    }
    const scene::Receiver& at = *search.at;
    double perSide[2] = {scale / disc, 0};
    if (table_ != nullptr)
        for (const bool back : {false, true}) {
            if (back && !at.twoSided) continue;
            perSide[back ? 1 : 0] = scale / (disc * std::max(areaShare(search, back), smallestAreaShare));
        }
    const SurfaceTest test{scene_, at.position, at.normal, options_.slice, at.twoSided};
    for (std::size_t i = first; i < count; ++i) {
        const bool back = table_ != nullptr && at.twoSided && test(search.photon(i)) == Side::Back;
        search.weights[i] = perSide[back ? 1 : 0] * value(options_.kernel, search.kernelArgument(i));
    }
}

/// Weights of search.inside. `disc`: the integral of the kernel over the whole disc.
void NearestPhotons::weighByShape(Search& search, double disc) const {
    search.offsets.clear();
    for (const std::uint32_t i : search.inside)
        search.offsets.push_back(search.photon(i).position - search.volume.point);
    double integral = disc;
    const bool fits = search.shape.fit(options_.area, search.offsets, Frame(search.volume.normal));
    if (fits && options_.area == AreaEstimate::Ellipse) {
        // Its outline is a guess that errs to both sides; what the disc cut off of it would err to one.
        integral *= std::clamp(search.shape.area() / (std::numbers::pi * search.radius * search.radius),
                               smallestAreaShare, 1 / smallestAreaShare);
    } else if (fits) {
        const PlaneKernel kernel{options_.kernel, 0, search.radius};
        integral = std::clamp(integrate(kernel, search.shape.corners()), smallestAreaShare * disc, disc);
    }
    const double scale = static_cast<double>(map_.fluxScale()) / integral;
    for (std::size_t j = 0; j < search.inside.size(); ++j) {
        if (fits && options_.dropBorder && search.shape.onBorder(j)) continue;
        const std::size_t i = search.inside[j];
        search.weights[i] = scale * value(options_.kernel, search.kernelArgument(i));
    }
}

/// Share of the disc that exists, on one side.
double NearestPhotons::areaShare(const Search& search, bool back) const {
    const auto radius = static_cast<float>(search.radius);
    if (search.receiver != scene::noReceiver) return static_cast<double>(table_->share(search.receiver, back, radius));
    const Vec3 normal = back ? -search.at->normal : search.at->normal;
    const double disc = discIntegral(options_.kernel) * search.radius * search.radius;
    return std::min(area_->integral(search.at->position, normal, radius, search.seen.cells) / disc,
                    static_cast<double>(AreaTable::largestShare));
}

bool NearestPhotons::finds() const { return searchCount() > 0 && searchRadius() > 0.0F && !map_.photons().empty(); }

/// Calls use(search, i) for i in [begin, end) where photons were found; at(i, search) names the receiver.
template <class At, class Use>
void NearestPhotons::forEachIn(std::size_t begin, std::size_t end, const At& at, const Use& use) const {
    Search search;
    search.maxRadius = searchRadius();
    search.count = searchCount();
    map_.visit([&](const auto& map) {
        for (std::size_t i = begin; i < end; ++i) {
            at(i, search);
            find(map, search);
            if (!search.found.empty()) use(search, i);
        }
    });
    const maps::Visits& visits = search.queue.visits();
    counters_.nodes.fetch_add(visits.nodes, std::memory_order_relaxed);
    counters_.leaves.fetch_add(visits.leaves, std::memory_order_relaxed);
    counters_.photons.fetch_add(visits.photons, std::memory_order_relaxed);
}

maps::Visits NearestPhotons::visits() const { return {counters_.nodes, counters_.leaves, counters_.photons}; }

/// The same for receivers by number, in parallel.
template <class Use> void NearestPhotons::forEach(std::span<const std::uint32_t> which, const Use& use) const {
    if (!finds()) return;
    const auto at = [&](std::size_t i, Search& search) {
        search.receiver = which[i];
        search.at = &receivers_.points[which[i]];
    };
    parallelChunks(which.size(), taskSize, [&](std::size_t begin, std::size_t end) { forEachIn(begin, end, at, use); });
}

void NearestPhotons::estimateAt(std::span<const scene::Receiver> points, std::span<Rgb> irradiance,
                                Bounces bounces) const {
    std::fill(irradiance.begin(), irradiance.end(), Rgb(0.0F));
    if (!finds()) return;
    parallelChunks(points.size(), taskSize, [&](std::size_t begin, std::size_t end) {
        forEachIn(
            begin, end,
            [&](std::size_t i, Search& search) {
                search.at = &points[i];
                search.directOnly = bounces == Bounces::Direct;
            },
            [&](Search& search, std::size_t i) {
                weigh(search);
                irradiance[i] = finite(search.sum());
            });
    });
}

double NearestPhotons::splitAt(std::span<const scene::Receiver> points, std::span<const Rgb> factors,
                               std::vector<double>& batches) const {
    const std::span<const std::uint32_t> ends = map_.frameEnds();
    batches.resize(ends.size(), 0.0);
    if (!finds()) return 0;
    double radii = 0;
    forEachIn(
        0, points.size(), [&](std::size_t i, Search& search) { search.at = &points[i]; },
        [&](Search& search, std::size_t i) {
            weigh(search);
            search.split(ends, dvec3(factors[i]), batches);
            radii += search.radius;
        });
    return radii;
}

void NearestPhotons::estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const {
    if (direct_ != nullptr)
        direct_->estimate(which, irradiance);
    else
        std::fill(irradiance.begin(), irradiance.end(), Rgb(0.0F));
    forEach(which, [&](Search& search, std::size_t i) {
        weigh(search);
        irradiance[i] = finite(dvec3(irradiance[i]) + dvec3(finite(search.sum())));
    });
}

void NearestPhotons::explain(std::span<const std::uint32_t> which, std::span<Estimate> estimates) const {
    std::vector<Rgb> direct(which.size(), Rgb(0.0F));
    if (direct_ != nullptr) direct_->estimate(which, direct);
    for (std::size_t i = 0; i < which.size(); ++i) {
        estimates[i] = {};
        estimates[i].irradiance = direct[i];
        estimates[i].radius = searchRadius();
    }
    const std::span<const std::uint32_t> ends = map_.frameEnds();
    const bool batched = ends.size() >= fewestBatches;
    forEach(which, [&](Search& search, std::size_t i) {
        weigh(search);
        const dvec3 whole = search.sum();
        Estimate& estimate = estimates[i];
        estimate.irradiance = finite(dvec3(direct[i]) + dvec3(finite(whole)));
        estimate.radius = static_cast<float>(search.radius);
        estimate.photons = static_cast<std::uint32_t>(
            std::min<std::size_t>(search.found.size(), std::numeric_limits<std::uint32_t>::max()));
        search.batches.assign(ends.size(), 0.0);
        search.split(ends, dvec3(1), search.batches);
        const double noise = batched ? variance(search.batches) : search.poissonVariance();
        estimate.standardError = finite(std::sqrt(noise));

        const double outer = search.radius;
        search.radius *= std::sqrt(0.5);
        search.bordered = false;
        const Search& s = search;
        std::erase_if(search.found, [&](const maps::Neighbour& n) {
            const Vec3& position = s.photons[n.photon].position;
            const float needed = s.volume.needed(position, n.distanceSquared);
            return !(needed >= 0.0F && static_cast<double>(needed) <= 0.5 * outer * outer);
        });
        weigh(search);
        const double difference = meanChannel(whole - search.sum());
        search.innerBatches.assign(ends.size(), 0.0);
        search.split(ends, dvec3(1), search.innerBatches);
        for (std::size_t b = 0; b < ends.size(); ++b) search.batches[b] -= search.innerBatches[b];
        // Photons of the inner circle count in both; where they are taken for independent, half of them are in both.
        const double chance = batched ? variance(search.batches) : std::max(0.0, search.poissonVariance() - noise);
        estimate.bias = finite(2 * std::sqrt(std::max(0.0, difference * difference - chance)));
    });
}

} // namespace pie::gather
