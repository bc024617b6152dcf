#pragma once
// All distributions, for tests that must hold for each.

#include "pie/sampling/sequence.h"

#include <array>
#include <string>

namespace pie::test {

inline constexpr std::array allDistributions{sampling::Distribution::Halton,    sampling::Distribution::Sobol,
                                             sampling::Distribution::R2,        sampling::Distribution::Explicit,
                                             sampling::Distribution::Rejection, sampling::Distribution::Stratified,
                                             sampling::Distribution::Spiral};

[[nodiscard]] inline std::string distributionName(sampling::Distribution distribution) {
    static constexpr std::array names{"halton", "sobol", "r2", "explicit", "rejection", "stratified", "spiral"};
    return names.at(static_cast<std::size_t>(distribution));
}

} // namespace pie::test
