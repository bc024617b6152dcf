#pragma once
// A display of the program's own, for machines without one: an Xvfb that lives as long as this object.

#include "pie/core/result.h"

#include <string>

namespace apps {

class VirtualDisplay {
public:
    /// Starts Xvfb on a free display number and points DISPLAY there. `width` × `height` is the size of its screen.
    [[nodiscard]] static pie::Result<VirtualDisplay> start(int width, int height);
    VirtualDisplay(VirtualDisplay&& other) noexcept;
    VirtualDisplay& operator=(VirtualDisplay&& other) noexcept;
    VirtualDisplay(const VirtualDisplay&) = delete;
    VirtualDisplay& operator=(const VirtualDisplay&) = delete;
    ~VirtualDisplay();

private:
    explicit VirtualDisplay(int process) : process_(process) {}
    int process_ = -1;
};

} // namespace apps
