#pragma once
// Processor time, so that what else runs on the machine counts less, and the middle of several measurements.

#include <algorithm>
#include <cstddef>
#include <ctime>
#include <vector>

namespace pie::bench {

/// Of the whole process, all threads together.
[[nodiscard]] inline double processorMilliseconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// Of `work` alone.
template <class Work> [[nodiscard]] double milliseconds(const Work& work) {
    const double begin = processorMilliseconds();
    work();
    return processorMilliseconds() - begin;
}

/// Not empty.
[[nodiscard]] inline double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

} // namespace pie::bench
