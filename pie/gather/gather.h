#pragma once
// From photons and lights to irradiance at receivers. An Estimator answers for batches of receivers; it is one virtual
// call per batch.

#include "pie/core/vec.h"
#include "pie/scene/receivers.h"

#include <cstdint>
#include <span>
#include <string_view>

namespace pie::gather {

class Estimator {
public:
    virtual ~Estimator() = default;
    /// irradiance[i] of receivers.points[which[i]], watts per square unit per channel; finite and not negative. Safe to
    /// call from several threads at once. The result for a receiver does not depend on what else is asked.
    virtual void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const = 0;
    [[nodiscard]] virtual std::string_view name() const = 0;
};

} // namespace pie::gather
