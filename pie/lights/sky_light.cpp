// Sun and sky: parallel light that enters through the sky triangles of the scene.

#include "pie/lights/kinds.h"
#include "pie/sampling/directions.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace pie::lights {
namespace {

constexpr float sameOrientation = 1e-6F; // difference of unit normals, per channel

double triangleArea(const scene::Scene& scene, std::uint32_t triangle) {
    const glm::dvec3 a(scene.corner(triangle, 0));
    return 0.5 * glm::length(
                     glm::cross(glm::dvec3(scene.corner(triangle, 1)) - a, glm::dvec3(scene.corner(triangle, 2)) - a));
}

/// Interleaved bits of the centroid, so that neighbours in the list are neighbours in space and a number in [0, 1)
/// that is well spread chooses places that are.
std::uint64_t morton(const scene::Scene& scene, std::uint32_t triangle) {
    const Vec3 centroid = (scene.corner(triangle, 0) + scene.corner(triangle, 1) + scene.corner(triangle, 2)) / 3.0F;
    const Vec3 size = glm::max(scene.bounds.size(), Vec3(std::numeric_limits<float>::min()));
    const Vec3 unit = glm::clamp((centroid - scene.bounds.lower) / size, 0.0F, 1.0F);
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto cell = static_cast<std::uint64_t>(unit[axis] * 2047.0F);
        for (unsigned bit = 0; bit < 11; ++bit) code |= (cell >> bit & 1U) << (3 * bit + static_cast<unsigned>(axis));
    }
    return code;
}

bool orientationLess(const Vec3& a, const Vec3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

/// The disc of a sun as a cone about `towards`.
Vec3 deviated(const Vec3& towards, float devianceRadians, const Vec2& u) {
    if (!(devianceRadians > 0.0F)) return towards;
    return Frame(towards).toWorld(
        sampling::uniformCone(u, std::cos(std::min(devianceRadians, std::numbers::pi_v<float>))));
}

double facing(const SkyPortals::Group& group, const Vec3& towards) {
    // The sun stands behind the triangle: its light runs along the normal, which points into the level.
    return std::max(0.0, -glm::dot(glm::dvec3(group.normal), glm::dvec3(towards)));
}

} // namespace

SkyPortals skyPortals(const scene::Scene& scene) {
    SkyPortals portals;
    portals.bounds = scene.bounds;
    for (std::uint32_t i = 0; i < scene.triangles.size(); ++i)
        if (scene.material(i).interaction == scene::Interaction::Sky && triangleArea(scene, i) > 0.0)
            portals.triangles.push_back(i);

    // Orientations that differ by rounding only are one: snapped to a grid for sorting, then compared exactly.
    const auto snapped = [&](std::uint32_t i) { return glm::round(scene.normals[i] / (4.0F * sameOrientation)); };
    std::vector<std::pair<std::uint32_t, std::uint64_t>> order;
    for (const std::uint32_t triangle : portals.triangles) order.emplace_back(triangle, morton(scene, triangle));
    std::stable_sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
        const Vec3 na = snapped(a.first);
        const Vec3 nb = snapped(b.first);
        return na == nb ? a.second < b.second : orientationLess(na, nb);
    });
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        portals.triangles[i] = order[i].first;
        const Vec3 normal = scene.normals[order[i].first];
        if (portals.groups.empty() ||
            snapped(order[i].first) != snapped(portals.triangles[portals.groups.back().first]))
            portals.groups.push_back({normal, 0.0, i, 0});
        auto& group = portals.groups.back();
        group.area += triangleArea(scene, order[i].first);
        ++group.count;
        portals.cumulative.push_back(group.area);
    }
    for (const auto& group : portals.groups) {
        for (std::uint32_t i = group.first; i < group.first + group.count; ++i) portals.cumulative[i] /= group.area;
        portals.cumulative[group.first + group.count - 1] = 1.0;
    }
    return portals;
}

double projectedArea(const SkyPortals& portals, const Vec3& towards) {
    if (!detail::isUnit(towards)) return 0.0;
    double sum = 0.0;
    for (const auto& group : portals.groups) sum += group.area * facing(group, towards);
    return sum;
}

namespace detail {

Emission emitParallel(const Vec3& towards, const Rgb& irradiance, const scene::Scene& scene, const SkyPortals& portals,
                      const Vec2& u) {
    Emission result;
    result.direction = -towards;
    const double total = projectedArea(portals, towards);
    if (!(total > 0.0)) return result;
    // One number chooses group and triangle; what is left of it is uniform again and chooses the place.
    double rest = u.x * total;
    const SkyPortals::Group* chosen = nullptr;
    double weight = 0.0;
    for (const auto& group : portals.groups) {
        const double area = group.area * facing(group, towards);
        if (!(area > 0.0)) continue;
        if (chosen != nullptr) rest -= weight;
        chosen = &group;
        weight = area;
        if (rest < area) break;
    }
    double place = std::clamp(rest / weight, 0.0, 1.0 - 1e-12);
    const auto begin = portals.cumulative.begin() + chosen->first;
    const auto found = std::upper_bound(begin, begin + chosen->count - 1, place);
    const double before = found == begin ? 0.0 : *(found - 1);
    place = std::clamp((place - before) / std::max(*found - before, 1e-300), 0.0, 1.0 - 1e-7);
    const std::uint32_t triangle = portals.triangles[static_cast<std::size_t>(found - portals.cumulative.begin())];
    const Vec2 weights = sampling::uniformTriangle({static_cast<float>(place), u.y});
    const Vec3 a = scene.corner(triangle, 0);
    const Vec3 point = a + weights.x * (scene.corner(triangle, 1) - a) + weights.y * (scene.corner(triangle, 2) - a);
    result.origin = point + surfaceOffset(largestCoordinate(portals.bounds, point)) * scene.normals[triangle];
    result.flux = scaled(irradiance, total);
    return result;
}

Rgb sunPower(const SunLight& light, const SkyPortals& portals) {
    if (!isUnit(light.towards)) return Rgb(0.0F);
    if (!(light.devianceRadians > 0.0F)) return scaled(light.irradiance, projectedArea(portals, light.towards));
    constexpr unsigned samples = 1024;
    double sum = 0.0;
    for (unsigned i = 0; i < samples; ++i) {
        // A golden-ratio lattice over the disc; the integrand is smooth.
        const Vec2 u((static_cast<float>(i) + 0.5F) / samples,
                     static_cast<float>(i * 0.6180339887498949 - std::floor(i * 0.6180339887498949)));
        sum += projectedArea(portals, deviated(light.towards, light.devianceRadians, u));
    }
    return scaled(light.irradiance, sum / samples);
}
Emission emitSun(const SunLight& light, const scene::Scene& scene, const SkyPortals& portals,
                 const std::array<float, 4>& u) {
    if (!isUnit(light.towards)) return {};
    return emitParallel(deviated(light.towards, light.devianceRadians, {u[0], u[1]}), light.irradiance, scene, portals,
                        {u[2], u[3]});
}
Illumination illuminateSun(const SunLight& light, const Vec3& normal, bool twoSided, const Vec2& u) {
    Illumination result;
    if (!isUnit(light.towards)) return result;
    result.towards = deviated(light.towards, light.devianceRadians, u);
    const float cosine = glm::dot(result.towards, normal);
    result.distance = std::numeric_limits<float>::infinity();
    result.irradiance = light.irradiance * (twoSided ? std::abs(cosine) : std::max(0.0F, cosine));
    result.needsSky = true;
    return result;
}

Rgb skyPower(const SkyLight& light, const SkyPortals& portals) {
    double sum = 0.0;
    for (const Vec3& towards : light.towards) sum += projectedArea(portals, towards);
    return scaled(light.irradiance, sum);
}
Emission emitSky(const SkyLight& light, const scene::Scene& scene, const SkyPortals& portals,
                 const std::array<float, 4>& u) {
    // Directions in proportion to what they send in, so that all photons weigh the same.
    std::vector<double> cumulative;
    double total = 0.0;
    for (const Vec3& towards : light.towards) cumulative.push_back(total += projectedArea(portals, towards));
    if (!(total > 0.0)) return {};
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end() - 1, u[0] * total);
    Emission result = emitParallel(light.towards[static_cast<std::size_t>(found - cumulative.begin())],
                                   light.irradiance, scene, portals, {u[2], u[3]});
    result.flux = scaled(light.irradiance, total);
    return result;
}
Illumination illuminateSky(const SkyLight& light, const Vec3& normal, bool twoSided, const Vec2& u) {
    Illumination result;
    if (light.towards.empty()) return result;
    const auto count = static_cast<float>(light.towards.size());
    result.towards = light.towards[std::min(light.towards.size() - 1, static_cast<std::size_t>(u.x * count))];
    const float cosine = glm::dot(result.towards, normal);
    result.distance = std::numeric_limits<float>::infinity();
    result.irradiance = light.irradiance * (count * (twoSided ? std::abs(cosine) : std::max(0.0F, cosine)));
    result.needsSky = true;
    return result;
}

} // namespace detail
} // namespace pie::lights
