#pragma once
// Ctrl-C: the first asks the work to end where it can be resumed, the second ends the program as usual.

namespace pietrade {

void catchInterrupts();
[[nodiscard]] bool interrupted();

} // namespace pietrade
