#pragma once
// Kernels of density estimation: how much a photon counts by its distance d from the receiver, given the radius r of
// the kernel. A kernel is a function of t = d²/r² in [0, 1] with value 1 at the centre and 0 past the radius (Jensen's
// Gaussian: 0.918). An estimate is Σ flux · value / integral, where the integral is that of the kernel over the
// surface: over a whole flat disc `discIntegral · r²`, exactly; over the surfaces that exist: TrueArea.

#include <cmath>
#include <cstdint>
#include <numbers>

namespace pie::gather {

enum class Kernel : std::uint8_t {
    Constant,     ///< the paper's: every photon counts the same
    Cone,         ///< 1 − d/r: sharper shadows (pi-engine 3.5)
    Gaussian,     ///< Jensen's, alpha 0.918, beta 1.953
    Epanechnikov, ///< 1 − d²/r²: least mean squared error; the farthest photon counts nothing
};

namespace detail {
inline constexpr double gaussianAlpha = 0.918;
inline constexpr double gaussianBeta = 1.953;
inline const double gaussianRange = -std::expm1(-gaussianBeta); ///< 1 − e^−beta
} // namespace detail

/// t = d²/r² in [0, 1].
[[nodiscard]] inline double value(Kernel kernel, double t) {
    switch (kernel) {
    case Kernel::Constant: return 1;
    case Kernel::Cone: return 1 - std::sqrt(t);
    case Kernel::Gaussian:
        return detail::gaussianAlpha * (1 + std::expm1(-0.5 * detail::gaussianBeta * t) / detail::gaussianRange);
    case Kernel::Epanechnikov: return 1 - t;
    }
    return 0;
}

/// ∫ value(s) ds from 0 to t. With the distance h of a plane from the receiver, the kernel over the disc of radius ρ
/// about the foot of the receiver is π r² (primitive((h² + ρ²)/r²) − primitive(h²/r²)).
[[nodiscard]] inline double primitive(Kernel kernel, double t) {
    switch (kernel) {
    case Kernel::Constant: return t;
    case Kernel::Cone: return t - (2.0 / 3.0) * t * std::sqrt(t);
    case Kernel::Gaussian: {
        const double half = 0.5 * detail::gaussianBeta;
        return detail::gaussianAlpha * (t + (-std::expm1(-half * t) / half - t) / detail::gaussianRange);
    }
    case Kernel::Epanechnikov: return t - 0.5 * t * t;
    }
    return 0;
}

/// Integral of the kernel over the whole flat disc of radius 1.
[[nodiscard]] inline double discIntegral(Kernel kernel) { return std::numbers::pi * primitive(kernel, 1); }

} // namespace pie::gather
