#pragma once
// Pictures and statistics without a window.

#include "apps/pieview/arguments.h"

namespace pieview {

/// Exit status; what went wrong is said on standard error.
[[nodiscard]] int runHeadless(const Arguments& arguments);

} // namespace pieview
