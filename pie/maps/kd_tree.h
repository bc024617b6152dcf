#pragma once
// The kd-tree over all photons (pi-engine 5.3.2, 5.3.3); how it is built and searched is KdIndex's.
//
// `build`, then ask from as many threads as you like. Answers are those of ExactMap, bit for bit. Photons with a
// position that is not finite are kept but never found.

#include "pie/maps/kd_index.h"

#include <cstddef>

namespace pie::maps {

class KdTree {
public:
    static constexpr std::size_t stopRecursionSize = KdIndex::stopRecursionSize; ///< photons in a leaf at most

    /// At most 2^32 - 1 photons. The tree depends on the photons only, not on the number of threads.
    void build(std::vector<photons::Photon> photons);
    /// Hands the photons back and leaves the map empty, so that their memory can be filled again.
    [[nodiscard]] std::vector<photons::Photon> release();
    [[nodiscard]] std::span<const photons::Photon> photons() const { return photons_; }
    [[nodiscard]] const Box& bounds() const { return index_.bounds(); } ///< of the photons with finite positions
    [[nodiscard]] std::size_t bytes() const;

    /// The k nearest photons within maxRadius (its surface included) for which accept(photon) is true. It is asked
    /// while searching, not afterwards: else k photons of a neighbouring surface would crowd out the right ones
    /// (pi-engine 3.5.1).
    template <class Accept>
    void nearest(const Vec3& point, std::size_t k, float maxRadius, Accept&& accept, NearestQueue& queue) const;

    /// The same, skipping whatever lies outside the slab without asking `accept`, which must refuse it.
    template <class Accept>
    void nearest(const Vec3& point, std::size_t k, float maxRadius, const Slab& slab, Accept&& accept,
                 NearestQueue& queue) const;

    /// The k nearest in a measure of your own: measure(photon, distanceSquared) is a squared radius, negative to
    /// refuse, and never less than distanceSquared − surplus. Distances of the neighbours found are measures.
    template <class Measure>
    void nearestBy(const Vec3& point, std::size_t k, float maxRadius, const Slab& slab, float surplus,
                   Measure&& measure, NearestQueue& queue) const;

    /// visitor(photon, distanceSquared) for every photon within `radius` (its surface included), in an order that
    /// depends on the photons and the point only.
    template <class Visitor> void forEachWithin(const Vec3& point, float radius, Visitor&& visitor) const;

private:
    std::vector<photons::Photon> photons_;
    KdIndex index_; ///< numbers in photons_
};

template <class Accept>
void KdTree::nearest(const Vec3& point, std::size_t k, float maxRadius, Accept&& accept, NearestQueue& queue) const {
    const auto search = [&](const auto& reach, const auto& candidate) {
        return index_.search(point, nullptr, reach, candidate);
    };
    collectNearest(search, photons_, k, maxRadius, accept, queue);
}

template <class Accept>
void KdTree::nearest(const Vec3& point, std::size_t k, float maxRadius, const Slab& slab, Accept&& accept,
                     NearestQueue& queue) const {
    const auto search = [&](const auto& reach, const auto& candidate) {
        return index_.search(point, &slab, reach, candidate);
    };
    collectNearest(search, photons_, k, maxRadius, accept, queue);
}

template <class Measure>
void KdTree::nearestBy(const Vec3& point, std::size_t k, float maxRadius, const Slab& slab, float surplus,
                       Measure&& measure, NearestQueue& queue) const {
    const auto search = [&](const auto& reach, const auto& candidate) {
        return index_.search(point, slab.limits() ? &slab : nullptr, reach, candidate);
    };
    collectNearestBy(search, photons_, k, maxRadius, surplus, measure, queue);
}

template <class Visitor> void KdTree::forEachWithin(const Vec3& point, float radius, Visitor&& visitor) const {
    const float reach = reachOfRadius(radius);
    index_.search(
        point, nullptr, [&] { return reach; }, [&](std::uint32_t number, float d) { visitor(photons_[number], d); });
}

} // namespace pie::maps
