#pragma once
// A scene with lights and its path tracer, and what tests ask of it.

#include "pie/reference/path_tracer.h"
#include "tests/gather/scenes.h"

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace pie::reference::test {

using gather::test::receiverAt;
using gather::test::SceneBuilder;

/// Statistical tests here fail by chance once in 15,000 seeds (4 standard errors), and the seeds are fixed.
inline constexpr double mostErrors = 4;

struct Traced {
    std::shared_ptr<const scene::Scene> scene;
    std::vector<lights::Light> lights;
    std::unique_ptr<intersect::Intersector> intersector;

    Traced(std::shared_ptr<const scene::Scene> theScene, std::vector<lights::Light> theLights)
        : scene(std::move(theScene)), lights(std::move(theLights)),
          intersector(intersect::makeIntersector(intersect::Kind::Embree, *scene, {})) {}
    Traced(const SceneBuilder& builder, std::vector<lights::Light> theLights)
        : Traced(builder.make(), std::move(theLights)) {}

    [[nodiscard]] std::vector<Value> at(const std::vector<scene::Receiver>& receivers,
                                        const Options& options = {}) const {
        const PathTracer tracer(scene, lights, *intersector, options);
        std::vector<Value> values(receivers.size());
        tracer.trace(receivers, values);
        return values;
    }
};

/// Mean of the first channel, and its standard error from the spread of the values.
struct Mean {
    double value = 0, error = 0;
};
inline Mean meanOf(const std::vector<Value>& values) {
    Mean mean;
    for (const Value& v : values) mean.value += v.irradiance.x / static_cast<double>(values.size());
    for (const Value& v : values) mean.error += (v.irradiance.x - mean.value) * (v.irradiance.x - mean.value);
    const auto n = static_cast<double>(values.size());
    mean.error = std::sqrt(mean.error / (n * (n - 1)));
    return mean;
}
/// The same for values on a regular grid, where their own errors are all the noise there is.
inline Mean gridMeanOf(const std::vector<Value>& values) {
    Mean mean = meanOf(values);
    mean.error = 0;
    for (const Value& v : values) mean.error += v.standardError.x * v.standardError.x;
    mean.error = std::sqrt(mean.error) / static_cast<double>(values.size());
    return mean;
}

/// Middles of `cells` × `cells` cells of a parallelogram.
inline std::vector<scene::Receiver> grid(const Vec3& origin, const Vec3& u, const Vec3& v, const Vec3& normal,
                                         int cells) {
    std::vector<scene::Receiver> points;
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x) {
            const auto share = [&](int i) { return (static_cast<float>(i) + 0.5F) / static_cast<float>(cells); };
            points.push_back(receiverAt(origin + share(x) * u + share(y) * v, normal));
        }
    return points;
}

inline lights::PointLight lamp(const Vec3& position, const Rgb& watts) {
    lights::PointLight light;
    light.position = position;
    light.power = watts;
    light.falloff.minDistance = 0;
    return light;
}

} // namespace pie::reference::test
