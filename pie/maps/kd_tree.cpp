#include "pie/maps/kd_tree.h"

#include <utility>

namespace pie::maps {

void KdTree::build(std::vector<photons::Photon> photons) {
    photons_ = std::move(photons);
    std::vector<KdIndex::Item> items;
    items.reserve(photons_.size());
    for (std::size_t i = 0; i < photons_.size(); ++i) {
        const Vec3& p = photons_[i].position;
        if (isFinite(p)) items.push_back({{p.x, p.y, p.z}, static_cast<std::uint32_t>(i)});
    }
    index_.build(items);
}

std::vector<photons::Photon> KdTree::release() {
    index_.clear();
    return std::exchange(photons_, {});
}

std::size_t KdTree::bytes() const { return photons_.capacity() * sizeof(photons::Photon) + index_.bytes(); }

} // namespace pie::maps
