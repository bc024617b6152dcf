#pragma once
// Which items lie in a bucket: items are numbered as they are added, every bucket is a chain of them, the latest first.
// The search for planes and corners within a tolerance asks this for every face and corner of a map.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace pie::brushes {

class ChainedIndex {
public:
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    /// Puts the next item, number 0, 1, 2 …, into a bucket.
    void add(std::int64_t bucket) {
        if (2 * (next_.size() + 1) > slots_.size()) grow();
        Slot& slot = slots_[slotOf(bucket)];
        next_.push_back(slot.first);
        slot = {bucket, static_cast<std::uint32_t>(next_.size() - 1)};
    }
    /// The first item of a bucket; `none` if there is none.
    [[nodiscard]] std::uint32_t first(std::int64_t bucket) const {
        return slots_.empty() ? none : slots_[slotOf(bucket)].first;
    }
    /// The one behind it in the same bucket.
    [[nodiscard]] std::uint32_t next(std::uint32_t item) const { return next_[item]; }

private:
    struct Slot {
        std::int64_t bucket = 0;
        std::uint32_t first = none;
    };
    std::vector<Slot> slots_; ///< a power of two of them, at most half in use
    std::vector<std::uint32_t> next_;

    [[nodiscard]] std::size_t slotOf(std::int64_t bucket) const {
        constexpr std::uint64_t golden = 0x9E3779B97F4A7C15U;
        const std::size_t mask = slots_.size() - 1;
        std::size_t at = (static_cast<std::uint64_t>(bucket) * golden >> 32U) & mask;
        while (slots_[at].first != none && slots_[at].bucket != bucket) at = (at + 1) & mask;
        return at;
    }
    void grow() {
        std::vector<Slot> old(slots_.empty() ? 64 : 2 * slots_.size());
        old.swap(slots_);
        for (const Slot& slot : old)
            if (slot.first != none) slots_[slotOf(slot.bucket)] = slot;
    }
};

} // namespace pie::brushes
