#pragma once
// Numbers for positions. Not for use outside pie/scene.

#include "pie/core/flat_index.h"
#include "pie/core/vec.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pie::scene {

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
