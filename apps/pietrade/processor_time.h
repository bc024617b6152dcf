#pragma once
// Time that the processor has spent on this program, all threads together.

#include <ctime>

namespace pietrade {

/// Milliseconds since some time before.
[[nodiscard]] inline double processorMs() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

} // namespace pietrade
