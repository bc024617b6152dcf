#include "pie/engine/refine_by_light.h"

#include "pie/gather/direct.h"
#include "pie/scene/receivers.h"
#include "pie/scene/takes_light.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace pie::engine {
namespace {

constexpr float coarserThanMaxEdge = 4;
constexpr float finerThanMaxEdge = 8;

/// Noise must stay below what splits an edge.
gather::DirectOptions roughly(float tolerance, std::uint64_t seed) {
    gather::DirectOptions options;
    options.tolerance = 0.05F;
    options.absoluteTolerance = 0.25F * tolerance;
    options.tailSamples = 16;
    options.softSamples = 16;
    options.softness = 1;
    options.seed = seed;
    return options;
}

} // namespace

scene::AdaptOptions adaptOptions(const Settings& settings) {
    scene::AdaptOptions options;
    options.coarseEdge = coarserThanMaxEdge * settings.maxEdge;
    options.smallestEdge = settings.maxEdge / finerThanMaxEdge;
    options.tolerance = settings.refineError;
    options.maxVertices = static_cast<std::size_t>(settings.maxVertices);
    options.maxTriangles = static_cast<std::size_t>(settings.maxTriangles);
    options.junctionTolerance = settings.tJunctionTolerance;
    return options;
}

scene::AdaptStatistics refineByLight(scene::Mesh& mesh, const level::Level& level, const scene::Scene& scene,
                                     const lights::LightSet& lights, const intersect::Intersector& intersector,
                                     const scene::AdaptOptions& options, std::uint64_t seed) {
    const gather::DirectOptions direct = roughly(options.tolerance, seed);
    const auto shaderOf = [&](std::uint32_t surface) -> const level::Shader* {
        if (surface >= level.surfaces.size() || level.surfaces[surface].shader >= level.shaders.size()) return nullptr;
        return &level.shaders[level.surfaces[surface].shader];
    };
    return scene::adapt(mesh, options, [&](std::span<const scene::SurfacePoint> points, std::span<float> values) {
        scene::Receivers receivers;
        std::vector<std::size_t> places; // of those that take light; the others stay as they are
        for (std::size_t i = 0; i < points.size(); ++i) {
            const level::Shader* const shader = shaderOf(points[i].surface);
            if (shader != nullptr && !scene::takesLight(*shader)) continue;
            places.push_back(i);
            receivers.points.push_back(
                {points[i].position, points[i].normal, points[i].inset, shader != nullptr && shader->twoSided()});
        }
        std::vector<std::uint32_t> which(places.size());
        std::iota(which.begin(), which.end(), 0U);
        std::vector<Rgb> light(places.size());
        const gather::DirectLight lamps(scene, lights, intersector, receivers, direct);
        lamps.estimate(which, light);
        std::fill(values.begin(), values.end(), 0.0F);
        for (std::size_t i = 0; i < places.size(); ++i) values[places[i]] = meanChannel(light[i]);
    });
}

} // namespace pie::engine
