#include "pie/lights/light_set.h"
#include "pie/lights/kinds.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pie::lights {
namespace {

/// What decides how many photons a light gets. Not a number, or infinite: none.
double weightOf(const Rgb& power) {
    const double weight = (std::abs(static_cast<double>(power.x)) + std::abs(static_cast<double>(power.y)) +
                           std::abs(static_cast<double>(power.z))) /
                          3.0;
    return std::isfinite(weight) ? weight : 0.0;
}

} // namespace

LightSet::LightSet(std::vector<Light> lights, std::shared_ptr<const scene::Scene> scene)
    : lights_(std::move(lights)), scene_(std::move(scene)) {
    if (!scene_) scene_ = std::make_shared<scene::Scene>();
    portals_ = skyPortals(*scene_);
    double total = 0.0;
    glm::dvec3 sum(0.0);
    const auto add = [&](std::uint32_t light, std::uint32_t direction, const Rgb& watts) {
        const double weight = weightOf(watts);
        if (!(weight > 0.0)) return;
        entries_.push_back({light, direction, weight});
        cumulative_.push_back(total += weight);
        sum += glm::dvec3(watts);
    };
    for (std::uint32_t i = 0; i < lights_.size(); ++i) {
        if (const auto* sky = std::get_if<SkyLight>(&lights_[i])) {
            for (std::uint32_t k = 0; k < sky->towards.size(); ++k)
                add(i, k, detail::scaled(sky->irradiance, projectedArea(portals_, sky->towards[k])));
        } else {
            add(i, 0, power(lights_[i], *scene_, portals_));
        }
    }
    totalPower_ = Rgb(sum);
    for (auto& entry : entries_) entry.scale = total / entry.scale;
    for (double& share : cumulative_) share /= total;
    if (cumulative_.empty()) return;
    cumulative_.back() = 1.0;
    // One bucket or more per entry: a choice looks at about two entries however many lights there are.
    guide_.resize(std::bit_ceil(cumulative_.size()));
    std::uint32_t entry = 0;
    for (std::size_t i = 0; i < guide_.size(); ++i) {
        while (cumulative_[entry] <= static_cast<double>(i) / static_cast<double>(guide_.size())) ++entry;
        guide_[i] = entry;
    }
}

const LightSet::Entry& LightSet::choose(float u) const {
    std::size_t i = guide_[static_cast<std::size_t>(u * static_cast<float>(guide_.size()))];
    while (cumulative_[i] <= u) ++i;
    return entries_[i];
}

Emission LightSet::emit(const sampling::Halton& halton, std::uint64_t index, std::uint32_t* light) const {
    const Entry& entry = choose(entries_.size() > 1 ? halton(index, 0) : 0.0F);
    const Light& source = lights_[entry.light];
    if (light != nullptr) *light = entry.light;
    const std::array<float, 4> u{halton(index, 1), halton(index, 2), halton(index, 3), halton(index, 4)};
    Emission result;
    if (const auto* sky = std::get_if<SkyLight>(&source))
        result = detail::emitParallel(sky->towards[entry.direction], sky->irradiance, *scene_, portals_, {u[2], u[3]});
    else
        result = lights::emit(source, *scene_, portals_, u);
    result.flux = detail::scaled(result.flux, entry.scale);
    return result;
}

} // namespace pie::lights
