#pragma once
// From points to receivers: the surface below each.

#include "apps/pieprobe/points.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <string>
#include <vector>

namespace pieprobe {

/// How far from its surface a point may lie by default, units: a 512th of the scene's diagonal, 2 at most, but what
/// floats can tell in far scenes.
[[nodiscard]] double defaultTolerance(const pie::scene::Scene& scene);

struct Placed {
    Status status = Status::Ok;
    std::string problem; ///< of a point that has no receiver, one line
    pie::scene::Receiver receiver;
};
/// The nearest surface within `tolerance` that faces the normal. Light is asked for at the point itself, or on the
/// surface where the point lies behind it; rays start beside borders of the surface, as at vertices of a level.
[[nodiscard]] std::vector<Placed> place(const pie::scene::Scene& scene, const std::vector<Point>& points,
                                        double tolerance);

} // namespace pieprobe
