#pragma once
// From photons and lights to irradiance at receivers. An Estimator answers for batches of receivers; it is one virtual
// call per batch.

#include "pie/core/vec.h"
#include "pie/maps/nearest.h"
#include "pie/scene/receivers.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace pie::gather {

/// What is known about one answer.
struct Estimate {
    Rgb irradiance{0.0F};    ///< watts per square unit
    float standardError = 0; ///< of the mean over the channels, watts per square unit: noise alone
    float bias = 0;          ///< how far the mean over the channels may be off besides, 0 where nothing is known
    float radius = 0;        ///< units: of the search, or of the surface that stands for one hit
    std::uint32_t photons = 0;
};

class Estimator {
public:
    virtual ~Estimator() = default;
    /// irradiance[i] of receivers.points[which[i]], watts per square unit per channel; finite and not negative. Safe to
    /// call from several threads at once. The result for a receiver does not depend on what else is asked.
    virtual void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const = 0;
    /// The same with what is known about its error, slower. Estimators that know nothing leave it 0.
    virtual void explain(std::span<const std::uint32_t> which, std::span<Estimate> estimates) const {
        std::vector<Rgb> irradiance(which.size());
        estimate(which, irradiance);
        for (std::size_t i = 0; i < which.size(); ++i) estimates[i] = {irradiance[i]};
    }
    /// What its searches of photon maps looked at so far.
    [[nodiscard]] virtual maps::Visits visits() const { return {}; }
    /// Memory it holds, without the photon map.
    [[nodiscard]] virtual std::size_t bytes() const { return 0; }
    [[nodiscard]] virtual std::string_view name() const = 0;
};

} // namespace pie::gather
