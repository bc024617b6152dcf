#include "pie/gather/nearest_photons.h"

#include "pie/core/parallel.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pie::gather {
namespace {

using photons::Photon;
using Side = SurfaceTest::Side;

constexpr float smallestRadiusShare = 1e-3F;
constexpr double smallestAreaShare = 1.0 / 256;
constexpr std::size_t grain = 64; // receivers per task

float radiusWithin(const scene::Scene& scene, float wanted) {
    const float diagonal = glm::length(scene.bounds.size());
    if (!(wanted > 0.0F)) return 0.0F;
    return diagonal > 0.0F ? std::min(wanted, diagonal) : wanted;
}

Rgb finite(const glm::dvec3& value) {
    Rgb result(0.0F);
    for (int i = 0; i < 3; ++i)
        if (value[i] > 0) result[i] = static_cast<float>(std::min(value[i], double{std::numeric_limits<float>::max()}));
    return result;
}

} // namespace

NearestPhotons::NearestPhotons(const scene::Scene& scene, const scene::Receivers& receivers,
                               const maps::RealtimeMap& map, const NearestOptions& options, const Estimator* direct)
    : scene_(scene), receivers_(receivers), map_(map), options_(options), direct_(direct) {
    options_.maxRadius = radiusWithin(scene, options.maxRadius);
    options_.indirectOnly = options.indirectOnly || direct != nullptr;
}

NearestPhotons::NearestPhotons(const scene::Scene& scene, const scene::Receivers& receivers,
                               const maps::RealtimeMap& map, const NearestOptions& options, const TrueArea& area,
                               const AreaTable& table, const Estimator* direct)
    : NearestPhotons(scene, receivers, map, options, direct) {
    table_ = &table;
    options_.slice = area.slice();
    options_.kernel = area.kernel();
    options_.maxRadius = area.maxRadius();
}

float NearestPhotons::searchRadius() const {
    const auto count = static_cast<float>(map_.photons().size());
    if (!options_.radiusHeuristic || count == 0.0F || !(options_.heuristicAlpha > 0.0F)) return options_.maxRadius;
    const float enclosing = 0.5F * glm::length(map_.bounds().size());
    // eq 3.7
    const float radius =
        enclosing * std::sqrt(static_cast<float>(options_.maxCount) / (options_.heuristicAlpha * count));
    return radius > 0.0F ? std::min(options_.maxRadius, radius) : options_.maxRadius;
}

template <class Map>
Rgb NearestPhotons::one(const Map& map, std::uint32_t receiver, float maxRadius, maps::NearestQueue& queue) const {
    const scene::Receiver& at = receivers_.points[receiver];
    const SurfaceTest test{scene_, at.position, at.normal, options_.slice, at.twoSided};
    const bool trueArea = table_ != nullptr;
    const auto accept = [&](const Photon& photon) {
        if (options_.indirectOnly && photon.bounce == 0) return false;
        if (trueArea) return test(photon) != Side::None;
        if (options_.sphereSlice) {
            const float height = glm::dot(photon.position - at.position, at.normal); // eq 3.12
            if (!(std::abs(height) <= options_.slice.halfThickness)) return false;
        }
        return !options_.incomingDirection || at.twoSided || glm::dot(photon.direction, at.normal) < 0.0F;
    };
    if (trueArea || options_.sphereSlice)
        map.nearest(at.position, options_.maxCount, maxRadius, {at.normal, options_.slice.halfThickness}, accept,
                    queue);
    else
        map.nearest(at.position, options_.maxCount, maxRadius, accept, queue);
    if (queue.found().empty()) return Rgb(0.0F);

    const float reached = queue.full() ? std::sqrt(queue.farthest().distanceSquared) : maxRadius;
    const double radius = static_cast<double>(std::max(reached, smallestRadiusShare * options_.maxRadius));
    const std::uint32_t dropped = options_.dropFarthest && queue.full() && queue.found().size() > 1
                                      ? queue.farthest().photon
                                      : std::numeric_limits<std::uint32_t>::max();
    std::array<glm::dvec3, 2> flux{glm::dvec3(0), glm::dvec3(0)};
    for (const maps::Neighbour& neighbour : queue.found()) {
        if (neighbour.photon == dropped) continue;
        const Photon& photon = map.photons()[neighbour.photon];
        const double t = std::min(1.0, static_cast<double>(neighbour.distanceSquared) / (radius * radius));
        const bool back = trueArea && at.twoSided && test(photon) == Side::Back;
        flux[back ? 1 : 0] += value(options_.kernel, t) * glm::dvec3(photon.flux);
    }
    const double disc = discIntegral(options_.kernel) * radius * radius / static_cast<double>(map_.fluxScale());
    if (!trueArea) return finite(flux[0] / disc);
    glm::dvec3 irradiance(0);
    for (const bool back : {false, true}) {
        if (back && !at.twoSided) continue;
        const auto share = static_cast<double>(table_->share(receiver, back, static_cast<float>(radius)));
        irradiance += flux[back ? 1 : 0] / (disc * std::max(share, smallestAreaShare));
    }
    return finite(irradiance);
}

void NearestPhotons::estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const {
    if (direct_ != nullptr)
        direct_->estimate(which, irradiance);
    else
        std::fill(irradiance.begin(), irradiance.end(), Rgb(0.0F));
    const float radius = searchRadius();
    if (options_.maxCount == 0 || !(radius > 0.0F) || map_.photons().empty()) return;
    map_.visit([&](const auto& map) {
        parallelChunks(which.size(), grain, [&](std::size_t begin, std::size_t end) {
            maps::NearestQueue queue;
            for (std::size_t i = begin; i < end; ++i)
                irradiance[i] = finite(glm::dvec3(irradiance[i]) + glm::dvec3(one(map, which[i], radius, queue)));
        });
    });
}

} // namespace pie::gather
