#pragma once
// The exact map: looks at every photon (pi-engine 7.1). Slow and plain on purpose; it is what the other maps are
// verified against. Same protocol as KdTree.

#include "pie/maps/nearest.h"

#include <utility>

namespace pie::maps {

class ExactMap {
public:
    void build(std::vector<photons::Photon> photons);
    /// Hands the photons back and leaves the map empty, so that their memory can be filled again.
    [[nodiscard]] std::vector<photons::Photon> release() { return std::exchange(photons_, {}); }
    [[nodiscard]] std::span<const photons::Photon> photons() const { return photons_; }
    [[nodiscard]] const Box& bounds() const { return bounds_; } ///< of the photons with finite positions
    [[nodiscard]] std::size_t bytes() const;

    /// The k nearest photons within maxRadius (its surface included) for which accept(photon) is true.
    template <class Accept>
    void nearest(const Vec3& point, std::size_t k, float maxRadius, Accept&& accept, NearestQueue& queue) const {
        queue.reset(k, reachOfRadius(maxRadius));
        if (!isFinite(point)) return;
        queue.count({0, 0, photons_.size()});
        for (std::size_t i = 0; i < photons_.size(); ++i) {
            const photons::Photon& photon = photons_[i];
            const float d = distanceSquared(photon.position, point);
            if (d <= queue.reach() && isFinite(photon.position) && accept(photon))
                queue.offer({d, static_cast<std::uint32_t>(i)});
        }
    }

    /// The same; see Slab.
    template <class Accept>
    void nearest(const Vec3& point, std::size_t k, float maxRadius, const Slab& /*hint*/, Accept&& accept,
                 NearestQueue& queue) const {
        nearest(point, k, maxRadius, accept, queue);
    }

    /// The k nearest in a measure of your own; see KdTree.
    template <class Measure>
    void nearestBy(const Vec3& point, std::size_t k, float maxRadius, const Slab& /*hint*/, float surplus,
                   Measure&& measure, NearestQueue& queue) const {
        queue.reset(k, reachOfRadius(maxRadius));
        if (!isFinite(point)) return;
        queue.count({0, 0, photons_.size()});
        for (std::size_t i = 0; i < photons_.size(); ++i) {
            const photons::Photon& photon = photons_[i];
            const float d = distanceSquared(photon.position, point);
            if (!(d <= queue.reach() + surplus) || !isFinite(photon.position)) continue;
            const float measured = measure(photon, d);
            if (measured >= 0.0F) queue.offer({measured, static_cast<std::uint32_t>(i)});
        }
    }

    /// visitor(photon, distanceSquared) for every photon within `radius`, in the order of their numbers.
    template <class Visitor> void forEachWithin(const Vec3& point, float radius, Visitor&& visitor) const {
        const float reach = reachOfRadius(radius);
        if (!isFinite(point)) return;
        for (const photons::Photon& photon : photons_) {
            const float d = distanceSquared(photon.position, point);
            if (d <= reach && isFinite(photon.position)) visitor(photon, d);
        }
    }

private:
    std::vector<photons::Photon> photons_;
    Box bounds_;
};

} // namespace pie::maps
