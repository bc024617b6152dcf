#pragma once
// When there are photons enough: by the standard errors of what is in view (the setting target_error).
//
// Noise falls with the square root of the photons, so it is looked at each time there are a quarter more. Enough is
// when the relative standard error, root mean square over the answers, is no more than the target; or when twice the
// photons have not lowered it by three per cent, because what is left is the noise of the rays.
//
// Protocol: while due(), judge(). restart() when the light has changed.

#include "pie/gather/gather.h"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace pie::engine {

class Convergence {
public:
    /// 0: never done.
    explicit Convergence(double targetPercent) : target_(targetPercent) {}
    [[nodiscard]] bool wanted() const { return target_ > 0; }
    /// Whether it is worth while to look, after so many parts of frames.
    [[nodiscard]] bool due(std::uint64_t parts) const;
    /// Answers with their standard errors, a sample of what is in view.
    void judge(std::span<const gather::Estimate> estimates, std::uint64_t parts);
    [[nodiscard]] bool done() const { return done_; }
    /// As of the last judge(), per cent; negative before.
    [[nodiscard]] double errorPercent() const { return error_; }
    /// Other receivers are in view: to be looked at once more.
    void look();
    void restart();

private:
    double target_;
    double error_ = -1;
    bool done_ = false;
    std::uint64_t next_ = 0;
    std::vector<std::pair<std::uint64_t, double>> history_; ///< parts, error
};

/// Relative standard error of answers, root mean square, per cent. What is darker than a twentieth of their mean counts
/// as a twentieth of it. 0 for none, and where all is dark.
[[nodiscard]] double relativeError(std::span<const gather::Estimate> estimates);

} // namespace pie::engine
