#pragma once
// Several photon maps in place of one (pi-engine 5.3.4): a kd-tree for each part of a Partition that has photons.
//
// `build`, then ask from as many threads as you like, through `seen`: the maps that matter to a receiver, with the
// protocol of KdTree. Answers are those of ExactMap for the photons that lie in these maps, bit for bit; photons of the
// others are neither visited nor counted. Maps are searched nearest first. Their boxes stand four by four, cells first
// and the maps of a cell below them, so that finding those within reach takes few instructions.

#include "pie/maps/kd_index.h"
#include "pie/maps/partition.h"

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

namespace pie::maps {

class SplitTree {
public:
    explicit SplitTree(std::shared_ptr<const Partition> partition) : partition_(std::move(partition)) {}

    /// At most 2^32 - 1 photons. Depends on them and the partition only.
    void build(std::vector<photons::Photon> photons);
    /// Hands the photons back and leaves the map empty, so that their memory can be filled again.
    [[nodiscard]] std::vector<photons::Photon> release();
    [[nodiscard]] std::span<const photons::Photon> photons() const { return photons_; }
    [[nodiscard]] const Box& bounds() const { return bounds_; } ///< of the photons with finite positions
    [[nodiscard]] std::size_t maps() const { return maps_.size(); }
    [[nodiscard]] std::size_t bytes() const;

    /// The k nearest of all maps, and all within a radius; see KdTree.
    template <class Accept>
    void nearest(const Vec3& point, std::size_t k, float maxRadius, Accept&& accept, NearestQueue& queue) const {
        seen({}).nearest(point, k, maxRadius, Slab{}, accept, queue);
    }
    template <class Visitor> void forEachWithin(const Vec3& point, float radius, Visitor&& visitor) const {
        const float reach = reachOfRadius(radius);
        search(
            {}, point, nullptr, [&] { return reach; },
            [&](std::uint32_t number, float d) { visitor(photons_[number], d); });
    }

    /// Some of the maps. Cheap to make; must not outlive the tree.
    class Some {
    public:
        Some(const SplitTree& tree, const Partition::Seen& seen) : tree_(tree), seen_(seen) {}
        [[nodiscard]] std::span<const photons::Photon> photons() const { return tree_.photons_; } ///< of all maps
        template <class Accept>
        void nearest(const Vec3& point, std::size_t k, float maxRadius, const Slab& slab, Accept&& accept,
                     NearestQueue& queue) const;
        template <class Measure>
        void nearestBy(const Vec3& point, std::size_t k, float maxRadius, const Slab& slab, float surplus,
                       Measure&& measure, NearestQueue& queue) const;

    private:
        const SplitTree& tree_;
        Partition::Seen seen_;
    };
    [[nodiscard]] Some seen(const Partition::Seen& seen) const { return {*this, seen}; }

private:
    static constexpr std::size_t width = KdIndex::width;
    static constexpr std::size_t mostMaps = VisibilityCells::most * Partition::mostClasses;

    /// Boxes of up to four cells, or of up to four maps of a cell.
    struct Block {
        KdIndex::Boxes boxes;
        std::array<std::uint8_t, width> bit{};    ///< in the set of cells or of classes
        std::array<std::uint32_t, width> below{}; ///< of a cell: its first block in blocks_; of a map: its number
        std::array<std::uint32_t, width> end{};   ///< of a cell: behind its last block
        std::size_t count = 0;

        [[nodiscard]] std::uint32_t among(std::uint64_t set) const {
            std::uint32_t mask = 0;
            for (std::size_t i = 0; i < count; ++i) mask |= static_cast<std::uint32_t>(set >> bit[i] & 1U) << i;
            return mask;
        }
    };
    struct Near {
        float distance;
        std::uint32_t map;
        friend bool operator<(const Near& a, const Near& b) {
            return a.distance != b.distance ? a.distance < b.distance : a.map < b.map;
        }
    };

    static void append(std::vector<Block>& blocks, std::size_t first, const Box& box, std::uint8_t bit,
                       std::uint32_t below, std::uint32_t end);
    std::vector<std::size_t> divide(std::vector<KdIndex::Item>& items, std::vector<Partition::Place>& places) const;
    template <class Reach, class Candidate>
    Visits search(const Partition::Seen& seen, const Vec3& point, const Slab* slab, const Reach& reach,
                  const Candidate& candidate) const;

    std::shared_ptr<const Partition> partition_;
    std::vector<photons::Photon> photons_;
    std::vector<KdIndex> maps_; ///< cell by cell; numbers in photons_
    std::vector<Block> cells_;  ///< cells that have photons
    std::vector<Block> blocks_; ///< maps, a cell's side by side
    Box bounds_;
};

/// The maps among `seen` within reach(), nearest first, each as KdIndex::search does it.
template <class Reach, class Candidate>
Visits SplitTree::search(const Partition::Seen& seen, const Vec3& point, const Slab* slab, const Reach& reach,
                         const Candidate& candidate) const {
    Visits visits;
    if (maps_.empty() || !isFinite(point) || !(reach() >= 0.0F)) return visits;
    std::array<Near, mostMaps> waiting; // NOLINT(cppcoreguidelines-pro-type-member-init): filled as it grows
    std::size_t count = 0;
    alignas(16) std::array<float, width> distance;
    const auto meets = [&](const Block& block, std::uint64_t set) {
        std::uint32_t mask = block.among(set);
        if (mask == 0) return mask;
        ++visits.nodes;
        mask &= KdIndex::near(block.boxes, point, reach(), distance);
        if (slab != nullptr && mask != 0) mask &= KdIndex::within(block.boxes, point, *slab);
        return mask;
    };
    for (const Block& cells : cells_)
        for (std::uint32_t there = meets(cells, seen.cells); there != 0; there &= there - 1) {
            const auto cell = static_cast<std::size_t>(std::countr_zero(there));
            for (std::uint32_t b = cells.below[cell]; b < cells.end[cell]; ++b)
                for (std::uint32_t mask = meets(blocks_[b], seen.classes); mask != 0; mask &= mask - 1) {
                    const auto i = static_cast<std::size_t>(std::countr_zero(mask));
                    waiting[count++] = {distance[i], blocks_[b].below[i]};
                }
        }
    std::sort(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(count));
    for (std::size_t i = 0; i < count && waiting[i].distance <= reach(); ++i)
        visits.add(maps_[waiting[i].map].search(point, slab, reach, candidate));
    return visits;
}

template <class Accept>
void SplitTree::Some::nearest(const Vec3& point, std::size_t k, float maxRadius, const Slab& slab, Accept&& accept,
                              NearestQueue& queue) const {
    const auto search = [&](const auto& reach, const auto& candidate) {
        return tree_.search(seen_, point, &slab, reach, candidate);
    };
    collectNearest(search, tree_.photons_, k, maxRadius, accept, queue);
}

template <class Measure>
void SplitTree::Some::nearestBy(const Vec3& point, std::size_t k, float maxRadius, const Slab& slab, float surplus,
                                Measure&& measure, NearestQueue& queue) const {
    const auto search = [&](const auto& reach, const auto& candidate) {
        return tree_.search(seen_, point, slab.limits() ? &slab : nullptr, reach, candidate);
    };
    collectNearestBy(search, tree_.photons_, k, maxRadius, surplus, measure, queue);
}

} // namespace pie::maps
