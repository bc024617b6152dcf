#include "pie/gather/bright_texels.h"

#include <algorithm>
#include <cmath>

namespace pie::gather {

void BrightTexels::choose(std::span<const photons::Photon> photons) {
    struct Fallen {
        double power = 0;
        unsigned photons = 0;
    };
    const std::span<const SurfaceTexels::Texel> texels = texels_.texels();
    std::vector<Fallen> fallen(texels.size());
    double reflected = 0;
    double area = 0;
    for (const photons::Photon& photon : photons) {
        const std::uint32_t t = texels_.find(photon);
        if (t == SurfaceTexels::none) continue;
        const auto power = static_cast<double>(meanChannel(glm::abs(photon.flux) * texels[t].reflectance));
        fallen[t].power += power;
        ++fallen[t].photons;
        reflected += power;
    }
    for (const SurfaceTexels::Texel& texel : texels) area += static_cast<double>(texel.area);
    const double least = brighter * reflected / area;
    std::vector<std::uint32_t> chosen;
    for (std::uint32_t t = 0; t < texels.size(); ++t)
        if (fallen[t].photons >= fewestPhotons && fallen[t].power > least * static_cast<double>(texels[t].area))
            chosen.push_back(t);
    if (chosen.size() > most) {
        std::stable_sort(chosen.begin(), chosen.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return fallen[a].power > fallen[b].power; });
        chosen.resize(most);
        std::sort(chosen.begin(), chosen.end());
    }
    lights_.clear();
    place_.assign(chosen.empty() ? 0 : texels.size(), SurfaceTexels::none);
    for (const std::uint32_t t : chosen) {
        Vec3 normal(0.0F);
        for (unsigned k = 0; k < texels_.pointsPerTexel(); ++k)
            normal += texels_.points().points[std::size_t{t} * texels_.pointsPerTexel() + k].normal;
        const float length = glm::length(normal);
        place_[t] = static_cast<std::uint32_t>(lights_.size());
        lights_.push_back({texels[t].centre, t, length > 0.0F ? normal / length : Vec3(0.0F), texels[t].area,
                           static_cast<float>(fallen[t].power)});
    }
}

/// A texel's parts lie up to its own size off its centre and may face where that does not: cosines count as that much
/// larger, and nothing is nearer than it is large.
float BrightTexels::chance(const scene::Receiver& receiver, const Light& light) {
    const Vec3 to = light.centre - receiver.inset;
    const float squared = glm::dot(to, to);
    const float size = std::sqrt(light.area);
    const float distance = std::sqrt(squared) + size;
    float here = glm::dot(receiver.normal, to);
    if (receiver.twoSided) here = std::abs(here);
    const float there = -glm::dot(light.normal, to);
    if (here <= -size || there <= -size) return 0.0F;
    return light.power * (here + size) * (there + size) / (distance * distance * (squared + light.area));
}

float BrightTexels::chances(const scene::Receiver& receiver, std::vector<float>& sums) const {
    sums.resize(lights_.size());
    float sum = 0;
    for (std::size_t i = 0; i < lights_.size(); ++i) {
        sum += chance(receiver, lights_[i]);
        sums[i] = sum;
    }
    return std::isfinite(sum) ? sum : 0.0F;
}

std::size_t BrightTexels::bytes() const {
    return lights_.size() * sizeof(Light) + place_.size() * sizeof(std::uint32_t);
}

} // namespace pie::gather
