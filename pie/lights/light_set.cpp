#include "pie/lights/light_set.h"
#include "pie/lights/kinds.h"
#include "pie/sampling/directions.h"

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
    for (std::uint32_t i = 0; i < lights_.size(); ++i) {
        if (const auto* sky = std::get_if<SkyLight>(&lights_[i])) {
            for (std::uint32_t k = 0; k < sky->towards.size(); ++k)
                add({i, k, Part::Direction}, detail::scaled(sky->irradiance, projectedArea(portals_, sky->towards[k])));
        } else if (const auto* area = std::get_if<AreaLight>(&lights_[i])) {
            addPolygon(i, *area);
        } else {
            add({i, 0, Part::Whole}, power(lights_[i], *scene_, portals_));
        }
    }
    finish();
}

void LightSet::add(const Entry& entry, const Rgb& watts) {
    const double weight = weightOf(watts);
    if (!(weight > 0.0)) return;
    entries_.push_back(entry);
    entries_.back().scale = weight;
    cumulative_.push_back((cumulative_.empty() ? 0.0 : cumulative_.back()) + weight);
    sum_ += glm::dvec3(watts);
}

void LightSet::addPolygon(std::uint32_t light, const AreaLight& polygon) {
    if (!(weightOf(detail::areaPower(polygon)) > 0.0)) return;
    float reach = 0.0F;
    for (const Vec3& corner : polygon.corners) reach = std::max(reach, largestCoordinate(scene_->bounds, corner));
    for (const float side : {1.0F, -1.0F}) {
        if (side < 0.0F && !polygon.twoSided) return;
        for (std::size_t k = 1; k + 1 < polygon.corners.size(); ++k) {
            Triangle triangle;
            triangle.side1 = polygon.corners[k] - polygon.corners[0];
            triangle.side2 = polygon.corners[k + 1] - polygon.corners[0];
            triangle.normal = side * polygon.normal;
            triangle.corner = polygon.corners[0] + surfaceOffset(reach) * triangle.normal;
            const double area = 0.5 * glm::length(glm::cross(glm::dvec3(triangle.side1), glm::dvec3(triangle.side2)));
            triangle.flux = detail::scaled(polygon.radiosity, area);
            add({light, static_cast<std::uint32_t>(triangles_.size()), Part::Triangle}, triangle.flux);
            triangles_.push_back(triangle);
        }
    }
}

void LightSet::finish() {
    totalPower_ = Rgb(sum_);
    if (entries_.empty()) return;
    const double total = cumulative_.back();
    for (Entry& entry : entries_) {
        entry.scale = total / entry.scale;
        if (entry.part == Part::Triangle)
            triangles_[entry.number].flux = detail::scaled(triangles_[entry.number].flux, entry.scale);
    }
    for (double& share : cumulative_) share /= total;
    cumulative_.back() = 1.0;
    // One bucket or more per entry: a choice looks at about two entries however many lights there are.
    guide_.resize(std::bit_ceil(cumulative_.size()));
    std::uint32_t entry = 0;
    for (std::size_t i = 0; i < guide_.size(); ++i) {
        while (cumulative_[entry] <= static_cast<double>(i) / static_cast<double>(guide_.size())) ++entry;
        guide_[i] = entry;
    }
}

double LightSet::largestPower() const {
    double sum = 0;
    for (const Light& light : lights_)
        sum += static_cast<double>(maxChannel(glm::abs(power(light, *scene_, portals_))));
    return sum;
}

void LightSet::mute(std::uint32_t light) {
    muted_.resize(lights_.size(), 0);
    muted_[light] = 1;
}

void LightSet::muteAllBut(std::uint32_t light) {
    muted_.assign(lights_.size(), 1);
    muted_[light] = 0;
}

const LightSet::Entry& LightSet::choose(float u) const {
    std::size_t i = guide_[static_cast<std::size_t>(u * static_cast<float>(guide_.size()))];
    while (cumulative_[i] <= u) ++i;
    return entries_[i];
}

void LightSet::emitFrom(const Entry& entry, const std::array<float, 4>& u, bool polar, Emission& out) const {
    if (entry.part == Part::Triangle) {
        const Triangle& triangle = triangles_[entry.number];
        const Vec2 weights = sampling::uniformTriangle({u[2], u[3]});
        const Vec2 direction(u[0], u[1]);
        out.origin = triangle.corner + weights.x * triangle.side1 + weights.y * triangle.side2;
        out.direction =
            Frame(triangle.normal)
                .toWorld(polar ? sampling::polarCosineHemisphere(direction) : sampling::cosineHemisphere(direction));
        out.flux = triangle.flux;
        out.falloff = nullptr;
        out.rimRate = std::numeric_limits<float>::infinity();
        return;
    }
    if (entry.part == Part::Direction) {
        const auto& sky = std::get<SkyLight>(lights_[entry.light]);
        out = detail::emitParallel(sky.towards[entry.number], sky.irradiance, *scene_, portals_, {u[2], u[3]});
    } else {
        out = lights::emit(lights_[entry.light], *scene_, portals_, u);
    }
    out.flux = detail::scaled(out.flux, entry.scale);
}

Emission LightSet::emit(const sampling::Sequence& sequence, std::uint64_t index, std::uint32_t* light) const {
    Emission result;
    emit(sequence, index, std::span(&result, 1));
    if (light != nullptr) {
        float u = 0.0F;
        sampling::fill(sequence, index, 0, std::span(&u, 1));
        *light = choose(u).light;
    }
    return result;
}

void LightSet::emit(const sampling::Sequence& sequence, std::uint64_t first, std::span<Emission> out) const {
    constexpr std::size_t block = 256;
    std::array<std::array<float, block>, dimensions> u;
    std::array<const Entry*, block> chosen;
    const bool polar = sampling::isPolar(sequence);
    for (std::size_t done = 0; done < out.size(); done += block) {
        const std::size_t count = std::min(block, out.size() - done);
        const auto numbers = [&](std::size_t d) { return std::span(u[d]).first(count); };
        sampling::fill(sequence, first + done, 0, numbers(0));
        sampling::fillDirections(sequence, first + done, 1, numbers(1), numbers(2));
        sampling::fillPairs(sequence, first + done, 3, numbers(3), numbers(4));
        // Choices first: with thousands of lights what they lead to is not in the cache, and comes while others are
        // chosen.
        for (std::size_t i = 0; i < count; ++i) {
            chosen[i] = &choose(u[0][i]);
            if (chosen[i]->part == Part::Triangle) {
                const auto* triangle = reinterpret_cast<const char*>(&triangles_[chosen[i]->number]);
                __builtin_prefetch(triangle);
                __builtin_prefetch(triangle + sizeof(Triangle) - 1);
            }
        }
        for (std::size_t i = 0; i < count; ++i)
            emitFrom(*chosen[i], {u[1][i], u[2][i], u[3][i], u[4][i]}, polar, out[done + i]);
        if (muted_.empty()) continue;
        for (std::size_t i = 0; i < count; ++i)
            if (muted_[chosen[i]->light] != 0) out[done + i].flux = Rgb(0.0F);
    }
}

} // namespace pie::lights
