#pragma once
// What statistical tests share. Seeds are fixed, so a test passes always or never; the false-alarm rates say how likely
// a right program is to fail when the seed or the number of samples is changed.

#include <cmath>
#include <cstddef>
#include <span>

namespace pie::test {

/// Running mean and variance (Welford).
class Moments {
public:
    void add(double x) {
        ++count_;
        const double delta = x - mean_;
        mean_ += delta / static_cast<double>(count_);
        squares_ += delta * (x - mean_);
    }
    [[nodiscard]] std::size_t count() const { return count_; }
    [[nodiscard]] double mean() const { return mean_; }
    [[nodiscard]] double variance() const { return count_ > 1 ? squares_ / static_cast<double>(count_ - 1) : 0.0; }
    /// Of the mean, squared.
    [[nodiscard]] double squaredError() const { return count_ > 0 ? variance() / static_cast<double>(count_) : 0.0; }

private:
    std::size_t count_ = 0;
    double mean_ = 0.0, squares_ = 0.0;
};

/// How many standard errors two estimates of the same thing lie apart; 0 for two equal numbers without error. 5 is
/// passed by chance once in 1.7 million.
inline double zScore(double a, double b, double squaredError) {
    const double scale = 1e-12 * (std::abs(a) + std::abs(b));
    if (squaredError <= scale * scale) return std::abs(a - b) <= 1e-5 * (std::abs(a) + std::abs(b)) ? 0.0 : 1e9;
    return (a - b) / std::sqrt(squaredError);
}

/// The standard normal deviate of a chi-square sum (Wilson and Hilferty 1931): above 5 once in 3.5 million.
inline double chiSquareDeviate(std::span<const double> observed, std::span<const double> expected) {
    double sum = 0.0;
    for (std::size_t i = 0; i < observed.size(); ++i)
        sum += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
    const double freedom = static_cast<double>(observed.size()) - 1.0;
    const double spread = 2.0 / (9.0 * freedom);
    return (std::cbrt(sum / freedom) - (1.0 - spread)) / std::sqrt(spread);
}

/// L2 star discrepancy of points in the unit square (Warnock 1972). Random points have sqrt(5 / (36 n)) in the mean.
template <class Points> double starDiscrepancy(const Points& points) {
    const auto n = static_cast<double>(points.size());
    double single = 0.0;
    double pairs = 0.0;
    for (const auto& p : points) {
        single += (1.0 - static_cast<double>(p.x) * p.x) * (1.0 - static_cast<double>(p.y) * p.y);
        for (const auto& q : points) pairs += (1.0 - std::fmax(p.x, q.x)) * (1.0 - std::fmax(p.y, q.y));
    }
    return std::sqrt(1.0 / 9.0 - single / (2.0 * n) + pairs / (n * n));
}
inline double randomStarDiscrepancy(std::size_t count) { return std::sqrt(5.0 / (36.0 * static_cast<double>(count))); }

} // namespace pie::test
