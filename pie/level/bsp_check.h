#pragma once
// Every index, count and range of a level that has been read, so that nobody after it has to look.

#include "pie/level/bsp.h"

namespace pie::level {

/// Throws Damage (byte_reader.h) for the first defect, naming lump, record and field.
void checkBsp(const Bsp& bsp);

} // namespace pie::level
