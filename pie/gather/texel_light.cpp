#include "pie/gather/texel_light.h"

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

TexelLight::Radiosity asRadiosity(const Rgb& light) { return {light.x, light.y, light.z, 0.0F}; }

} // namespace

TexelLight::TexelLight(const SurfaceTexels& texels, double power, const DirectLight* direct, bool keepBatches)
    : texels_(texels), directLight_(direct),
      unit_(power > 0 && std::isfinite(power) ? power / unitsOfPower : 1 / unitsOfPower), sums_(texels.levels()) {
    const std::size_t count = texels.texels().size();
    for (std::size_t level = 0; level < sums_.size(); ++level) sums_[level].assign(texels.texels(level).size(), Sum{});
    if (keepBatches) batchSums_.assign(count * batches, Sum{});
    radiosity_.resize(count);
    if (direct == nullptr) return;
    direct_.assign(count, Rgb(0.0F));
    directError_.assign(count, 0.0F);
    directKnown_.assign(count, 0);
}

void TexelLight::change(std::span<const photons::Photon> photons, std::int64_t sign) {
    frames_ += sign;
    parallelChunks(photons.size(), photonsPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const photons::Photon& photon = photons[i];
            const std::uint32_t texel = texels_.find(photon);
            if (texel == SurfaceTexels::none) continue;
            const Sum change{sign * fixedPoint(photon.flux.x, unit_), sign * fixedPoint(photon.flux.y, unit_),
                             sign * fixedPoint(photon.flux.z, unit_), sign};
            for (std::size_t c = 0; c < change.size(); ++c) addTo(sums_[0][texel][c], change[c]);
            if (batchSums_.empty()) continue;
            Sum& batch = batchSums_[std::size_t{texel} * batches + i * batches / photons.size()];
            for (std::size_t c = 0; c < change.size(); ++c) addTo(batch[c], change[c]);
        }
    });
}

std::size_t TexelLight::direct(std::span<const std::uint32_t> texels) {
    if (directLight_ == nullptr) return 0;
    std::vector<std::uint32_t> fresh;
    for (const std::uint32_t t : texels) {
        if (directKnown_[t] != 0) continue;
        directKnown_[t] = 1;
        fresh.push_back(t);
    }
    if (fresh.empty()) return 0;
    directChanged_ = true;
    const unsigned points = texels_.pointsPerTexel();
    std::vector<std::uint32_t> which;
    which.reserve(fresh.size() * points);
    for (const std::uint32_t t : fresh)
        for (unsigned k = 0; k < points; ++k) which.push_back(t * points + k);
    std::vector<Rgb> light(which.size());
    directLight_->estimate(which, light);
    for (std::size_t i = 0; i < fresh.size(); ++i) {
        const std::span<const Rgb> own = std::span(light).subspan(i * points, points);
        glm::dvec3 sum(0);
        double squares = 0;
        for (std::size_t k = 0; k < own.size(); k += 2) {
            sum += glm::dvec3(own[k]) + glm::dvec3(own[k + 1]);
            const double difference =
                static_cast<double>(meanChannel(own[k])) - static_cast<double>(meanChannel(own[k + 1]));
            squares += difference * difference;
        }
        const std::uint32_t t = fresh[i];
        direct_[t] = Rgb(sum / static_cast<double>(points));
        directError_[t] =
            meanChannel(texels_.texels()[t].reflectance) * static_cast<float>(std::sqrt(squares) / points);
    }
    return fresh.size();
}

Rgb TexelLight::irradiance(const Sum& sum, const SurfaceTexels::Texel& texel, double scale) const {
    const double factor = scale * unit_ / (static_cast<double>(texel.area) * static_cast<double>(texel.coverage));
    // The compiler's negative lights may outweigh the others.
    const glm::dvec3 light = factor * glm::dvec3(sum[0], sum[1], sum[2]);
    return {glm::max(light, 0.0)};
}

void TexelLight::update() {
    const double scale = frames_ > 0 ? 1 / static_cast<double>(frames_) : 0;
    const std::span<const SurfaceTexels::Texel> fine = texels_.texels();
    parallelChunks(fine.size(), 4 * photonsPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            Rgb light = irradiance(sums_[0][t], fine[t], scale);
            if (!direct_.empty()) light += direct_[t];
            radiosity_[t] = asRadiosity(light * fine[t].reflectance);
        }
    });
    if (directChanged_) sumDirect();
    for (std::size_t level = 1; level < sums_.size(); ++level) {
        std::fill(sums_[level].begin(), sums_[level].end(), Sum{});
        const std::span<const SurfaceTexels::Texel> children = texels_.texels(level - 1);
        for (std::size_t t = 0; t < children.size(); ++t)
            for (std::size_t c = 0; c < 4; ++c) sums_[level][children[t].parent][c] += sums_[level - 1][t][c];
    }
}

void TexelLight::sumDirect() {
    directChanged_ = false;
    directSums_.resize(texels_.levels());
    for (std::size_t level = 1; level < texels_.levels(); ++level) {
        directSums_[level].assign(texels_.texels(level).size(), glm::vec4(0.0F));
        const std::span<const SurfaceTexels::Texel> children = texels_.texels(level - 1);
        for (std::size_t t = 0; t < children.size(); ++t) {
            if (level > 1)
                directSums_[level][children[t].parent] += directSums_[level - 1][t];
            else if (directKnown_[t] != 0)
                directSums_[level][children[t].parent] += children[t].area * glm::vec4(direct_[t], 1.0F);
        }
    }
}

Rgb TexelLight::broadDirect(std::uint32_t texel) const {
    if (direct_.empty() || directKnown_[texel] != 0) return directIrradiance(texel);
    for (std::size_t level = 1; level < directSums_.size(); ++level) {
        texel = texels_.texels(level - 1)[texel].parent;
        const glm::vec4& sum = directSums_[level][texel];
        if (sum.w > 0.0F) return Rgb(sum) / sum.w;
    }
    return Rgb(0.0F);
}

std::vector<TexelLight::Radiosity> TexelLight::coarseRadiosity(std::size_t level) const {
    const double scale = frames_ > 0 ? 1 / static_cast<double>(frames_) : 0;
    const std::span<const SurfaceTexels::Texel> coarse = texels_.texels(level);
    std::vector<Radiosity> result(coarse.size());
    for (std::size_t t = 0; t < coarse.size(); ++t) {
        Rgb light = irradiance(sums_[level][t], coarse[t], scale);
        if (level < directSums_.size() && directSums_[level][t].w > 0.0F)
            light += Rgb(directSums_[level][t]) / directSums_[level][t].w;
        result[t] = asRadiosity(light * coarse[t].reflectance);
    }
    return result;
}

std::vector<TexelLight::Radiosity> TexelLight::batchRadiosity(unsigned batch) const {
    std::vector<Radiosity> result(radiosity_.size());
    if (batchSums_.empty() || frames_ <= 0) return result;
    const double scale = static_cast<double>(batches) / static_cast<double>(frames_);
    for (std::size_t t = 0; t < result.size(); ++t)
        result[t] = asRadiosity(irradiance(batchSums_[t * batches + batch], texels_.texels()[t], scale) *
                                texels_.texels()[t].reflectance);
    return result;
}

Rgb TexelLight::broadIrradiance(std::uint32_t texel, std::uint32_t enough, std::int64_t* photons) const {
    if (photons) *photons = 0;
    if (texel == SurfaceTexels::none || frames_ <= 0) return Rgb(0.0F);
    const double scale = 1 / static_cast<double>(frames_);
    std::size_t level = 0;
    while (level + 1 < sums_.size() && sums_[level][texel][3] < static_cast<std::int64_t>(enough))
        texel = texels_.texels(level++)[texel].parent;
    if (photons) *photons = sums_[level][texel][3];
    return irradiance(sums_[level][texel], texels_.texels(level)[texel], scale);
}

std::uint32_t TexelLight::photons(std::uint32_t texel) const { return static_cast<std::uint32_t>(sums_[0][texel][3]); }

bool TexelLight::empty() const {
    const auto zero = [](const Sum& sum) { return sum == Sum{}; };
    return frames_ == 0 && std::all_of(sums_[0].begin(), sums_[0].end(), zero) &&
           std::all_of(batchSums_.begin(), batchSums_.end(), zero);
}

std::size_t TexelLight::bytes() const {
    std::size_t sum = batchSums_.size() * sizeof(Sum) + radiosity_.size() * sizeof(Radiosity) +
                      direct_.size() * (sizeof(Rgb) + sizeof(float) + 1);
    for (const auto& level : sums_) sum += level.size() * sizeof(Sum);
    return sum;
}

} // namespace pie::gather
