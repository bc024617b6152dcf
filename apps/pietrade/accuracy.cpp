#include "apps/pietrade/accuracy.h"

#include "pie/sampling/hash.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace pietrade {
namespace {

constexpr double floorShare = 0.1;

struct Deviation {
    double square = 0; ///< without the noise of the truth; may be negative
    double relative = 0;
};

std::vector<Deviation> deviations(std::span<const double> found, std::span<const Truth> truth) {
    double mean = 0;
    std::size_t lit = 0;
    for (const Truth& t : truth) {
        if (t.irradiance == 0.0) continue;
        mean += t.irradiance;
        ++lit;
    }
    std::vector<Deviation> result;
    if (lit == 0) return result;
    mean /= static_cast<double>(lit);
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const auto& [exact, noise] = truth[i];
        if (exact == 0.0) continue;
        const double off = std::abs(found[i] - exact);
        const double scale = std::max(found[i], exact) + floorShare * mean;
        if (!(scale > 0.0)) continue;
        result.push_back({(off * off - noise * noise) / (scale * scale), off / std::abs(exact)});
    }
    return result;
}

double rms(double sumOfSquares, std::size_t count) {
    return std::sqrt(std::max(0.0, sumOfSquares / static_cast<double>(count)));
}

double middle(std::vector<double> values) {
    const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), half, values.end());
    return *half;
}

double spread(const std::vector<double>& values) {
    double sum = 0;
    double squares = 0;
    for (const double v : values) {
        sum += v;
        squares += v * v;
    }
    const auto n = static_cast<double>(values.size());
    return std::sqrt(std::max(0.0, squares / n - sum * sum / (n * n)));
}

} // namespace

double errorOf(std::span<const double> found, std::span<const Truth> truth) {
    const std::vector<Deviation> all = deviations(found, truth);
    if (all.empty()) return std::numeric_limits<double>::quiet_NaN();
    double sum = 0;
    for (const Deviation& d : all) sum += d.square;
    return rms(sum, all.size());
}

Accuracy compare(std::span<const double> found, std::span<const Truth> truth) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Deviation> all = deviations(found, truth);
    Accuracy result{none, none, none, none, all.size()};
    if (all.empty()) return result;
    // Standard errors by drawing the points again, with repetition.
    constexpr std::uint64_t draws = 200;
    std::vector<double> errors;
    std::vector<double> medians;
    for (std::uint64_t draw = 0; draw <= draws; ++draw) {
        double sum = 0;
        std::vector<double> relative;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const auto any = static_cast<std::size_t>(pie::sampling::mix(draw << 32U | i) % all.size());
            const Deviation& d = all[draw == 0 ? i : any];
            sum += d.square;
            relative.push_back(d.relative);
        }
        (draw == 0 ? result.error : errors.emplace_back()) = rms(sum, all.size());
        (draw == 0 ? result.median : medians.emplace_back()) = middle(std::move(relative));
    }
    result.errorDeviation = spread(errors);
    result.medianDeviation = spread(medians);
    return result;
}

} // namespace pietrade
