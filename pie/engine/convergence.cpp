#include "pie/engine/convergence.h"

#include "pie/gather/photon_sums.h"

#include <algorithm>
#include <cmath>

namespace pie::engine {
namespace {

constexpr double darkest = 0.05;                                        // of the mean light
constexpr double growth = 1.25;                                         // of the photons between two looks
constexpr double helpful = 0.97;                                        // of the error at half the photons
constexpr std::uint64_t firstLook = 4ULL * gather::PhotonSums::batches; // parts

} // namespace

double relativeError(std::span<const gather::Estimate> estimates) {
    double mean = 0;
    for (const gather::Estimate& e : estimates) mean += static_cast<double>(meanChannel(e.irradiance));
    mean /= static_cast<double>(std::max<std::size_t>(1, estimates.size()));
    if (!(mean > 0)) return 0;
    double sum = 0;
    for (const gather::Estimate& e : estimates) {
        const double light = std::max(static_cast<double>(meanChannel(e.irradiance)), darkest * mean);
        const double relative = static_cast<double>(e.standardError) / light;
        sum += relative * relative;
    }
    return 100 * std::sqrt(sum / static_cast<double>(estimates.size()));
}

bool Convergence::due(std::uint64_t parts) const { return wanted() && !done_ && parts >= std::max(next_, firstLook); }

void Convergence::judge(std::span<const gather::Estimate> estimates, std::uint64_t parts) {
    error_ = relativeError(estimates);
    next_ = static_cast<std::uint64_t>(std::ceil(growth * static_cast<double>(parts)));
    done_ = error_ <= target_;
    for (const auto& [then, error] : history_)
        if (2 * then <= parts && error_ > helpful * error) done_ = true;
    history_.emplace_back(parts, error_);
}

void Convergence::look() {
    done_ = false;
    next_ = 0;
    history_.clear();
}

void Convergence::restart() {
    look();
    error_ = -1;
}

} // namespace pie::engine
