#pragma once
// The window: GLFW hosts OSG as an embedded graphics window, Dear ImGui draws the panel over it. Keys and mouse become
// commands of the session. A picture that stands still is not drawn again: the window then waits for input, a save, or
// the loading thread.

#include "apps/pieview/arguments.h"

namespace pieview {

/// Until the user ends it. Exit status; what went wrong is said on standard error.
[[nodiscard]] int runWindow(const Arguments& arguments);

} // namespace pieview
