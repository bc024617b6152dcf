// Point, sphere and spot lights, and the operations over all kinds.

#include "pie/lights/light.h"
#include "pie/lights/kinds.h"
#include "pie/sampling/directions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pie::lights {
namespace {

constexpr double fullSphere = 4.0 * std::numbers::pi;
constexpr float linearShare = 0.9375F;         // of an intensity, at distance 0 of a linear light
constexpr double endlessLinearReach = 1024.0;  // units over which a linear light that never fades is counted
constexpr double smallestArrivalCosine = 0.05; // bounds the weight of photons of lights without cosine
constexpr unsigned softSamples = 16;

template <class... Cases> struct Overloaded : Cases... { using Cases::operator()...; };
template <class... Cases> Overloaded(Cases...) -> Overloaded<Cases...>;

using detail::linearFlux;

/// Irradiance per unit of intensity (watts per steradian) at `distance` under `cosine`.
double share(const Falloff& falloff, double distance, double cosine) {
    if (cosine <= 0.0) return 0.0;
    const double extra = falloff.extraDistance;
    const double reach = std::max<double>(falloff.minDistance, std::sqrt(distance * distance + extra * extra));
    if (falloff.linear) {
        const double flux = linearFlux(falloff);
        const double left = linearShare * std::abs(static_cast<double>(falloff.linearIntensity)) - falloff.fade * reach;
        return flux > 0.0 ? std::max(0.0, left) * fullSphere / flux : 0.0;
    }
    if (reach <= 0.0) return 0.0;
    const double scale = falloff.angleScale > 0.0F ? falloff.angleScale : 1.0;
    return (falloff.noCosine ? 1.0 : std::min(1.0, cosine / scale)) / (reach * reach);
}

/// Of a point source at `source` that sends `intensity` watts per steradian towards the receiver.
Illumination fromPoint(const Vec3& source, const Rgb& power, const Falloff& falloff, const Vec3& point,
                       const Vec3& normal, bool twoSided) {
    const glm::dvec3 way = glm::dvec3(source) - glm::dvec3(point);
    const double distance = glm::length(way);
    if (!(distance > 0.0) || !std::isfinite(distance)) return {};
    const glm::dvec3 towards = way / distance;
    double cosine = glm::dot(towards, glm::dvec3(normal));
    if (twoSided) cosine = std::abs(cosine);
    Illumination result;
    result.towards = Vec3(towards);
    result.distance = static_cast<float>(distance);
    result.irradiance = detail::scaled(power, share(falloff, distance, cosine) / fullSphere);
    return result;
}

double spotCosine(const SpotLight& light) {
    const double slope = std::max(0.0F, light.slope);
    return 1.0 / std::sqrt(1.0 + slope * slope);
}
/// 1 − cos without the cancellation of narrow cones.
double spotCap(const SpotLight& light) {
    if (!detail::isUnit(light.direction)) return 0.0;
    const double slope = std::max(0.0F, light.slope);
    const double root = std::sqrt(1.0 + slope * slope);
    return slope * slope / (root * (root + 1.0));
}
/// Share of full intensity gained per unit of way from the light along a direction `cosine` off the axis; negative
/// outside the cone.
double rimRate(const SpotLight& light, double cosine) {
    if (cosine <= 0.0) return -1.0;
    const double inside = light.slope * cosine - std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    return light.rim > 0.0F ? inside / light.rim : (inside >= 0.0 ? std::numeric_limits<double>::infinity() : -1.0);
}

Emission emitSpot(const SpotLight& light, const std::array<float, 4>& u) {
    const Frame frame(light.direction);
    const Vec3 local = sampling::uniformCone({u[0], u[1]}, static_cast<float>(spotCosine(light)));
    Emission result;
    result.origin = light.position;
    result.direction = frame.toWorld(local);
    result.flux = detail::scaled(light.power, 0.5 * spotCap(light));
    result.falloff = &light.falloff;
    result.rimRate = static_cast<float>(std::max(0.0, rimRate(light, local.z)));
    return result;
}
Illumination illuminateSpot(const SpotLight& light, const Vec3& point, const Vec3& normal, bool twoSided) {
    if (!detail::isUnit(light.direction)) return {};
    Illumination result = fromPoint(light.position, light.power, light.falloff, point, normal, twoSided);
    const double rate = rimRate(light, -glm::dot(glm::dvec3(result.towards), glm::dvec3(light.direction)));
    result.irradiance = detail::scaled(result.irradiance, rate > 0.0 ? std::min(1.0, rate * result.distance) : 0.0);
    return result;
}

} // namespace

namespace detail {

Rgb scaled(const Rgb& colour, double factor) {
    return {static_cast<float>(colour.x * factor), static_cast<float>(colour.y * factor),
            static_cast<float>(colour.z * factor)};
}

double linearFlux(const Falloff& falloff) {
    const double i = linearShare * std::abs(static_cast<double>(falloff.linearIntensity));
    const double fade = falloff.fade;
    if (fade <= 0.0) return fullSphere * endlessLinearReach * endlessLinearReach * i;
    return fullSphere * (4.0 / 27.0) * i * i * i / (fade * fade);
}

} // namespace detail

float largestCoordinate(const Box& bounds, const Vec3& point) {
    Vec3 reach = glm::abs(point);
    if (!bounds.empty()) reach = glm::max(reach, glm::max(glm::abs(bounds.lower), glm::abs(bounds.upper)));
    return maxChannel(reach);
}

std::string_view kindName(const Light& light) {
    static constexpr std::array<std::string_view, 6> names{"point", "sphere", "spot", "sun", "area", "sky"};
    return names[light.index()];
}

Rgb power(const Light& light, const scene::Scene& /*scene*/, const SkyPortals& portals) {
    return std::visit(Overloaded{[](const PointLight& l) { return l.power; },
                                 [](const SphereLight& l) { return l.power; },
                                 [](const SpotLight& l) { return detail::scaled(l.power, 0.5 * spotCap(l)); },
                                 [&](const SunLight& l) { return detail::sunPower(l, portals); },
                                 [](const AreaLight& l) { return detail::areaPower(l); },
                                 [&](const SkyLight& l) { return detail::skyPower(l, portals); }},
                      light);
}

Emission emit(const Light& light, const scene::Scene& scene, const SkyPortals& portals, const std::array<float, 4>& u) {
    return std::visit(
        Overloaded{[&](const PointLight& l) {
                       return Emission{l.position, sampling::uniformSphere({u[0], u[1]}), l.power, &l.falloff};
                   },
                   [&](const SphereLight& l) {
                       return Emission{l.position + l.radius * sampling::uniformSphere({u[2], u[3]}),
                                       sampling::uniformSphere({u[0], u[1]}), l.power, &l.falloff};
                   },
                   [&](const SpotLight& l) { return emitSpot(l, u); },
                   [&](const SunLight& l) { return detail::emitSun(l, scene, portals, u); },
                   [&](const AreaLight& l) { return detail::emitArea(l, scene.bounds, u); },
                   [&](const SkyLight& l) { return detail::emitSky(l, scene, portals, u); }},
        light);
}

float arrivalFactor(const Emission& emission, float distance, float cosine) {
    double factor = 1.0;
    if (emission.rimRate < std::numeric_limits<float>::infinity())
        factor = std::min(1.0, static_cast<double>(emission.rimRate) * distance);
    const Falloff* f = emission.falloff;
    if (f == nullptr || !(distance < std::numeric_limits<float>::infinity())) return static_cast<float>(factor);
    const bool plainAngle = !f->noCosine && (f->angleScale == 1.0F || f->angleScale <= 0.0F);
    if (!f->linear && plainAngle && f->extraDistance == 0.0F && distance >= f->minDistance)
        return static_cast<float>(factor);
    const double d = distance;
    return static_cast<float>(factor * share(*f, d, cosine) * d * d / std::max<double>(cosine, smallestArrivalCosine));
}

Illumination illuminate(const Light& light, const Vec3& point, const Vec3& normal, bool twoSided, const Vec2& u) {
    return std::visit(
        Overloaded{
            [&](const PointLight& l) { return fromPoint(l.position, l.power, l.falloff, point, normal, twoSided); },
            [&](const SphereLight& l) {
                return fromPoint(l.position + l.radius * sampling::uniformSphere(u), l.power, l.falloff, point, normal,
                                 twoSided);
            },
            [&](const SpotLight& l) { return illuminateSpot(l, point, normal, twoSided); },
            [&](const SunLight& l) { return detail::illuminateSun(l, normal, twoSided, u); },
            [&](const AreaLight& l) { return detail::illuminateArea(l, point, normal, twoSided, u); },
            [&](const SkyLight& l) { return detail::illuminateSky(l, normal, twoSided, u); }},
        light);
}

unsigned sampleCount(const Light& light) {
    return std::visit(
        Overloaded{[](const PointLight&) { return 1U; }, [](const SphereLight&) { return softSamples; },
                   [](const SpotLight&) { return 1U; },
                   [](const SunLight& l) { return l.devianceRadians > 0.0F ? softSamples : 1U; },
                   [](const AreaLight&) { return softSamples; },
                   [](const SkyLight& l) { return std::max(1U, static_cast<unsigned>(l.towards.size())); }},
        light);
}

} // namespace pie::lights
