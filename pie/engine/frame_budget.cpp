#include "pie/engine/frame_budget.h"

#include <algorithm>
#include <cmath>

namespace pie::engine {
namespace {

constexpr double planned = 0.8;     // of the budget; the rest is for what cannot be foreseen
constexpr double mostAnswers = 0.6; // of what is planned
constexpr double learning = 0.25;   // weight of the last frame in a cost
constexpr double firstRays = 5'000; // while nothing is known
constexpr double fewestAnswers = 500;
constexpr double fewestRays = 1'000; // so that every frame gets somewhere

} // namespace

FrameBudget::FrameBudget(double milliseconds) : budget_(std::max(0.0, milliseconds)) {}

double FrameBudget::affordable(Kind kind, double milliseconds, double ifUnknown) const {
    const Cost& its = cost(kind);
    return its.known && its.perUnit > 0 ? std::max(0.0, milliseconds) / its.perUnit : ifUnknown;
}

FrameBudget::Plan FrameBudget::plan(const Work& work, unsigned wholeFrame, std::uint64_t rays) {
    if (!bounded())
        return {std::min(work.still, wholeFrame), std::min(work.changing, wholeFrame), rays, work.receivers};
    double left = std::max(0.0, planned * budget_ - cost(Kind::Upload).perUnit);
    Plan plan;
    // The smallest steps of the rest.
    const double least = (work.still > 0 ? cost(Kind::TraceStill).perUnit : 0) +
                         (work.changing > 0 ? cost(Kind::TraceChanging).perUnit : 0) +
                         (work.refine ? fewestRays * cost(Kind::Refine).perUnit : 0);
    const bool more = work.still > 0 || work.changing > 0 || work.refine;
    const double forAnswers = more ? std::min(mostAnswers * left, left - least) : left;
    const double answers = std::floor(affordable(Kind::Answer, forAnswers, fewestAnswers));
    plan.receivers = std::min(work.receivers, static_cast<std::uint64_t>(std::max(answers, fewestAnswers)));
    left = std::max(0.0, left - static_cast<double>(plan.receivers) * cost(Kind::Answer).perUnit);
    if (!work.refine) left = std::max(0.0, left - cost(Kind::Renew).perUnit);
    const auto parts = [&](Kind kind, unsigned most, double share) {
        if (most == 0) return 0U;
        const double wanted = std::floor(affordable(kind, share * left, 1));
        const auto count = static_cast<unsigned>(std::clamp(wanted, 1.0, static_cast<double>(most)));
        left = std::max(0.0, left - count * cost(kind).perUnit);
        return count;
    };
    plan.changing = parts(Kind::TraceChanging, work.changing, work.still > 0 || work.refine ? 0.6 : 1.0);
    plan.still = parts(Kind::TraceStill, work.still, work.refine ? 0.4 : 1.0);
    if (work.refine)
        plan.rays = static_cast<std::uint64_t>(std::max(fewestRays, affordable(Kind::Refine, left, firstRays)));
    return plan;
}

void FrameBudget::report(Kind kind, double units, double milliseconds) {
    spent_ += milliseconds;
    // Comes drawable by drawable; learned when the frame is over.
    if (kind == Kind::Upload) {
        uploaded_ += milliseconds;
        return;
    }
    learn(kind, units, milliseconds);
}

void FrameBudget::learn(Kind kind, double units, double milliseconds) {
    if (!(units > 0)) return;
    Cost& its = costs_[static_cast<std::size_t>(kind)];
    const double now = milliseconds / units;
    its.perUnit = its.known ? its.perUnit + learning * (now - its.perUnit) : now;
    its.known = true;
}

void FrameBudget::begin() {
    if (spent_ > 0) frames_[frameCount_++ % remembered] = static_cast<float>(spent_);
    if (uploaded_ > 0) learn(Kind::Upload, 1, uploaded_);
    spent_ = uploaded_ = 0;
}

double FrameBudget::quantile(double share) const {
    std::array<float, remembered> sorted = frames_;
    const std::size_t count = std::min(frameCount_, remembered);
    if (count == 0) return 0;
    const auto place = static_cast<std::size_t>(std::lround(share * static_cast<double>(count - 1)));
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(place),
                     sorted.begin() + static_cast<std::ptrdiff_t>(count));
    return static_cast<double>(sorted[place]);
}

} // namespace pie::engine
