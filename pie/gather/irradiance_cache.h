#pragma once
// Where irradiance is known and how far it holds (Ward, Rubinstein and Clear 1988): records with a position, a normal
// and a radius, and for any point the records that hold there, with their weights.
//
// `add` records, then `interpolate` from as many threads as you like; not both at once. The order of what is visited
// depends on the order of adding alone.

#include "pie/core/vec.h"

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace pie::gather {

class IrradianceCache {
public:
    struct Weight {
        std::uint32_t record = 0;
        float weight = 0; ///< all of a point add up to 1
    };

    /// `accuracy`: Ward's a, above 0. A record counts at distance d and with a normal n where d/R + sqrt(1 − n·n') <
    /// accuracy.
    explicit IrradianceCache(float accuracy) : accuracy_(accuracy) {}
    /// Returns its number: 0, 1, … `radius` R above 0, units: the harmonic mean of the distances seen. `kind`: records
    /// of another kind do not count.
    std::uint32_t add(const Vec3& position, const Vec3& normal, float radius, bool kind);
    /// The records that hold at a point; empty when none does.
    void interpolate(const Vec3& position, const Vec3& normal, bool kind, std::vector<Weight>& weights) const;
    [[nodiscard]] std::size_t size() const { return records_.size(); }
    [[nodiscard]] std::size_t bytes() const;

private:
    struct Record {
        Vec3 position;
        Vec3 normal;
        float radius;
        bool kind;
    };
    /// Cells of edge 2^level; a record is listed in those that its reach, at most 2^level, touches.
    struct Cell {
        std::int32_t level = 0;
        std::int64_t x = 0, y = 0, z = 0;
        bool operator==(const Cell&) const = default;
    };
    struct Hash {
        std::size_t operator()(const Cell& cell) const;
    };
    static Cell cellAt(const Vec3& point, std::int32_t level);

    float accuracy_;
    std::vector<Record> records_;
    std::vector<std::int32_t> levels_; ///< in use, rising
    std::unordered_map<Cell, std::vector<std::uint32_t>, Hash> cells_;
};

} // namespace pie::gather
