#pragma once
// Maps from the unit square to directions and surfaces: sample, pdf and inverse of each.

#include "pie/core/vec.h"

namespace pie::sampling {

/// Uniform on the sphere; pdf 1/(4 pi).
[[nodiscard]] Vec3 uniformSphere(const Vec2& u);
[[nodiscard]] float uniformSpherePdf();
[[nodiscard]] Vec2 invertUniformSphere(const Vec3& direction);

/// Cosine-distributed about +z (pi-engine eq 3.10); pdf z/pi.
[[nodiscard]] Vec3 cosineHemisphere(const Vec2& u);
[[nodiscard]] float cosineHemispherePdf(const Vec3& direction);
[[nodiscard]] Vec2 invertCosineHemisphere(const Vec3& direction);

/// Uniform in the cone about +z with the given cosine of its half angle; pdf 1/(2 pi (1 - cosMax)).
[[nodiscard]] Vec3 uniformCone(const Vec2& u, float cosMax);
[[nodiscard]] float uniformConePdf(float cosMax);
[[nodiscard]] Vec2 invertUniformCone(const Vec3& direction, float cosMax);

/// Uniform in the unit disc (concentric); pdf 1/pi.
[[nodiscard]] Vec2 concentricDisc(const Vec2& u);
/// Uniform on a triangle: barycentric weights of corner 1 and 2.
[[nodiscard]] Vec2 uniformTriangle(const Vec2& u);

} // namespace pie::sampling
