#include "pie/gather/texel_light.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace pie::gather {
namespace {

constexpr std::size_t texelsPerTask = 4096;

TexelLight::Radiosity asRadiosity(const Rgb& light) { return {light.x, light.y, light.z, 0.0F}; }

} // namespace

TexelLight::TexelLight(const SurfaceTexels& texels, double power, const DirectLight* direct, bool keepBatches)
    : texels_(texels), directLight_(direct), still_(texels, power, keepBatches) {
    const std::size_t count = texels.texels().size();
    radiosity_.resize(count);
    if (direct == nullptr) return;
    direct_.assign(count, Rgb(0.0F));
    directError_.assign(count, 0.0F);
    directKnown_.assign(count, 0);
}

void TexelLight::add(std::span<const photons::Photon> photons) {
    std::vector<std::uint32_t> found;
    texels_.find(photons, found);
    still_.add({photons, found});
}

void TexelLight::remove(std::span<const photons::Photon> photons) {
    std::vector<std::uint32_t> found;
    texels_.find(photons, found);
    still_.remove({photons, found});
}

TexelLight::Changing& TexelLight::changing(double power) {
    if (!changing_)
        changing_ = std::make_unique<Changing>(Changing{PhotonSums(texels_, power, still_.keepsBatches()),
                                                        PhotonSums(texels_, power, still_.keepsBatches())});
    return *changing_;
}

std::size_t TexelLight::direct(std::span<const std::uint32_t> texels) {
    if (directLight_ == nullptr) return 0;
    std::vector<std::uint32_t> fresh;
    for (const std::uint32_t t : texels) {
        if (directKnown_[t] != 0) continue;
        directKnown_[t] = 1;
        fresh.push_back(t);
    }
    takeDirect(fresh);
    return fresh.size();
}

void TexelLight::renewDirect() {
    std::vector<std::uint32_t> known;
    for (std::uint32_t t = 0; t < directKnown_.size(); ++t)
        if (directKnown_[t] != 0) known.push_back(t);
    takeDirect(known);
}

void TexelLight::takeDirect(std::span<const std::uint32_t> fresh) {
    if (fresh.empty()) return;
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
}

void TexelLight::update() {
    still_.update();
    if (changing_) {
        changing_->first.update();
        changing_->later.update();
    }
    const std::span<const SurfaceTexels::Texel> fine = texels_.texels();
    parallelChunks(fine.size(), texelsPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto t = static_cast<std::uint32_t>(i);
            Rgb light = still_.irradiance(t);
            if (changing_) light += changing_->first.irradiance(t) + changing_->later.irradiance(t);
            if (!direct_.empty()) light += direct_[t];
            radiosity_[t] = asRadiosity(light * fine[t].reflectance);
        }
    });
    if (directChanged_) sumDirect();
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
    const std::span<const SurfaceTexels::Texel> coarse = texels_.texels(level);
    std::vector<Radiosity> result(coarse.size());
    for (std::uint32_t t = 0; t < coarse.size(); ++t) {
        Rgb light = still_.irradiance(t, level);
        if (changing_) light += changing_->first.irradiance(t, level) + changing_->later.irradiance(t, level);
        if (level < directSums_.size() && directSums_[level][t].w > 0.0F)
            light += Rgb(directSums_[level][t]) / directSums_[level][t].w;
        result[t] = asRadiosity(light * coarse[t].reflectance);
    }
    return result;
}

std::vector<TexelLight::Radiosity> TexelLight::batchRadiosity(unsigned batch) const {
    std::vector<Radiosity> result(radiosity_.size());
    for (std::uint32_t t = 0; t < result.size(); ++t) {
        Rgb light = still_.batchIrradiance(t, batch);
        if (changing_) light += changing_->first.batchIrradiance(t, batch) + changing_->later.batchIrradiance(t, batch);
        result[t] = asRadiosity(light * texels_.texels()[t].reflectance);
    }
    return result;
}

Rgb TexelLight::broadFirst(std::uint32_t texel, std::uint32_t enough) const {
    return changing_ ? changing_->first.broadIrradiance(texel, enough) : Rgb(0.0F);
}

Rgb TexelLight::broadIrradiance(std::uint32_t texel, std::uint32_t enough, std::int64_t* photons) const {
    Rgb light = still_.broadIrradiance(texel, enough, photons);
    if (!changing_) return light;
    std::int64_t more = 0;
    light += changing_->later.broadIrradiance(texel, enough, &more);
    if (photons) *photons += more;
    return light;
}

std::uint32_t TexelLight::photons(std::uint32_t texel) const {
    std::int64_t sum = still_.photons(texel);
    if (changing_) sum += changing_->first.photons(texel) + changing_->later.photons(texel);
    return static_cast<std::uint32_t>(sum);
}

std::size_t TexelLight::bytes() const {
    std::size_t sum =
        still_.bytes() + radiosity_.size() * sizeof(Radiosity) + direct_.size() * (sizeof(Rgb) + sizeof(float) + 1);
    if (changing_) sum += changing_->first.bytes() + changing_->later.bytes();
    return sum;
}

} // namespace pie::gather
