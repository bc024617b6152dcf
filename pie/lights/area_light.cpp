// Lambertian polygons.
//
// The receiver's share is sampled by solid angle: the polygon is clipped at the receiver's horizon and cut into a fan
// of spherical triangles, one is chosen in proportion to its exact form factor (Lambert's formula), and within it a
// direction is drawn uniformly by solid angle (Arvo 1995) through a bilinear warp towards the larger cosines. The mean
// over u is the exact unoccluded irradiance, and single samples deviate little from it, so that what noise remains is
// that of visibility. Where the polygon is small against its distance, plain area sampling does as well for less.

#include "pie/lights/kinds.h"
#include "pie/sampling/directions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pie::lights {
namespace {

using glm::dvec3;

constexpr double pi = std::numbers::pi;
constexpr double belowOne = 1.0 - 1e-12;
constexpr double farRatio = 0.1;       // extent over distance below which a polygon is sampled by area
constexpr std::size_t maxCorners = 32; // with more it is sampled by area at any distance
constexpr double widestEdge = pi / 3;  // as the receiver sees it; wider ones are cut, or the warp would fit them badly
constexpr std::size_t maxDirections = maxCorners + 10; // clipping adds 1, cutting 6: a convex outline is at most a turn

dvec3 newell(const std::vector<Vec3>& corners) {
    dvec3 sum(0.0);
    for (std::size_t i = 1; i + 1 < corners.size(); ++i)
        sum += glm::cross(dvec3(corners[i]) - dvec3(corners[0]), dvec3(corners[i + 1]) - dvec3(corners[0]));
    return 0.5 * sum;
}

/// Chooses among weights by `u` and leaves in `u` what remains, uniform in [0, 1) again.
template <class Weight> std::size_t choose(std::size_t count, double total, double& u, const Weight& weight) {
    double rest = u * total;
    for (std::size_t i = 0; i < count; ++i) {
        const double w = weight(i);
        if (w > 0.0 && (rest < w || i + 1 == count)) {
            u = std::clamp(rest / w, 0.0, belowOne);
            return i;
        }
        rest -= w;
    }
    u = belowOne; // rounding ran past the end: the last piece that counts
    for (std::size_t i = count; i-- > 0;)
        if (weight(i) > 0.0) return i;
    return 0;
}

double fanArea(const AreaLight& light, std::size_t i) {
    const dvec3 a(light.corners[0]);
    return 0.5 * glm::length(glm::cross(dvec3(light.corners[i + 1]) - a, dvec3(light.corners[i + 2]) - a));
}

/// Uniform on the polygon.
dvec3 pointOn(const AreaLight& light, double u, double v) {
    const std::size_t i =
        choose(light.corners.size() - 2, light.area, u, [&](std::size_t k) { return fanArea(light, k); });
    const Vec2 w = sampling::uniformTriangle({static_cast<float>(u * (1.0 - 1e-7)), static_cast<float>(v)});
    const dvec3 a(light.corners[0]);
    return a + static_cast<double>(w.x) * (dvec3(light.corners[i + 1]) - a) +
           static_cast<double>(w.y) * (dvec3(light.corners[i + 2]) - a);
}

bool usable(const AreaLight& light) {
    return light.corners.size() >= 3 && light.area > 0.0 && std::isfinite(light.area);
}

/// Part of a polygon above a receiver's horizon: unit directions, counter-clockwise as the receiver sees them.
struct Visible {
    std::array<dvec3, maxDirections> directions;
    std::size_t count = 0;
    dvec3 middle{0.0};                         ///< that the triangles share
    std::array<double, maxDirections> share{}; ///< π × form factor of the triangle of directions i and i + 1
    double total = 0.0;

    /// Adds a corner, and directions on the arc to it from the last one if that is wide.
    void add(const dvec3& to) {
        if (count > 0) {
            const dvec3 from = directions[count - 1];
            const dvec3 side = to - from * glm::dot(from, to);
            const double sine = glm::length(side);
            const double angle = std::atan2(sine, glm::dot(from, to));
            const auto pieces = static_cast<int>(std::ceil(angle / widestEdge));
            for (int i = 1; i < pieces && sine > 0.0 && count + 1 < maxDirections; ++i) {
                const double part = angle * i / pieces;
                directions[count++] = from * std::cos(part) + side * (std::sin(part) / sine);
            }
        }
        if (count < maxDirections) directions[count++] = to;
    }
};

/// π × the form factor of one spherical triangle above the horizon (Lambert).
double projectedSolidAngle(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& normal) {
    const auto edge = [&](const dvec3& p, const dvec3& q) {
        const dvec3 across = glm::cross(p, q);
        const double sine = glm::length(across);
        return sine > 0.0 ? std::atan2(sine, glm::dot(p, q)) / sine * glm::dot(across, normal) : 0.0;
    };
    return std::max(0.0, 0.5 * (edge(a, b) + edge(b, c) + edge(c, a)));
}

void clip(const AreaLight& light, const dvec3& point, const dvec3& normal, bool reversed, Visible& visible) {
    const std::size_t n = light.corners.size();
    const auto corner = [&](std::size_t i) { return dvec3(light.corners[reversed ? n - 1 - i % n : i % n]) - point; };
    dvec3 start(0.0);
    const auto add = [&](const dvec3& v) {
        const double length = glm::length(v);
        if (!(length > 0.0)) return;
        if (visible.count == 0) start = v / length;
        visible.add(v / length);
    };
    for (std::size_t i = 0; i < n; ++i) {
        const dvec3 a = corner(i);
        const dvec3 b = corner(i + 1);
        const double ha = glm::dot(a, normal);
        const double hb = glm::dot(b, normal);
        if (ha >= 0.0) add(a);
        if ((ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0)) add(a + (b - a) * (ha / (ha - hb)));
    }
    if (visible.count < 3) {
        visible.count = 0;
        return;
    }
    visible.add(start); // closes the outline, cut if wide
    --visible.count;
    const auto next = [&](std::size_t i) { return visible.directions[i + 1 < visible.count ? i + 1 : 0]; };
    bool overhead = true;
    dvec3 sum(0.0);
    for (std::size_t i = 0; i < visible.count; ++i) {
        overhead = overhead && glm::dot(glm::cross(visible.directions[i], next(i)), normal) > 0.0;
        sum += visible.directions[i];
    }
    visible.middle = overhead ? normal : glm::normalize(sum);
    for (std::size_t i = 0; i < visible.count; ++i) {
        visible.share[i] = projectedSolidAngle(visible.directions[i], next(i), visible.middle, normal);
        visible.total += visible.share[i];
    }
}

struct DirectionSample {
    dvec3 direction{0.0};
    double solidAngle = 0.0;
};

double angleBetween(const dvec3& a, const dvec3& b) { return 2.0 * std::atan2(glm::length(a - b), glm::length(a + b)); }

/// Uniform by solid angle on the spherical triangle a b c (Arvo 1995). At v = 0 the point is b, at v = 1 it runs from a
/// (u = 0) to c.
DirectionSample sampleSphericalTriangle(const dvec3& a, const dvec3& b, const dvec3& c, double u, double v) {
    dvec3 ab = glm::cross(a, b);
    dvec3 bc = glm::cross(b, c);
    dvec3 ca = glm::cross(c, a);
    const double lengths = std::min({glm::length(ab), glm::length(bc), glm::length(ca)});
    if (!(lengths > 0.0)) return {};
    ab = glm::normalize(ab);
    bc = glm::normalize(bc);
    ca = glm::normalize(ca);
    const double alpha = angleBetween(ab, -ca);
    const double beta = angleBetween(bc, -ab);
    const double gamma = angleBetween(ca, -bc);
    const double area = alpha + beta + gamma - pi;
    if (!(area > 0.0)) return {};

    const double sub = pi + u * area; // angles of the sub-triangle a b c' add up to this
    const double cosAlpha = std::cos(alpha);
    const double sinAlpha = std::sin(alpha);
    const double sinPhi = std::sin(sub) * cosAlpha - std::cos(sub) * sinAlpha;
    const double cosPhi = std::cos(sub) * cosAlpha + std::sin(sub) * sinAlpha;
    const double k1 = cosPhi + cosAlpha;
    const double k2 = sinPhi - sinAlpha * glm::dot(a, b);
    double cosB = (k2 + (k2 * cosPhi - k1 * sinPhi) * cosAlpha) / ((k2 * sinPhi + k1 * cosPhi) * sinAlpha);
    cosB = std::isfinite(cosB) ? std::clamp(cosB, -1.0, 1.0) : 1.0;
    const double sinB = std::sqrt(1.0 - cosB * cosB);
    const dvec3 inCa = c - a * glm::dot(a, c);
    const dvec3 cPrime = a * cosB + glm::normalize(inCa) * sinB;
    // 1 - cos along the arc from b, without cancellation for small arcs
    const dvec3 chord = cPrime - b;
    const double cap = v * 0.5 * glm::dot(chord, chord);
    const dvec3 across = cPrime - b * glm::dot(cPrime, b);
    const double acrossLength = glm::length(across);
    if (!(acrossLength > 0.0)) return {b, area};
    return {glm::normalize(b * (1.0 - cap) + across * (std::sqrt(std::max(0.0, cap * (2.0 - cap))) / acrossLength)),
            area};
}

/// Linear density on [0, 1] from weight a to weight b.
double sampleLinear(double u, double a, double b) {
    if (a + b <= 0.0) return u;
    const double x = u * (a + b) / (a + std::sqrt((1.0 - u) * a * a + u * b * b));
    return std::clamp(x, 0.0, 1.0);
}

/// Way s from a triangle's corner of weight `corner` to the opposite edge of mean weight `edge`, for a weight linear on
/// the triangle: density 2 s ((1 - s) corner + s edge) over its integral.
double sampleFromCorner(double u, double corner, double edge) {
    const double whole = (corner + 2.0 * edge) / 3.0;
    if (!(whole > 0.0)) return std::sqrt(u);
    const double cubic = 2.0 / 3.0 * (edge - corner);
    double s = std::sqrt(u);
    for (int i = 0; i < 30; ++i) {
        const double slope = 2.0 * s * (corner + s * (edge - corner));
        if (!(slope > 0.0)) break;
        const double step = (s * s * (corner + s * cubic) - u * whole) / slope;
        s = std::clamp(s - step, 0.0, 1.0);
        if (std::abs(step) < 1e-12) break;
    }
    return s;
}

Illumination sampleByArea(const AreaLight& light, const Vec3& point, const Vec3& normal, bool twoSided, const Vec2& u) {
    const dvec3 way = pointOn(light, u.x, u.y) - dvec3(point);
    const double distance = glm::length(way);
    if (!(distance > 0.0)) return {};
    const dvec3 towards = way / distance;
    double cosine = glm::dot(towards, dvec3(normal));
    cosine = twoSided ? std::abs(cosine) : std::max(0.0, cosine);
    double emitted = -glm::dot(towards, dvec3(light.normal));
    emitted = light.twoSided ? std::abs(emitted) : std::max(0.0, emitted);
    Illumination result;
    result.towards = Vec3(towards);
    result.distance = static_cast<float>(distance);
    result.irradiance = detail::scaled(light.radiosity, light.area * cosine * emitted / (pi * distance * distance));
    return result;
}

Illumination sampleBySolidAngle(const AreaLight& light, const dvec3& point, const dvec3& normal, bool twoSided,
                                bool reversed, const Vec2& sample) {
    double u = sample.x;
    double v = sample.y;
    std::array<Visible, 2> sides;
    clip(light, point, normal, reversed, sides[0]);
    if (twoSided) clip(light, point, -normal, reversed, sides[1]);
    const double both = sides[0].total + sides[1].total;
    if (!(both > 0.0)) return {};
    const Visible& side = sides[choose(2, both, u, [&](std::size_t i) { return sides[i].total; })];
    const std::size_t first = choose(side.count, side.total, u, [&](std::size_t i) { return side.share[i]; });
    const double chance = side.share[first] / both;

    const dvec3& a = side.directions[first];
    const dvec3& b = side.middle;
    const dvec3& c = side.directions[first + 1 < side.count ? first + 1 : 0];
    // Cosines at the corners, never quite zero: the density must cover the triangle.
    const auto cosine = [&](const dvec3& direction) { return std::abs(glm::dot(direction, normal)); };
    const double floor = 0.05 * std::max({cosine(a), cosine(b), cosine(c)});
    const double wa = std::max(floor, cosine(a));
    const double wb = std::max(floor, cosine(b));
    const double wc = std::max(floor, cosine(c));
    const double s = sampleFromCorner(v, wb, 0.5 * (wa + wc));
    const double left = wb + (wa - wb) * s;
    const double right = wb + (wc - wb) * s;
    u = sampleLinear(u, left, right);
    const double density = (left + (right - left) * u) * 3.0 / (wa + wb + wc);

    const DirectionSample drawn = sampleSphericalTriangle(a, b, c, u, s * s);
    const double down = glm::dot(drawn.direction, dvec3(light.normal));
    const double height = glm::dot(dvec3(light.corners[0]) - point, dvec3(light.normal));
    Illumination result;
    if (!(drawn.solidAngle > 0.0) || down == 0.0 || !(height / down > 0.0)) return result;
    result.towards = Vec3(drawn.direction);
    result.distance = static_cast<float>(height / down);
    result.irradiance = detail::scaled(light.radiosity, drawn.solidAngle * std::abs(glm::dot(drawn.direction, normal)) /
                                                            (pi * density * chance));
    return result;
}

} // namespace

AreaLight makeAreaLight(std::vector<Vec3> corners, const Rgb& radiosity, bool twoSided, std::uint32_t surface) {
    AreaLight light;
    const dvec3 sum = corners.size() >= 3 ? newell(corners) : dvec3(0.0);
    light.area = glm::length(sum);
    if (light.area > 0.0) light.normal = Vec3(sum / light.area);
    light.corners = std::move(corners);
    light.radiosity = radiosity;
    light.twoSided = twoSided;
    light.surface = surface;
    return light;
}

namespace detail {

Rgb areaPower(const AreaLight& light) {
    return usable(light) ? scaled(light.radiosity, light.area * (light.twoSided ? 2.0 : 1.0)) : Rgb(0.0F);
}

Emission emitArea(const AreaLight& light, const Box& bounds, const std::array<float, 4>& u) {
    Emission result;
    if (!usable(light)) return result;
    double place = u[2];
    Vec3 normal = light.normal;
    if (light.twoSided && choose(2, 2.0, place, [](std::size_t) { return 1.0; }) == 1) normal = -normal;
    const Vec3 point(pointOn(light, place, u[3]));
    result.origin = point + surfaceOffset(largestCoordinate(bounds, point)) * normal;
    result.direction = Frame(normal).toWorld(sampling::cosineHemisphere({u[0], u[1]}));
    result.flux = areaPower(light);
    return result;
}

Illumination illuminateArea(const AreaLight& light, const Vec3& point, const Vec3& normal, bool twoSided,
                            const Vec2& u) {
    if (!usable(light)) return {};
    dvec3 centre(0.0);
    for (const Vec3& corner : light.corners) centre += dvec3(corner);
    centre /= static_cast<double>(light.corners.size());
    double extent = 0.0;
    for (const Vec3& corner : light.corners) extent = std::max(extent, glm::length(dvec3(corner) - centre));
    const double height = glm::dot(dvec3(point) - centre, dvec3(light.normal));
    // In the light's own plane nothing arrives; the test leaves room for the rounding of the coordinates.
    const bool behind = height < 0.0;
    if (std::abs(height) <= 1e-7 * (extent + glm::length(dvec3(point))) || (behind && !light.twoSided)) return {};
    if (light.corners.size() > maxCorners || extent < farRatio * glm::length(dvec3(point) - centre))
        return sampleByArea(light, point, normal, twoSided, u);
    // Seen from its lit side a polygon turns counter-clockwise about its normal; Lambert's sum is positive for the
    // order in which a receiver below it, looking up, sees it turn: the reverse.
    return sampleBySolidAngle(light, dvec3(point), dvec3(normal), twoSided, !behind, u);
}

} // namespace detail
} // namespace pie::lights
