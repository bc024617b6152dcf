#pragma once
// A hash index from keys that live elsewhere to their numbers: find what is equal, else append it there and insert its
// number here. Open addressing, eight bytes a slot; numbers are handed out by the caller, so results never depend on
// the table. Not for use outside pie/scene.

#include "pie/core/vec.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pie::scene {

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

/// Both zeros are one position.
[[nodiscard]] inline std::uint32_t hashPosition(const Vec3& p) {
    const std::uint64_t x = std::bit_cast<std::uint32_t>(p.x + 0.0F);
    const std::uint64_t y = std::bit_cast<std::uint32_t>(p.y + 0.0F);
    const std::uint64_t z = std::bit_cast<std::uint32_t>(p.z + 0.0F);
    return mixBits((x << 32U | y) ^ z * 0x9e3779b97f4a7c15ULL);
}

/// Positions, each once: bit-equal positions share a number.
class PositionIndex {
public:
    explicit PositionIndex(std::size_t expected = 0) : index_(expected) {}

    /// The number of `p`, new if there was none. `points` belongs to this index alone.
    std::uint32_t add(std::vector<Vec3>& points, const Vec3& p) {
        const std::uint32_t hash = hashPosition(p);
        const std::uint32_t known = index_.find(hash, [&](std::uint32_t i) { return points[i] == p; });
        if (known != FlatIndex::none) return known;
        const auto number = static_cast<std::uint32_t>(points.size());
        points.push_back(p);
        index_.insert(hash, number);
        return number;
    }

private:
    FlatIndex index_;
};

} // namespace pie::scene
