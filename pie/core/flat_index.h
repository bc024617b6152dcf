#pragma once
// A hash index from keys that live elsewhere to their numbers: find what is equal, else append it there and insert its
// number here. Open addressing, eight bytes a slot; numbers are handed out by the caller, so results never depend on
// the table.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pie {

class FlatIndex {
public:
    static constexpr std::uint32_t none = 0xffffffffU;

    explicit FlatIndex(std::size_t expected = 0) { slots_.resize(std::bit_ceil(expected * 2 + 16)); }

    /// The number whose key `same(number)` accepts, or none.
    template <class Same> [[nodiscard]] std::uint32_t find(std::uint32_t hash, const Same& same) const {
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t i = hash & mask; slots_[i].value != none; i = (i + 1) & mask)
            if (slots_[i].hash == hash && same(slots_[i].value)) return slots_[i].value;
        return none;
    }

    void insert(std::uint32_t hash, std::uint32_t value) {
        if (++count_ * 2 > slots_.size()) grow();
        place(slots_, {hash, value});
    }

    [[nodiscard]] std::size_t bytes() const { return slots_.size() * sizeof(Slot); }

private:
    struct Slot {
        std::uint32_t hash = 0, value = none;
    };

    static void place(std::vector<Slot>& slots, const Slot& slot) {
        const std::size_t mask = slots.size() - 1;
        std::size_t i = slot.hash & mask;
        while (slots[i].value != none) i = (i + 1) & mask;
        slots[i] = slot;
    }

    void grow() {
        std::vector<Slot> larger(slots_.size() * 2);
        for (const Slot& slot : slots_)
            if (slot.value != none) place(larger, slot);
        slots_ = std::move(larger);
    }

    std::vector<Slot> slots_;
    std::size_t count_ = 0;
};

[[nodiscard]] inline std::uint32_t mixBits(std::uint64_t key) {
    key ^= key >> 32U;
    key *= 0xff51afd7ed558ccdULL;
    key ^= key >> 29U;
    key *= 0xc4ceb9fe1a85ec53ULL;
    return static_cast<std::uint32_t>(key >> 32U);
}

} // namespace pie
