#include "apps/pietrade/truth.h"

#include "pie/intersect/intersector.h"
#include "pie/reference/path_tracer.h"

#include <algorithm>

namespace pietrade {

void traceTruth(const std::shared_ptr<const pie::scene::Scene>& scene, std::span<const pie::lights::Light> lights,
                const pie::level::Tree& tree, const pie::engine::Settings& settings, const TruthOptions& options,
                std::span<const pie::scene::Receiver> where, std::vector<Truth>& known,
                const std::function<bool()>& kept) {
    if (known.size() >= where.size()) return;
    const auto intersector = pie::intersect::makeIntersector(settings.intersector, *scene, tree);
    pie::reference::Options tracing;
    tracing.target = options.target;
    tracing.mostPaths = options.mostPaths;
    // Not the photons' seed: what they have in common with the truth would not count as error.
    tracing.seed = settings.seed + 0x5452U;
    if (settings.origin("recursion_depth") != pie::engine::Source::Default)
        tracing.recursionDepth = static_cast<std::uint32_t>(settings.recursionDepth);
    const pie::reference::PathTracer tracer(scene, lights, *intersector, tracing);
    constexpr std::size_t piece = 16;
    while (known.size() < where.size()) {
        const auto some = where.subspan(known.size(), std::min(piece, where.size() - known.size()));
        std::vector<pie::reference::Value> values(some.size());
        tracer.trace(some, values);
        for (const pie::reference::Value& v : values)
            known.push_back({(v.irradiance.x + v.irradiance.y + v.irradiance.z) / 3, v.meanError});
        if (!kept()) return;
    }
}

} // namespace pietrade
