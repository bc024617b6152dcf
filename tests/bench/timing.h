#pragma once
// Processor time, so that what else runs on the machine counts less, and the middle of several measurements.

#include "pie/core/clock.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

namespace pie::bench {

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

/// Of the machine over the last minute, as the system writes it: stands beside what was measured.
[[nodiscard]] inline std::string loadAverage() {
    std::ifstream file("/proc/loadavg");
    std::string one;
    file >> one;
    return one;
}

} // namespace pie::bench
