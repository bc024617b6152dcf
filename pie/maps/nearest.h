#pragma once
// What photon maps answer with, and the bounded queue that finds the k nearest without allocating (pi-engine 5.3.3).

#include "pie/core/vec.h"
#include "pie/photons/photon.h"

#include <cstdint>
#include <span>
#include <vector>

namespace pie::maps {

struct Neighbour {
    float distanceSquared = 0;
    std::uint32_t photon = 0; ///< PhotonMap::photons()
    /// Total order: nearer first, then lower number. With it the k nearest are one set even among ties and duplicates.
    friend bool operator<(const Neighbour& a, const Neighbour& b) {
        return a.distanceSquared < b.distanceSquared || (a.distanceSquared == b.distanceSquared && a.photon < b.photon);
    }
};

/// Keeps the k smallest neighbours offered. A plain list until it is full, a max-heap from then on. `reset` allocates
/// only when k grows.
class NearestQueue {
public:
    void reset(std::size_t k, float maxDistanceSquared);
    /// Candidates at or past this squared distance cannot enter … shrinks once full.
    [[nodiscard]] float reach() const { return reach_; }
    void offer(const Neighbour& candidate);
    [[nodiscard]] std::span<const Neighbour> found() const { return found_; } ///< no order
    [[nodiscard]] bool full() const { return k_ > 0 && found_.size() == k_; }

private:
    std::vector<Neighbour> found_;
    std::size_t k_ = 0;
    float reach_ = 0;
};

} // namespace pie::maps
