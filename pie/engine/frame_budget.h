#pragma once
// How much work fits into the time of a frame (the setting budget_ms).
//
// Photons are traced, what is in view is refined and answered anew, and the draw uploads. All together are to take no
// longer than the budget. What a unit of each kind of work costs is learned from the frames before; plan() then shares
// the time out: first the answers, up to a share, then lights that change, then the rest. Answers that would take most
// of the budget alone are spread over several frames.
//
// Protocol: begin() at the start of a frame, plan(), then report what was done. One thread at a time.

#include <array>
#include <cstddef>
#include <cstdint>

namespace pie::engine {

class FrameBudget {
public:
    /// 0: no bound; then plan() gives a whole frame of everything.
    explicit FrameBudget(double milliseconds);
    [[nodiscard]] bool bounded() const { return budget_ > 0; }
    [[nodiscard]] double milliseconds() const { return budget_; }

    enum class Kind : std::uint8_t {
        TraceStill,    ///< per part of a frame of photons of the lights that stand still
        TraceChanging, ///< of those that change
        Refine,        ///< per ray
        Renew,         ///< of what surfaces reflect, once a frame in which photons came and nothing is refined
        Answer,        ///< per receiver
        Upload,        ///< once a frame
    };
    /// What could be done.
    struct Work {
        unsigned still = 0, changing = 0; ///< parts of a frame that are left to trace
        bool refine = false;              ///< receivers in view are not finished
        std::uint64_t receivers = 0;      ///< in view, to be answered
    };
    struct Plan {
        unsigned still = 0, changing = 0;
        std::uint64_t rays = 0;
        std::uint64_t receivers = 0;
    };
    /// `wholeFrame`: parts a frame has without a bound, `rays`: rays it may spend then.
    [[nodiscard]] Plan plan(const Work& work, unsigned wholeFrame, std::uint64_t rays);
    /// Units of one kind of work took so long.
    void report(Kind kind, double units, double milliseconds);

    /// Ends the frame before and begins another. Frames in which there was work are remembered.
    void begin();
    /// Milliseconds of all that was reported in remembered frames: the middle, and what 95 of 100 do not exceed. 0
    /// without frames.
    [[nodiscard]] double median() const { return quantile(0.5); }
    [[nodiscard]] double percentile95() const { return quantile(0.95); }

private:
    /// Learned cost of one unit.
    struct Cost {
        double perUnit = 0; ///< milliseconds
        bool known = false;
    };
    [[nodiscard]] const Cost& cost(Kind kind) const { return costs_[static_cast<std::size_t>(kind)]; }
    [[nodiscard]] double affordable(Kind kind, double milliseconds, double ifUnknown) const;
    void learn(Kind kind, double units, double milliseconds);
    [[nodiscard]] double quantile(double share) const;

    static constexpr std::size_t remembered = 256;
    double budget_;
    std::array<Cost, 6> costs_;
    std::array<float, remembered> frames_{};
    std::size_t frameCount_ = 0;
    double spent_ = 0, uploaded_ = 0;
};

} // namespace pie::engine
