#include "pie/sampling/directions.h"

#include "pie/sampling/hash.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace pie::sampling {
namespace {

constexpr float pi = std::numbers::pi_v<float>;

/// Without a branch: which of the two is wanted is a coin toss here, and a wrong guess costs more than all the rest.
float choose(bool first, float a, float b) {
    const std::uint32_t mask = first ? ~0U : 0U;
    return std::bit_cast<float>((std::bit_cast<std::uint32_t>(a) & mask) | (std::bit_cast<std::uint32_t>(b) & ~mask));
}

struct SinCos {
    float sine, cosine;
};

/// For |x| <= pi/4 (minimax polynomials of the Cephes library, error below 1e-7): no range reduction, so cheaper than
/// the C library, and the tracer needs one a bounce.
SinCos sinCosQuarter(float x) {
    const float y = x * x;
    const float sine = x + x * y * (-1.6666654611e-1F + y * (8.3321608736e-3F - y * 1.9515295891e-4F));
    const float cosine =
        1.0F - 0.5F * y + y * y * (4.166664568298827e-2F + y * (-1.388731625493765e-3F + y * 2.443315711809948e-5F));
    return {sine, cosine};
}

/// Of the angle 2 pi u, 0 <= u < 1.
SinCos sinCosTurn(float u) {
    const float quarters = u * 4.0F;
    const auto quadrant = static_cast<std::uint32_t>(0.5F * (2.0F * quarters + 1.0F)); // the nearest, u being positive
    const SinCos s = sinCosQuarter((quarters - static_cast<float>(quadrant)) * (0.5F * pi));
    const bool odd = (quadrant & 1U) != 0;
    const auto negated = [](float x, std::uint32_t if1) {
        return std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) ^ (if1 << 31U));
    };
    return {negated(choose(odd, s.cosine, s.sine), quadrant >> 1U & 1U),
            negated(choose(odd, s.sine, s.cosine), (quadrant + 1) >> 1U & 1U)};
}

float clampToUnit(float u) { return std::clamp(u, 0.0F, belowOne); }

/// Turns of the vector's angle, in [0, 1).
float turn(float x, float y) {
    const float t = std::atan2(y, x) * (0.5F / pi);
    return clampToUnit(t < 0.0F ? t + 1.0F : t);
}

/// `v` is 1 - z: computing with it keeps the precision that z loses near the pole.
Vec3 fromCap(float v, float angle) {
    const float radius = std::sqrt(std::max(0.0F, v * (2.0F - v)));
    const SinCos s = sinCosTurn(angle);
    return {radius * s.cosine, radius * s.sine, 1.0F - v};
}
float capOf(const Vec3& d) { return d.z > 0.0F ? (d.x * d.x + d.y * d.y) / (1.0F + d.z) : 1.0F - d.z; }

inline Vec2 discPoint(const Vec2& u) {
    const Vec2 s = 2.0F * u - 1.0F;
    const bool wide = std::abs(s.x) > std::abs(s.y);
    const float radius = choose(wide, s.x, s.y);
    const float across = choose(wide, s.y, s.x);
    // In the centre both are 0: any divisor will do.
    const SinCos t = sinCosQuarter(0.25F * pi * (across / choose(radius != 0.0F, radius, 1.0F)));
    const float along = radius * t.cosine;
    const float aside = radius * t.sine;
    return {choose(wide, along, aside), choose(wide, aside, along)};
}

inline Vec3 cosineDirection(const Vec2& u) {
    // Malley: a uniform disc lifted onto the sphere. The way from the disc's rim is that from the rim of the square,
    // which u gives without the cancellation of 1 - r².
    const Vec2 disc = discPoint(u);
    const float rim = 2.0F * std::min(std::min(u.x, 1.0F - u.x), std::min(u.y, 1.0F - u.y));
    return {disc.x, disc.y, std::sqrt(rim * (2.0F - rim))};
}

} // namespace

Vec3 uniformSphere(const Vec2& u) {
    // From the nearer pole, so that both poles are resolved alike.
    if (u.x <= 0.5F) return fromCap(2.0F * u.x, u.y);
    Vec3 d = fromCap(2.0F * (1.0F - u.x), u.y);
    d.z = -d.z;
    return d;
}
float uniformSpherePdf() { return 0.25F / pi; }
Vec2 invertUniformSphere(const Vec3& direction) {
    const float upper = 0.5F * capOf({direction.x, direction.y, std::abs(direction.z)});
    return {clampToUnit(direction.z >= 0.0F ? upper : 1.0F - upper), turn(direction.x, direction.y)};
}

Vec3 cosineHemisphere(const Vec2& u) { return cosineDirection(u); }
void cosineHemispheres(std::span<float> x, std::span<float> y, std::span<float> z) {
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec3 direction = cosineDirection({x[i], y[i]});
        x[i] = direction.x;
        y[i] = direction.y;
        z[i] = direction.z;
    }
}
float cosineHemispherePdf(const Vec3& direction) { return std::max(0.0F, direction.z) * (1.0F / pi); }
Vec2 invertCosineHemisphere(const Vec3& direction) {
    Vec2 u = invertConcentricDisc({direction.x, direction.y});
    const float radius = std::min(1.0F, glm::length(Vec2(direction.x, direction.y)));
    const float rim = 0.5F * direction.z * direction.z / (1.0F + radius);
    const int major = std::abs(direction.x) > std::abs(direction.y) ? 0 : 1;
    u[major] = clampToUnit(direction[major] < 0.0F ? rim : 1.0F - rim);
    return u;
}

Vec3 polarCosineHemisphere(const Vec2& u) {
    const float radius = std::sqrt(u.x);
    const SinCos s = sinCosTurn(u.y);
    return {radius * s.cosine, radius * s.sine, std::sqrt(1.0F - u.x)};
}
Vec2 invertPolarCosineHemisphere(const Vec3& direction) {
    const float square = direction.x * direction.x + direction.y * direction.y;
    return {clampToUnit(direction.z * direction.z < 0.5F ? 1.0F - direction.z * direction.z : square),
            turn(direction.x, direction.y)};
}

Vec3 uniformCone(const Vec2& u, float cosMax) { return fromCap(u.x * (1.0F - cosMax), u.y); }
float uniformConePdf(float cosMax) {
    return cosMax < 1.0F ? 0.5F / (pi * (1.0F - cosMax)) : std::numeric_limits<float>::infinity();
}
Vec2 invertUniformCone(const Vec3& direction, float cosMax) {
    const float height = 1.0F - cosMax;
    return {height > 0.0F ? clampToUnit(capOf(direction) / height) : 0.0F, turn(direction.x, direction.y)};
}

Vec2 concentricDisc(const Vec2& u) { return discPoint(u); }
float concentricDiscPdf() { return 1.0F / pi; }
Vec2 invertConcentricDisc(const Vec2& point) {
    const float radius = glm::length(point);
    Vec2 s(0.0F);
    if (std::abs(point.x) > std::abs(point.y)) {
        s.x = std::copysign(radius, point.x);
        s.y = s.x * std::atan(point.y / point.x) * (4.0F / pi);
    } else if (point.y != 0.0F) {
        s.y = std::copysign(radius, point.y);
        s.x = s.y * std::atan(point.x / point.y) * (4.0F / pi);
    }
    return {clampToUnit(0.5F * (s.x + 1.0F)), clampToUnit(0.5F * (s.y + 1.0F))};
}

Vec2 uniformTriangle(const Vec2& u) {
    const float half = 0.5F * std::min(u.x, u.y);
    const float rest = std::max(u.x, u.y) - half;
    const bool upper = u.y > u.x;
    return {choose(upper, half, rest), choose(upper, rest, half)};
}
Vec2 invertUniformTriangle(const Vec2& weights) {
    const float sum = weights.x + weights.y;
    return weights.y > weights.x ? Vec2(clampToUnit(2.0F * weights.x), clampToUnit(sum))
                                 : Vec2(clampToUnit(sum), clampToUnit(2.0F * weights.y));
}

} // namespace pie::sampling
