#include "pie/gather/direct_sources.h"

#include "pie/gather/form_factor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <variant>

namespace pie::gather {
namespace {

using Kind = SourceBound::Kind;
constexpr float pi = std::numbers::pi_v<float>;
/// Bounds must not fall below the true value by rounding.
constexpr float margin = 1.0001F;
/// Samples that stand for the unoccluded irradiance of soft sources without a formula.
constexpr unsigned unoccludedSamples = 32;

template <class... Ts> struct Overloaded : Ts... { using Ts::operator()...; };
template <class... Ts> Overloaded(Ts...) -> Overloaded<Ts...>;

float meanAbsolute(const Rgb& c) { return meanChannel(glm::abs(c)); }

/// E = intensity − fade · d' of a linear light, from two values of it.
void setLinear(SourceBound& bound, const lights::Falloff& falloff, const Rgb& power) {
    bound.kind = Kind::Linear;
    lights::PointLight light{Vec3(0.0F), power, falloff};
    light.falloff.extraDistance = 0;
    light.falloff.minDistance = 0;
    const auto at = [&](float distance) {
        const Vec3 down(0.0F, 0.0F, -1.0F);
        return meanAbsolute(lights::illuminate(light, {0.0F, 0.0F, distance}, down, false, Vec2(0.5F)).irradiance);
    };
    const float near = 1;
    const float reach = 0.9375F * std::abs(falloff.linearIntensity) / std::max(falloff.fade, 1e-6F);
    const float far = std::max(2.0F, 0.5F * reach);
    bound.fade = std::max(0.0F, (at(near) - at(far)) / (far - near));
    bound.intensity = at(near) + bound.fade * near;
}

void setFalloff(SourceBound& bound, const lights::Falloff& falloff, const Rgb& power) {
    bound.minDistance = falloff.minDistance;
    bound.extraSquared = falloff.extraDistance * falloff.extraDistance;
    bound.cosineFactor = falloff.noCosine ? 0.0F : falloff.angleScale > 0.0F ? 1.0F / falloff.angleScale : 1.0F;
    bound.intensity = meanAbsolute(power) / (4.0F * pi);
    if (falloff.linear) setLinear(bound, falloff, power);
}

SourceBound boundOf(const lights::Light& light, std::uint32_t direction) {
    SourceBound bound;
    bound.largest = std::numeric_limits<float>::max();
    std::visit(Overloaded{
                   [&](const lights::PointLight& l) {
                       bound.centre = l.position;
                       setFalloff(bound, l.falloff, l.power);
                   },
                   [&](const lights::SphereLight& l) {
                       bound.centre = l.position;
                       bound.spread = std::abs(l.radius);
                       setFalloff(bound, l.falloff, l.power);
                   },
                   [&](const lights::SpotLight& l) {
                       bound.centre = l.position;
                       setFalloff(bound, l.falloff, l.power);
                   },
                   [&](const lights::SunLight& l) {
                       bound.kind = Kind::Parallel;
                       bound.centre = l.towards;
                       bound.spread = l.devianceRadians;
                       bound.intensity = meanAbsolute(l.irradiance);
                   },
                   [&](const lights::AreaLight& l) {
                       bound.kind = l.twoSided ? Kind::TwoSidedPolygon : Kind::Polygon;
                       Box box;
                       for (const Vec3& corner : l.corners) box.extend(corner);
                       bound.centre = box.empty() ? Vec3(0.0F) : box.centre();
                       for (const Vec3& corner : l.corners)
                           bound.spread = std::max(bound.spread, glm::length(corner - bound.centre));
                       bound.facing = l.normal;
                       bound.intensity = meanAbsolute(l.radiosity) * static_cast<float>(l.area) / pi;
                       bound.largest = meanAbsolute(l.radiosity);
                   },
                   [&](const lights::SkyLight& l) {
                       bound.kind = Kind::Parallel;
                       bound.centre = direction < l.towards.size() ? l.towards[direction] : Vec3(0.0F, 0.0F, 1.0F);
                       bound.intensity = meanAbsolute(l.irradiance);
                   },
               },
               light);
    return bound;
}

} // namespace

Sources::Sources(std::span<const lights::Light> lights, float softness, float onPlane) : onPlane_(onPlane) {
    for (std::size_t i = 0; i < lights.size(); ++i) add(lights[i], static_cast<std::uint32_t>(i), softness);
    makeRanks();
}

void Sources::makeRanks() {
    Box box;
    for (const SourceBound& bound : bounds_)
        if (bound.kind != Kind::Parallel) box.extend(bound.centre);
    const Vec3 scale = 1023.0F / glm::max(box.size(), Vec3(1e-30F));
    const auto spread = [](float place) { // ten bits, two zeros after each
        auto x = static_cast<std::uint64_t>(std::clamp(place, 0.0F, 1023.0F));
        std::uint64_t result = 0;
        for (unsigned bit = 0; bit < 10; ++bit) result |= (x >> bit & 1U) << (3 * bit);
        return result;
    };
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
        std::uint64_t code = std::uint64_t{1} << 60U; // parallel light: together, at the end
        if (bounds_[i].kind != Kind::Parallel) {
            const Vec3 place = (bounds_[i].centre - box.lower) * scale;
            code = spread(place.x) | spread(place.y) << 1U | spread(place.z) << 2U;
        }
        order.emplace_back(code, static_cast<std::uint32_t>(i));
    }
    std::sort(order.begin(), order.end());
    ranks_.resize(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) ranks_[order[i].second] = static_cast<std::uint32_t>(i);
}

void Sources::add(const lights::Light& light, std::uint32_t number, float softness) {
    const auto* sky = std::get_if<lights::SkyLight>(&light);
    const std::size_t directions = sky != nullptr ? sky->towards.size() : 1;
    const unsigned deserved = sky != nullptr ? 1U : lights::sampleCount(light);
    const float wanted = std::clamp(softness * static_cast<float>(deserved), 1.0F, 65536.0F);
    const unsigned samples = deserved > 1 ? static_cast<unsigned>(wanted) : 1U;
    for (std::size_t d = 0; d < directions; ++d) {
        sources_.push_back({&light, number, static_cast<std::uint32_t>(d), samples});
        bounds_.push_back(boundOf(light, static_cast<std::uint32_t>(d)));
    }
}

float Sources::bound(std::size_t source, const Place& place) const {
    const SourceBound& b = bounds_[source];
    if (b.kind == Kind::None) return 0.0F;
    if (b.kind == Kind::Parallel) {
        const float cosine = glm::dot(b.centre, place.normal);
        const float facing = (place.twoSided ? std::abs(cosine) : cosine) + b.spread;
        return b.intensity * std::clamp(facing, 0.0F, 1.0F) * margin;
    }
    const Vec3 to = b.centre - place.position;
    const float spread = b.spread + place.shift;
    const float along = glm::dot(to, place.normal);
    const float height = (place.twoSided ? std::abs(along) : along) + spread;
    if (height <= 0.0F) return 0.0F;
    const float distance = std::max(0.0F, glm::length(to) - spread);
    const float softened = std::max(b.minDistance * b.minDistance, distance * distance + b.extraSquared);
    if (b.kind == Kind::Linear) return std::max(0.0F, b.intensity - b.fade * std::sqrt(softened)) * margin;
    // Where the receiver may lie inside the source, both cosines may be one.
    float angles = 1;
    if (b.cosineFactor > 0.0F && distance > 0.0F) angles = std::min(1.0F, b.cosineFactor * height / distance);
    if (b.kind == Kind::Polygon || b.kind == Kind::TwoSidedPolygon) {
        const float before = -glm::dot(to, b.facing);
        const float above = (b.kind == Kind::Polygon ? before : std::abs(before)) + place.shift;
        if (above <= 0.0F) return 0.0F;
        if (distance > 0.0F) angles *= std::min(1.0F, above / distance);
    }
    return std::min(b.largest, b.intensity * angles / std::max(softened, std::numeric_limits<float>::min())) * margin;
}

void Sources::mute(std::uint32_t light) {
    for (std::size_t i = 0; i < sources_.size(); ++i)
        if (sources_[i].number == light) bounds_[i].kind = Kind::None;
}

Vec3 Sources::pointFor(std::size_t source, const Place& place) const {
    const auto* area = std::get_if<lights::AreaLight>(sources_[source].light);
    if (area == nullptr || area->corners.empty()) return place.position;
    const float before = glm::dot(place.position - area->corners.front(), area->normal);
    return std::abs(before) <= onPlane_ ? place.inset : place.position;
}

lights::Illumination Sources::sample(std::size_t source, const Place& place, const Vec2& u) const {
    const Source& s = sources_[source];
    const auto* sky = std::get_if<lights::SkyLight>(s.light);
    if (sky == nullptr) return lights::illuminate(*s.light, pointFor(source, place), place.normal, place.twoSided, u);
    const Vec3& towards = sky->towards[s.direction];
    const float cosine = glm::dot(towards, place.normal);
    return {towards, std::numeric_limits<float>::infinity(),
            sky->irradiance * (place.twoSided ? std::abs(cosine) : std::max(0.0F, cosine)), true};
}

Rgb Sources::unoccluded(std::size_t source, const Place& place) const {
    const Source& s = sources_[source];
    if (const auto* area = std::get_if<lights::AreaLight>(s.light)) {
        if (area->corners.empty()) return Rgb(0.0F);
        const Vec3 point = pointFor(source, place);
        const float before = glm::dot(point - area->corners.front(), area->normal);
        if ((area->twoSided ? std::abs(before) : before) <= onPlane_) return Rgb(0.0F);
        double share = formFactor(area->corners, point, place.normal);
        if (place.twoSided) share += formFactor(area->corners, point, -place.normal);
        return area->radiosity * static_cast<float>(share);
    }
    if (s.samples <= 1) return sample(source, place, Vec2(0.5F)).irradiance;
    Rgb sum(0.0F);
    for (unsigned i = 0; i < unoccludedSamples; ++i) {
        const auto n = static_cast<float>(i);
        // R2 sequence: even in the square. Each with its opposite on a sphere, so that first-order terms cancel.
        const Vec2 u = glm::fract(Vec2(0.5F) + n * Vec2(0.7548776662F, 0.5698402910F));
        const Vec2 opposite(std::min(1.0F - u.x, 0.99999994F), glm::fract(u.y + 0.5F));
        sum += sample(source, place, u).irradiance + sample(source, place, opposite).irradiance;
    }
    return sum / static_cast<float>(2 * unoccludedSamples);
}

std::size_t Sources::bytes() const {
    return sources_.capacity() * sizeof(Source) + bounds_.capacity() * sizeof(SourceBound) +
           ranks_.capacity() * sizeof(std::uint32_t);
}

} // namespace pie::gather
