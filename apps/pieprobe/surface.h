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
/// How far from borders of their surface rays start, units: 1 for the engine, as at vertices of a level; an eighth for
/// the reference, which is to answer at the point itself. Less in small scenes.
[[nodiscard]] double insetFor(const pie::scene::Scene& scene, bool reference);
/// The nearest surface within `tolerance` that faces the normal. Light is asked for at the point itself, or on the
/// surface where the point lies behind it; rays start at least `inset` away from borders of the surface, where it goes.
[[nodiscard]] std::vector<Placed> place(const pie::scene::Scene& scene, const std::vector<Point>& points,
                                        double tolerance, double inset);

} // namespace pieprobe
