#include "pie/maps/exact.h"

namespace pie::maps {

void ExactMap::build(std::vector<photons::Photon> photons) {
    photons_ = std::move(photons);
    bounds_ = {};
    for (const photons::Photon& photon : photons_)
        if (isFinite(photon.position)) bounds_.extend(photon.position);
}

std::size_t ExactMap::bytes() const { return photons_.capacity() * sizeof(photons::Photon); }

} // namespace pie::maps
