#pragma once
// The front of a trade: what nothing else beats in both of two costs.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace pietrade {

struct Cost {
    double error = 0; ///< share
    double time = 0;  ///< ms
};

/// Numbers of those that no other one equals or beats in both costs and beats in one, by growing time. Of equals the
/// first. What has a cost that is not a number is not on the front.
[[nodiscard]] std::vector<std::size_t> front(std::span<const Cost> costs);
/// The most accurate one that takes at most `time`; none: all take longer.
[[nodiscard]] std::optional<std::size_t> bestWithin(std::span<const Cost> costs, double time);
/// The fastest one with at most `error`; none: all err by more.
[[nodiscard]] std::optional<std::size_t> fastestWithin(std::span<const Cost> costs, double error);

} // namespace pietrade
