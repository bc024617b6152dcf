#pragma once
// Time that has passed, for statistics.

#include <chrono>
#include <ctime>

namespace pie {

using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Time that processors have spent on this program, all threads together, since some time before: what else runs on the
/// machine counts less.
[[nodiscard]] inline double processorMilliseconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

} // namespace pie
