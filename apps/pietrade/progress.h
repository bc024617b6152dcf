#pragma once
// How far it is: a bar with the time left on a terminal, plain lines elsewhere.

#include "pie/core/clock.h"

#include <cstddef>
#include <string>
#include <string_view>

namespace pietrade {

/// "1 h 02 min", "3 min 20 s", "12 s".
[[nodiscard]] std::string duration(double seconds);
/// "[######....] 12/40, 3 min 20 s left: gather_rays=512", `width` characters at most.
[[nodiscard]] std::string bar(std::size_t done, std::size_t all, double secondsLeft, std::string_view what,
                              std::size_t width);

class Progress {
public:
    enum class Kind { None, Lines, Bar };
    explicit Progress(Kind kind) : kind_(kind) {}
    /// Work of `all` steps begins; those `done` before cost nothing and say nothing of the time left.
    void begin(std::size_t all, std::size_t done = 0);
    /// So many steps are done, one like the other; for lines, once in a while.
    void reach(std::size_t done, std::string_view what);
    /// A step begins.
    void step(std::string_view what);
    /// The step ended; `result` is for lines.
    void done(std::string_view result);
    /// A line of its own, whatever the kind.
    void say(std::string_view line);
    ~Progress();

private:
    void clear();
    [[nodiscard]] double secondsLeft() const;

    Kind kind_;
    std::size_t all_ = 0, done_ = 0, free_ = 0;
    bool shown_ = false;
    pie::Clock::time_point start_ = pie::Clock::now(), line_ = start_;
    std::string what_;
};

} // namespace pietrade
