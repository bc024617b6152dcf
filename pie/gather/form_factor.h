#pragma once
// Exact unoccluded irradiance of a Lambertian polygon: Lambert's formula, after clipping by the receiver's horizon.

#include "pie/core/vec.h"

#include <span>

namespace pie::gather {

/// Share F of the polygon's radiosity that arrives at `point` on the side of `normal`: E = B F, 0 to 1. The polygon is
/// convex and planar; which way it faces does not matter here.
[[nodiscard]] double formFactor(std::span<const Vec3> corners, const Vec3& point, const Vec3& normal);

} // namespace pie::gather
