#include "apps/piebench/machine.h"

#include <sched.h>

#include <fstream>

namespace piebench {

Machine machine() {
    Machine found;
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        const std::size_t colon = line.find(':');
        if (colon == std::string::npos || !line.starts_with("model name")) continue;
        const std::size_t first = line.find_first_not_of(" \t", colon + 1);
        if (first != std::string::npos) found.processor = line.substr(first);
        break;
    }
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    if (sched_getaffinity(0, sizeof(allowed), &allowed) == 0) found.cores = static_cast<unsigned>(CPU_COUNT(&allowed));
    return found;
}

std::array<double, 3> load() {
    std::array<double, 3> means{};
    std::ifstream file("/proc/loadavg");
    for (double& mean : means)
        if (!(file >> mean)) mean = 0;
    return means;
}

} // namespace piebench
