#pragma once
// Maps from the unit square to directions and surfaces: sample, pdf and inverse of each.
//
// All maps are continuous and preserve measure, so points that are well spread in the square stay so. They are accurate
// at the extremes: lengths stay within 2e-7 of one, and what lies close to a pole, an edge or a corner of the square
// comes back from the inverse with the precision of a float. Inverses are given for directions the map can produce.

#include "pie/core/vec.h"

#include <span>

namespace pie::sampling {

/// Uniform on the sphere; pdf 1/(4 pi).
[[nodiscard]] Vec3 uniformSphere(const Vec2& u);
[[nodiscard]] float uniformSpherePdf();
[[nodiscard]] Vec2 invertUniformSphere(const Vec3& direction);

/// Cosine-distributed about +z (pi-engine eq 3.10); pdf z/pi, 0 below the horizon.
[[nodiscard]] Vec3 cosineHemisphere(const Vec2& u);
/// The same for many, from u to directions in place: `x` and `y` hold u and become the direction's, `z` is added. To
/// the bit what single calls give, and several at a time.
void cosineHemispheres(std::span<float> x, std::span<float> y, std::span<float> z);
[[nodiscard]] float cosineHemispherePdf(const Vec3& direction);
[[nodiscard]] Vec2 invertCosineHemisphere(const Vec3& direction);

/// The same distribution by height and turn (eq 3.10 as it stands): u.x = 1 - z², u.y turns of the angle. Rings and
/// sectors of the square stay rings and sectors, where the map above keeps squares nearly square.
[[nodiscard]] Vec3 polarCosineHemisphere(const Vec2& u);
[[nodiscard]] Vec2 invertPolarCosineHemisphere(const Vec3& direction);

/// Uniform in the cone about +z with the given cosine of its half angle, -1 <= cosMax <= 1; pdf 1/(2 pi (1 - cosMax)),
/// infinite for cosMax = 1, where the only direction is +z.
[[nodiscard]] Vec3 uniformCone(const Vec2& u, float cosMax);
[[nodiscard]] float uniformConePdf(float cosMax);
[[nodiscard]] Vec2 invertUniformCone(const Vec3& direction, float cosMax);

/// Uniform in the unit disc (concentric: Shirley and Chiu 1997); pdf 1/pi.
[[nodiscard]] Vec2 concentricDisc(const Vec2& u);
[[nodiscard]] float concentricDiscPdf();
[[nodiscard]] Vec2 invertConcentricDisc(const Vec2& point);

/// Uniform on a triangle: barycentric weights of corner 1 and 2 (Heitz 2019, "A low-distortion map between triangle and
/// square"); pdf 2 with respect to the weights, 1/area on the triangle.
[[nodiscard]] Vec2 uniformTriangle(const Vec2& u);
[[nodiscard]] Vec2 invertUniformTriangle(const Vec2& weights);

} // namespace pie::sampling
