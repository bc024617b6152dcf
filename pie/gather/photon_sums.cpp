#include "pie/gather/photon_sums.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace pie::gather {
namespace {

constexpr std::size_t photonsPerTask = 1024;
// A frame's photons together carry a few times the power of the lights (bounces), so 2⁶³ units hold 10⁷ frames.
constexpr double unitsOfPower = 0x1p34;

std::int64_t fixedPoint(float flux, double unit) {
    const double units = static_cast<double>(flux) / unit;
    // One photon that carries more than all lights together, or is no number, is a mistake of its maker.
    if (!(std::abs(units) < 0x1p50)) return 0;
    return std::llround(units);
}

void addTo(std::int64_t& sum, std::int64_t value) {
    std::atomic_ref<std::int64_t>(sum).fetch_add(value, std::memory_order_relaxed);
}

} // namespace

PhotonSums::PhotonSums(const SurfaceTexels& texels, double power, bool keepBatches)
    : texels_(texels), sums_(texels.levels()) {
    setUnit(power);
    for (std::size_t level = 0; level < sums_.size(); ++level) sums_[level].assign(texels.texels(level).size(), Sum{});
    if (keepBatches) batchSums_.assign(texels.texels().size() * batches, Sum{});
}

void PhotonSums::setUnit(double power) {
    unit_ = power > 0 && std::isfinite(power) ? power / unitsOfPower : 1 / unitsOfPower;
}

void PhotonSums::clear(double power) {
    setUnit(power);
    parts_ = 0;
    for (auto& level : sums_) std::fill(level.begin(), level.end(), Sum{});
    std::fill(batchSums_.begin(), batchSums_.end(), Sum{});
}

void PhotonSums::add(const Fallen& fallen, Hits hits) {
    change(fallen, hits, 1);
    parts_ += fallen.parts;
}

void PhotonSums::remove(const Fallen& fallen, Hits hits) {
    change(fallen, hits, -1);
    parts_ -= fallen.parts;
}

void PhotonSums::change(const Fallen& fallen, Hits hits, std::int64_t sign) {
    parallelChunks(fallen.photons.size(), photonsPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const photons::Photon& photon = fallen.photons[i];
            const std::uint32_t texel = fallen.texels[i];
            if (texel == SurfaceTexels::none) continue;
            if (hits != Hits::All && (hits == Hits::First) != (photon.bounce == 0)) continue;
            const Sum change{sign * fixedPoint(photon.flux.x, unit_), sign * fixedPoint(photon.flux.y, unit_),
                             sign * fixedPoint(photon.flux.z, unit_), sign};
            for (std::size_t c = 0; c < change.size(); ++c) addTo(sums_[0][texel][c], change[c]);
            if (batchSums_.empty()) continue;
            const std::size_t batch = (fallen.firstPart + i * fallen.parts / fallen.photons.size()) % batches;
            Sum& sum = batchSums_[std::size_t{texel} * batches + batch];
            for (std::size_t c = 0; c < change.size(); ++c) addTo(sum[c], change[c]);
        }
    });
}

void PhotonSums::update() {
    for (std::size_t level = 1; level < sums_.size(); ++level) {
        std::fill(sums_[level].begin(), sums_[level].end(), Sum{});
        const std::span<const SurfaceTexels::Texel> children = texels_.texels(level - 1);
        for (std::size_t t = 0; t < children.size(); ++t)
            for (std::size_t c = 0; c < 4; ++c) sums_[level][children[t].parent][c] += sums_[level - 1][t][c];
    }
}

Rgb PhotonSums::irradiance(const Sum& sum, const SurfaceTexels::Texel& texel, double frames) const {
    if (!(frames > 0)) return Rgb(0.0F);
    const double factor = unit_ / (frames * static_cast<double>(texel.area) * static_cast<double>(texel.coverage));
    // The compiler's negative lights may outweigh the others.
    const glm::dvec3 light = factor * glm::dvec3(sum[0], sum[1], sum[2]);
    return {glm::max(light, 0.0)};
}

Rgb PhotonSums::irradiance(std::uint32_t texel, std::size_t level) const {
    return irradiance(sums_[level][texel], texels_.texels(level)[texel], frames());
}

Rgb PhotonSums::batchIrradiance(std::uint32_t texel, unsigned batch) const {
    if (batchSums_.empty()) return Rgb(0.0F);
    return irradiance(batchSums_[std::size_t{texel} * batches + batch], texels_.texels()[texel], frames() / batches);
}

Rgb PhotonSums::broadIrradiance(std::uint32_t texel, std::uint32_t enough, std::int64_t* photons) const {
    if (photons) *photons = 0;
    if (texel == SurfaceTexels::none || parts_ <= 0) return Rgb(0.0F);
    std::size_t level = 0;
    while (level + 1 < sums_.size() && sums_[level][texel][3] < static_cast<std::int64_t>(enough))
        texel = texels_.texels(level++)[texel].parent;
    if (photons) *photons = sums_[level][texel][3];
    return irradiance(texel, level);
}

bool PhotonSums::empty() const {
    const auto zero = [](const Sum& sum) { return sum == Sum{}; };
    return parts_ == 0 && std::all_of(sums_[0].begin(), sums_[0].end(), zero) &&
           std::all_of(batchSums_.begin(), batchSums_.end(), zero);
}

std::size_t PhotonSums::bytes() const {
    std::size_t sum = batchSums_.size() * sizeof(Sum);
    for (const auto& level : sums_) sum += level.size() * sizeof(Sum);
    return sum;
}

} // namespace pie::gather
