#pragma once
// One set of settings on the level: an engine is made, frames run as in a viewer whose camera stands still, and each
// is compared with the truth.
//
// Frames: advance(), then irradiance() of everything in view. First until everything is refined and the picture is
// within 5 %, with eight frames of photons in reserve; then what is left is refined at once; then the reserve, whose
// median is the time of a frame; then the rest of the photons, for the error at the end.

#include "apps/pietrade/accuracy.h"
#include "apps/pietrade/measurement.h"
#include "apps/pietrade/sample.h"
#include "apps/pietrade/view.h"
#include "pie/engine/settings.h"
#include "pie/level/level.h"

#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace pietrade {

/// What all measurements share.
struct Scenery {
    std::shared_ptr<const pie::level::Level> level;
    std::optional<Camera> camera;
    Sample sample;
    std::vector<Truth> vertexTruth; ///< of the sample's vertices
    std::vector<Truth> pointTruth;  ///< of its points
    double loadMs = 0;              ///< from the file on disk to the level in memory
    bool processorTime = false;     ///< times are of the processor, all threads together, not by the clock on the wall
    std::size_t mostFrames = 1000;  ///< of photons
};

/// `base`: the settings that the sample was drawn with. None when `stop` said so.
[[nodiscard]] std::optional<Measurement> measure(const Scenery& scenery, const pie::engine::Settings& base,
                                                 const pie::engine::Settings& settings,
                                                 const std::function<bool()>& stop);

} // namespace pietrade
