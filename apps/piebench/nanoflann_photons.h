#pragma once
// Photons as nanoflann wants to see points: the comparison in every benchmark of photon maps.

#include "pie/photons/photon.h"

#include <nanoflann.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace piebench {

struct PhotonCloud {
    std::vector<pie::photons::Photon> photons;
    // NOLINTBEGIN(readability-identifier-naming): the names nanoflann asks for
    [[nodiscard]] std::size_t kdtree_get_point_count() const { return photons.size(); }
    [[nodiscard]] float kdtree_get_pt(std::size_t i, std::size_t axis) const {
        return photons[i].position[static_cast<int>(axis)];
    }
    template <class B> bool kdtree_get_bbox(B& /*box*/) const { return false; }
    // NOLINTEND(readability-identifier-naming)
};
using NanoflannIndex = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PhotonCloud>,
                                                           PhotonCloud, 3, std::uint32_t>;

} // namespace piebench
