#pragma once
// The level that is measured, and what says that it is the same as last time.

#include "apps/pietrade/kept.h"
#include "pie/core/result.h"
#include "pie/engine/settings.h"
#include "pie/level/level.h"
#include "pie/lights/light.h"
#include "pie/scene/scene.h"

#include <memory>
#include <string>
#include <vector>

namespace pietrade {

struct Subject {
    std::shared_ptr<const pie::level::Level> level;
    std::shared_ptr<const pie::scene::Scene> scene;
    std::vector<pie::lights::Light> lights;
    std::string lightSummary;
    double texelEdge = 0; ///< units, what texel_size = 0 means here
    double loadMs = 0, loadProcessorMs = 0;
};
[[nodiscard]] pie::Result<Subject> readSubject(const std::string& level, const pie::engine::Settings& settings);

/// Of what light meets and comes from, and of what is drawn: 16 hexadecimal digits.
[[nodiscard]] std::string contentHash(const Subject& subject, const pie::engine::Settings& settings);
/// Version, and a hash of this very program.
[[nodiscard]] std::string programVersion();
/// The processor and how many of it.
[[nodiscard]] std::string machine();

} // namespace pietrade
