#pragma once
// Where and beside what it was measured.

#include <array>
#include <string>

namespace piebench {

struct Machine {
    std::string processor; ///< as the system calls it; empty where it does not say
    unsigned cores = 0;    ///< that this process may use
};
[[nodiscard]] Machine machine();
/// Means of runnable processes over 1, 5 and 15 minutes; this program is among them. Zeros where the system does not
/// say.
[[nodiscard]] std::array<double, 3> load();

} // namespace piebench
