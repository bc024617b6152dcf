#include "pie/maps/split_tree.h"

#include "pie/core/parallel.h"

#include <limits>
#include <utility>

namespace pie::maps {
namespace {

constexpr std::size_t photonsAtOnce = 4096;

} // namespace

/// Puts the items into the order of their maps and returns where each begins, and behind the last where it ends;
/// `places` become those of the maps.
std::vector<std::size_t> SplitTree::divide(std::vector<KdIndex::Item>& items,
                                           std::vector<Partition::Place>& places) const {
    const auto keyOf = [](const Partition::Place& place) { return place.cell * Partition::mostClasses + place.normal; };
    std::vector<std::size_t> next(mostMaps + 1, 0);
    for (const Partition::Place& place : places) ++next[keyOf(place) + 1];
    for (std::size_t key = 0; key < mostMaps; ++key) next[key + 1] += next[key];
    std::vector<KdIndex::Item> sorted(items.size());
    std::vector<Partition::Place> maps;
    std::vector<std::size_t> begins;
    for (std::size_t key = 0; key < mostMaps; ++key) {
        if (next[key] == next[key + 1]) continue;
        begins.push_back(next[key]);
        maps.push_back({static_cast<std::uint8_t>(key / Partition::mostClasses),
                        static_cast<std::uint8_t>(key % Partition::mostClasses)});
    }
    begins.push_back(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) sorted[next[keyOf(places[i])]++] = items[i];
    items = std::move(sorted);
    places = std::move(maps);
    return begins;
}

/// Adds a box to the last block, or begins another: a block at or behind `first` with a place left.
void SplitTree::append(std::vector<Block>& blocks, std::size_t first, const Box& box, std::uint8_t bit,
                       std::uint32_t below, std::uint32_t end) {
    if (blocks.size() == first || blocks.back().count == width) {
        Block& block = blocks.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            block.boxes.lower[axis].fill(std::numeric_limits<float>::quiet_NaN());
            block.boxes.upper[axis].fill(std::numeric_limits<float>::quiet_NaN());
        }
    }
    Block& block = blocks.back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        block.boxes.lower[axis][block.count] = box.lower[static_cast<int>(axis)];
        block.boxes.upper[axis][block.count] = box.upper[static_cast<int>(axis)];
    }
    block.bit[block.count] = bit;
    block.below[block.count] = below;
    block.end[block.count] = end;
    ++block.count;
}

void SplitTree::build(std::vector<photons::Photon> photons) {
    photons_ = std::move(photons);
    maps_.clear();
    cells_.clear();
    blocks_.clear();
    bounds_ = {};
    std::vector<KdIndex::Item> items;
    items.reserve(photons_.size());
    for (std::size_t i = 0; i < photons_.size(); ++i) {
        const Vec3& p = photons_[i].position;
        if (isFinite(p)) items.push_back({{p.x, p.y, p.z}, static_cast<std::uint32_t>(i)});
    }
    std::vector<Partition::Place> places(items.size());
    parallelChunks(items.size(), photonsAtOnce, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) places[i] = partition_->placeOf(photons_[items[i].number]);
    });
    const std::vector<std::size_t> begins = divide(items, places);

    maps_.resize(places.size());
    parallelChunks(maps_.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t m = begin; m < end; ++m)
            maps_[m].build(std::span(items).subspan(begins[m], begins[m + 1] - begins[m]));
    });
    for (std::size_t m = 0; m < maps_.size();) {
        const std::uint8_t cell = places[m].cell;
        const std::size_t first = blocks_.size();
        Box box;
        for (; m < maps_.size() && places[m].cell == cell; ++m) {
            append(blocks_, first, maps_[m].bounds(), places[m].normal, static_cast<std::uint32_t>(m), 0);
            box.extend(maps_[m].bounds());
        }
        append(cells_, 0, box, cell, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(blocks_.size()));
        bounds_.extend(box);
    }
}

std::vector<photons::Photon> SplitTree::release() {
    std::vector<photons::Photon> photons = std::exchange(photons_, {});
    build({});
    return photons;
}

std::size_t SplitTree::bytes() const {
    std::size_t total = photons_.capacity() * sizeof(photons::Photon) + maps_.capacity() * sizeof(KdIndex) +
                        (cells_.capacity() + blocks_.capacity()) * sizeof(Block) + partition_->bytes();
    for (const KdIndex& map : maps_) total += map.bytes();
    return total;
}

} // namespace pie::maps
