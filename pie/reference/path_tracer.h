#pragma once
// The oracle: irradiance by path tracing, unbiased, with a standard error. Slow, and simple enough to be believed;
// estimators are judged by it and share nothing with it but lights, scene and intersector.
//
// E at a receiver is its direct light plus the mean of ρ E over cosine-distributed directions, where E at what they hit
// is found the same way (Kajiya 1986): next event estimation with one light per vertex, Russian roulette, no limit to
// the depth. Light, filters and sky behave as PhotonTracer defines them: one-sided surfaces reflect on their front
// only, two-sided ones on the side that was hit, a filter lets its transmittance pass and reflects as if opaque with
// the rest, what meets the sky is gone; sun and sky come in through the fronts of sky surfaces. Irradiance of a
// receiver on a filter is what arrives, before the filter takes its share.
//
// A receiver is looked out of from its `inset`, lifted off the surface by an eighth of a unit, less in
// small scenes. Lights without extent that
// shine on it are taken exactly, one ray each.
//
// Each batch of paths is a randomly shifted Halton set (Owen 2003 on randomized quasi-Monte Carlo), batches are
// independent, and the standard error is that of their mean. Batches are added until it is below the target or the cap
// is reached. Same seed, same bits, on any number of threads; an answer depends on its receiver alone.

#include "pie/intersect/intersector.h"
#include "pie/lights/light.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>

namespace pie::reference {

struct Options {
    double target = 0.003;             ///< standard error of the channel mean, relative to it
    std::uint64_t mostPaths = 1 << 20; ///< per receiver; then it is given up, see Value::reached
    std::uint32_t recursionDepth = std::numeric_limits<std::uint32_t>::max(); ///< reflections; 0: direct light only
    std::uint64_t seed = 0;
};

/// What was found at a receiver. Double throughout: the sums run over millions of paths.
struct Value {
    glm::dvec3 irradiance{0.0};    ///< watts per square unit, per channel; with negative lights it may be negative
    glm::dvec3 standardError{0.0}; ///< of each channel
    double meanError = 0;          ///< standard error of the mean over the channels
    std::uint64_t paths = 0;       ///< 0: all light of this receiver was taken exactly
    bool reached = true;           ///< the target; false: the cap came first
};

class PathTracer {
public:
    /// Scene and intersector must outlive it. Costs some shadow rays per region of the scene and light, by which lights
    /// are chosen afterwards.
    PathTracer(std::shared_ptr<const scene::Scene> scene, std::span<const lights::Light> lights,
               const intersect::Intersector& intersector, const Options& options);
    ~PathTracer();
    PathTracer(const PathTracer&) = delete;
    PathTracer& operator=(const PathTracer&) = delete;

    /// values[i] of receivers[i]. `progress`, when given, is told how many are done, from the calling thread.
    void trace(std::span<const scene::Receiver> receivers, std::span<Value> values,
               const std::function<void(std::size_t)>& progress = {}) const;

private:
    struct State;
    std::unique_ptr<const State> state_;
};

} // namespace pie::reference
