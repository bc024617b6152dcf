#pragma once
// The reference: irradiance at the sample by path tracing, computed once and kept in the report folder.

#include "apps/pietrade/accuracy.h"
#include "apps/pietrade/sample.h"
#include "pie/engine/settings.h"
#include "pie/lights/light.h"
#include "pie/scene/scene.h"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace pietrade {

struct TruthOptions {
    double target = 0.02; ///< standard error of a point, relative
    std::uint64_t mostPaths = 65536;
};

/// Appends what is missing to `known`, in the order of `where`, in pieces; `kept` is told after each and says whether
/// to go on.
void traceTruth(const std::shared_ptr<const pie::scene::Scene>& scene, std::span<const pie::lights::Light> lights,
                const pie::level::Tree& tree, const pie::engine::Settings& settings, const TruthOptions& options,
                std::span<const pie::scene::Receiver> where, std::vector<Truth>& known,
                const std::function<bool()>& kept);

} // namespace pietrade
