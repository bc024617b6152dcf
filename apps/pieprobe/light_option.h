#pragma once
// --light "KIND NUMBERS …": a physical light, without the level compiler's smallest distance.

#include "pie/core/result.h"
#include "pie/lights/light.h"

#include <string>
#include <string_view>

namespace pieprobe {

/// What --help says about it.
[[nodiscard]] std::string lightHelp();
/// One light; an error names what is wrong with which number.
[[nodiscard]] pie::Result<pie::lights::Light> parseLight(std::string_view text);

} // namespace pieprobe
