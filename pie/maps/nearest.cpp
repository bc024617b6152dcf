#include "pie/maps/nearest.h"

#include <algorithm>

namespace pie::maps {
namespace {

/// Reserved at once; a larger k grows with the photons that are really found, so that k = 2^60 costs nothing.
constexpr std::size_t reservedAtOnce = 4096;

} // namespace

void NearestQueue::reset(std::size_t k, float maxDistanceSquared) {
    found_.clear();
    k_ = k;
    reach_ = k > 0 && maxDistanceSquared >= 0.0F ? maxDistanceSquared : -1.0F;
    found_.reserve(std::min(k, reservedAtOnce));
}

void NearestQueue::makeHeap() {
    for (std::size_t i = found_.size() / 2; i-- > 0;) {
        const Neighbour value = found_[i];
        siftDown(i, value);
    }
    reach_ = found_.front().distanceSquared;
}

} // namespace pie::maps
