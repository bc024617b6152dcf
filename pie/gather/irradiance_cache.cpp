#include "pie/gather/irradiance_cache.h"

#include <algorithm>
#include <cmath>

namespace pie::gather {
namespace {

/// Records whose centre lies this far in front of a point, in radii, see what the point does not (Ward's test).
constexpr float inFront = 0.05F;

} // namespace

std::size_t IrradianceCache::Hash::operator()(const Cell& cell) const {
    std::uint64_t h = static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell.level)) * 0x9e3779b97f4a7c15U;
    for (const std::int64_t part : {cell.x, cell.y, cell.z}) {
        h ^= static_cast<std::uint64_t>(part);
        h *= 0xff51afd7ed558ccdU;
        h ^= h >> 32U;
    }
    return h;
}

IrradianceCache::Cell IrradianceCache::cellAt(const Vec3& point, std::int32_t level) {
    const auto at = [&](float x) {
        const double cell = std::floor(std::ldexp(static_cast<double>(x), -level));
        return static_cast<std::int64_t>(std::clamp(cell, -9e18, 9e18));
    };
    return {level, at(point.x), at(point.y), at(point.z)};
}

std::uint32_t IrradianceCache::add(const Vec3& position, const Vec3& normal, float radius, bool kind) {
    const auto number = static_cast<std::uint32_t>(records_.size());
    records_.push_back({position, normal, radius, kind});
    const float reach = accuracy_ * radius;
    const std::int32_t level = std::ilogb(reach) + 1;
    const auto place = std::lower_bound(levels_.begin(), levels_.end(), level);
    if (place == levels_.end() || *place != level) levels_.insert(place, level);
    const Cell lower = cellAt(position - reach, level);
    const Cell upper = cellAt(position + reach, level);
    for (std::int64_t z = lower.z; z <= upper.z; ++z)
        for (std::int64_t y = lower.y; y <= upper.y; ++y)
            for (std::int64_t x = lower.x; x <= upper.x; ++x) cells_[{level, x, y, z}].push_back(number);
    return number;
}

void IrradianceCache::interpolate(const Vec3& position, const Vec3& normal, bool kind,
                                  std::vector<Weight>& weights) const {
    weights.clear();
    float sum = 0;
    for (const std::int32_t level : levels_) {
        const auto found = cells_.find(cellAt(position, level));
        if (found == cells_.end()) continue;
        for (const std::uint32_t number : found->second) {
            const Record& record = records_[number];
            if (record.kind != kind) continue;
            const Vec3 offset = position - record.position;
            const float turn = std::sqrt(std::max(0.0F, 1.0F - glm::dot(normal, record.normal)));
            const float error = glm::length(offset) / record.radius + turn;
            if (!(error < accuracy_)) continue;
            if (glm::dot(offset, normal + record.normal) < -2 * inFront * record.radius) continue;
            // Less what a record at the border of its reach would count, so that none appears at once (Tabellion and
            // Lamorlette 2004).
            const float weight = 1 / std::max(error, 1e-4F * accuracy_) - 1 / accuracy_;
            if (!(weight > 0.0F)) continue;
            weights.push_back({number, weight});
            sum += weight;
        }
    }
    for (Weight& weight : weights) weight.weight /= sum;
}

std::size_t IrradianceCache::bytes() const {
    std::size_t listed = 0;
    for (const auto& entry : cells_) listed += sizeof(entry) + entry.second.capacity() * sizeof(std::uint32_t);
    return records_.capacity() * sizeof(Record) + listed;
}

} // namespace pie::gather
