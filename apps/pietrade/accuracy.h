#pragma once
// How far irradiance is from the truth, as two numbers with standard errors.
//
// The deviation of a point is |E − E0| / (max(E, E0) + a tenth of the mean E0): relative where there is light, bounded
// where there is hardly any, and at most 1, so that a shadow's edge that is off by less than a triangle counts as
// wrong at that point and no more. `error` is its root mean square, less what the noise of the truth itself adds; the
// median is of |E − E0| / E0. Points whose truth is zero see nothing (other surfaces cover them) and are left out.

#include <cstddef>
#include <span>

namespace pietrade {

/// Irradiance of the mean channel, and its standard error.
struct Truth {
    double irradiance = 0, standardError = 0;
};

struct Accuracy {
    double error = 0, errorDeviation = 0;   ///< share, and its standard error by the choice of points
    double median = 0, medianDeviation = 0; ///< the same
    std::size_t points = 0;                 ///< that count
};
/// As long as each other. NaN where no point counts.
[[nodiscard]] Accuracy compare(std::span<const double> found, std::span<const Truth> truth);
/// `error` alone: what every frame is asked for.
[[nodiscard]] double errorOf(std::span<const double> found, std::span<const Truth> truth);

} // namespace pietrade
