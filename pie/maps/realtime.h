#pragma once
// The real-time photon map (pi-engine 5.3.1): the photons of the last `accumulationFrames` frames, one vector each,
// seen as one map.
//
// Each frame: hand the new photons to `replaceOldest` (or to `replaceFrame` when a schedule says which), then
// `rebuild`, then search. A frame is taken out whole, so removal is exact: nothing of it stays. Every photon carries
// its share of its own frame's light; `fluxScale`, one over the frames present, makes the sum of the map the light of
// one frame, so a map that is still filling is right from the first frame on, only noisier.
//
// With a Partition the tree is several (SplitTree), and whoever searches has to say which of them matter.
//
// Between replacing and rebuilding, searches still see the last rebuilt state.

#include "pie/maps/exact.h"
#include "pie/maps/kd_tree.h"
#include "pie/maps/split_tree.h"

#include <cstddef>
#include <memory>
#include <variant>

namespace pie::maps {

enum class Search : std::uint8_t {
    KdTree, ///< fast
    Exact,  ///< every photon is looked at: verifies the other
};

class RealtimeMap {
public:
    /// `partition` may be null: one map.
    explicit RealtimeMap(std::size_t accumulationFrames = 1, Search search = Search::KdTree,
                         std::shared_ptr<const Partition> partition = nullptr);
    /// How photons are divided; null for one map. Search::Exact stays one map, and whoever searches asks each photon.
    [[nodiscard]] const std::shared_ptr<const Partition>& partition() const { return partition_; }

    [[nodiscard]] std::size_t accumulationFrames() const { return frames_.size(); }
    /// Keeps the newest frames. 0 counts as 1.
    void setAccumulationFrames(std::size_t count);
    [[nodiscard]] std::size_t framesPresent() const; ///< at most accumulationFrames

    /// Puts a frame into an empty slot, or in place of the oldest frame. Returns what was there, so that whoever keeps
    /// sums can take it out of them, and that memory can be used again.
    std::vector<photons::Photon> replaceOldest(std::vector<photons::Photon>&& photons);
    /// The same for a given slot, slot < accumulationFrames(); the frame becomes the newest.
    std::vector<photons::Photon> replaceFrame(std::size_t slot, std::vector<photons::Photon>&& photons);
    std::vector<photons::Photon> removeFrame(std::size_t slot);
    void clear(); ///< removes every frame
    /// The slot replaceOldest would use.
    [[nodiscard]] std::size_t oldestSlot() const;

    /// Makes what was replaced visible to searches.
    void rebuild();
    /// How often it was rebuilt: what was derived from the photons is of this revision.
    [[nodiscard]] std::uint64_t revision() const { return revision_; }

    /// What a photon's flux is multiplied with: 1 / frames present at the last rebuild. 0 without frames.
    [[nodiscard]] float fluxScale() const { return fluxScale_; }
    /// All photons of the last rebuild, slot after slot.
    [[nodiscard]] std::span<const photons::Photon> photons() const;
    /// For each frame present at the last rebuild, in the order of their slots, the number of the photon behind its
    /// last: the batches that standard errors are made of.
    [[nodiscard]] std::span<const std::uint32_t> frameEnds() const { return frameEnds_; }
    [[nodiscard]] Box bounds() const;
    [[nodiscard]] std::size_t bytes() const;
    /// Calls use(map) with the KdTree, the ExactMap or the SplitTree of the last rebuild.
    template <class Use> decltype(auto) visit(Use&& use) const { return std::visit(std::forward<Use>(use), map_); }

private:
    struct Frame {
        std::vector<photons::Photon> photons;
        std::uint64_t age = 0; ///< count of frames at its arrival; 0: empty slot
    };
    std::vector<Frame> frames_;
    std::uint64_t arrivals_ = 0;
    std::shared_ptr<const Partition> partition_;
    std::variant<KdTree, ExactMap, SplitTree> map_;
    std::vector<std::uint32_t> frameEnds_;
    std::uint64_t revision_ = 0;
    float fluxScale_ = 0;
};

} // namespace pie::maps
