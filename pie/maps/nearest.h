#pragma once
// What photon maps answer with, and the bounded queue that finds the k nearest without allocating (pi-engine 5.3.3).
//
// A search resets the queue, offers candidates and reads `found`. Which k photons it ends with does not depend on the
// order in which they are offered.

#include "pie/core/vec.h"
#include "pie/photons/photon.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace pie::maps {

struct Neighbour {
    float distanceSquared = 0;
    std::uint32_t photon = 0; ///< number in photons() of the map

    /// One number in the order of (distance², number): distances are not negative, so their bits sort like them.
    [[nodiscard]] std::uint64_t key() const {
        if constexpr (std::endian::native == std::endian::little)
            return std::rotl(std::bit_cast<std::uint64_t>(*this), 32);
        return (std::uint64_t{std::bit_cast<std::uint32_t>(distanceSquared)} << 32U) | photon;
    }
    /// Total order: nearer first, then lower number. With it the k nearest are one set even among ties and duplicates.
    friend bool operator<(const Neighbour& a, const Neighbour& b) { return a.key() < b.key(); }
    friend bool operator==(const Neighbour& a, const Neighbour& b) { return a.key() == b.key(); }
};

/// The squared distance all maps agree on to the last bit: this order of operations, in single precision.
[[nodiscard]] inline float distanceSquared(const Vec3& a, const Vec3& b) {
    const float x = a.x - b.x;
    const float y = a.y - b.y;
    const float z = a.z - b.z;
    return (x * x + y * y) + z * z;
}

/// Square of a search radius, for balls that include their surface: a radius of 0 finds what lies in the very point.
/// Negative where nothing can be found: radius negative or not a number.
[[nodiscard]] inline float reachOfRadius(float radius) { return radius >= 0.0F ? radius * radius : -1.0F; }

/// Where to look: the part of space within halfThickness of the plane through the query point. Only a hint by which
/// maps skip what a filter is going to refuse (the sphere slice of pi-engine fig 3.8); the filter itself stays the
/// judge, so answers are the same without it.
struct Slab {
    Vec3 normal{0.0F}; ///< unit, or zero for no hint
    float halfThickness = std::numeric_limits<float>::infinity();
    [[nodiscard]] bool limits() const { return halfThickness < std::numeric_limits<float>::infinity(); }
};

[[nodiscard]] inline bool isFinite(const Vec3& v) {
    // Infinity and NaN times 0 are NaN; finite numbers are not.
    return v.x * 0.0F == 0.0F && v.y * 0.0F == 0.0F && v.z * 0.0F == 0.0F;
}

/// What searches looked at.
struct Visits {
    std::uint64_t nodes = 0;   ///< of four boxes each
    std::uint64_t leaves = 0;  ///< of up to 16 positions each
    std::uint64_t photons = 0; ///< near enough to be read, whether accepted or not
    void add(const Visits& more) {
        nodes += more.nodes;
        leaves += more.leaves;
        photons += more.photons;
    }
};

/// Keeps the k smallest neighbours offered. A plain list until it is full, a max-heap from then on. `reset` allocates
/// only when k grows past what it has seen and the photons found past what it had to hold.
class NearestQueue {
public:
    /// A negative `maxDistanceSquared` and k = 0 accept nothing.
    void reset(std::size_t k, float maxDistanceSquared);
    /// Room for k neighbours, so that no later search with at most that k allocates.
    void reserve(std::size_t k) { found_.reserve(k); }
    /// Candidates past this squared distance cannot enter; one at it may, when its number is low. Shrinks once full.
    [[nodiscard]] float reach() const { return reach_; }
    void offer(const Neighbour& candidate) {
        if (!(candidate.distanceSquared <= reach_)) return;
        if (found_.size() < k_) {
            found_.push_back(candidate);
            if (found_.size() == k_) makeHeap();
        } else if (candidate < found_.front()) {
            replaceFarthest(candidate);
        }
    }
    [[nodiscard]] std::span<const Neighbour> found() const { return found_; } ///< no order
    [[nodiscard]] bool full() const { return k_ > 0 && found_.size() == k_; }
    /// The k-th nearest. Only when full.
    [[nodiscard]] const Neighbour& farthest() const { return found_.front(); }
    void count(const Visits& visits) { visits_.add(visits); }
    [[nodiscard]] const Visits& visits() const { return visits_; } ///< of all searches since the queue was made

private:
    void makeHeap();
    void siftDown(std::size_t hole, const Neighbour& value);
    void replaceFarthest(const Neighbour& value) {
        siftDown(0, value);
        reach_ = found_.front().distanceSquared;
    }

    std::vector<Neighbour> found_;
    std::size_t k_ = 0;
    float reach_ = -1;
    Visits visits_;
};

/// Sinks the hole to the bottom along the larger children, then lifts the value: it nearly always belongs near the
/// bottom, so this branches predictably where comparing on the way down does not.
inline void NearestQueue::siftDown(std::size_t hole, const Neighbour& value) {
    const std::size_t size = found_.size();
    const std::size_t top = hole;
    Neighbour* const heap = found_.data();
    std::size_t child = 2 * hole + 1;
    for (; child + 1 < size; child = 2 * hole + 1) {
        child += static_cast<std::size_t>(heap[child].key() < heap[child + 1].key());
        heap[hole] = heap[child];
        hole = child;
    }
    if (child < size) {
        heap[hole] = heap[child];
        hole = child;
    }
    while (hole > top) {
        const std::size_t parent = (hole - 1) / 2;
        if (!(heap[parent] < value)) break;
        heap[hole] = heap[parent];
        hole = parent;
    }
    heap[hole] = value;
}

/// The k nearest of `photons` that accept(photon) takes, by search(reach, candidate) over their numbers. The span is
/// copied into the candidate: through a reference searches took 7 % longer.
template <class Search, class Accept>
void collectNearest(const Search& search, std::span<const photons::Photon> photons, std::size_t k, float maxRadius,
                    const Accept& accept, NearestQueue& queue) {
    queue.reset(k, reachOfRadius(maxRadius));
    queue.count(search([&] { return queue.reach(); },
                       [&, photons](std::uint32_t number, float d) {
                           if (accept(photons[number])) queue.offer({d, number});
                       }));
}

/// The same in a measure that is never less than distanceSquared - surplus; negative refuses.
template <class Search, class Measure>
void collectNearestBy(const Search& search, std::span<const photons::Photon> photons, std::size_t k, float maxRadius,
                      float surplus, const Measure& measure, NearestQueue& queue) {
    queue.reset(k, reachOfRadius(maxRadius));
    queue.count(search([&] { return queue.reach() < 0.0F ? -1.0F : queue.reach() + surplus; },
                       [&, photons](std::uint32_t number, float d) {
                           const float measured = measure(photons[number], d);
                           if (measured >= 0.0F) queue.offer({measured, number});
                       }));
}

} // namespace pie::maps
