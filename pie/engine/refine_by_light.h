#pragma once
// The drawn mesh refined where its direct light changes: scene::adapt with light for a value. Direct light is the part
// that has sharp edges; indirect light is smooth, and what is right for the one is more than enough for the other.
//
// Light is taken as DirectLight takes it, with fewer rays than receivers get later: whether an edge is split needs no
// more than refine_error. Of a frame's parts this needs scene, lights and intersector, and comes before receivers.

#include "pie/engine/settings.h"
#include "pie/intersect/intersector.h"
#include "pie/level/level.h"
#include "pie/lights/light_set.h"
#include "pie/scene/adapt.h"

#include <stop_token>

namespace pie::engine {

/// max_edge, refine_error, max_vertices and the rest of Geometry as scene::adapt wants them.
[[nodiscard]] scene::AdaptOptions adaptOptions(const Settings& settings);

/// `mesh` is the level's, see scene::makeMesh; scene and intersector are made of the same level.
scene::AdaptStatistics refineByLight(scene::Mesh& mesh, const level::Level& level, const scene::Scene& scene,
                                     const lights::LightSet& lights, const intersect::Intersector& intersector,
                                     const scene::AdaptOptions& options, std::uint64_t seed = 0);

} // namespace pie::engine
