#pragma once
// Levels of either kind: a compiled .bsp, or the .map text that an editor writes.

#include "pie/level/level.h"
#include "pie/level/vfs.h"

namespace pie::brushes {

/// Reads a level and everything it refers to; a name that ends in .map is compiled in memory first. Damaged brushes are
/// warnings.
[[nodiscard]] Result<level::Level> loadLevel(level::Location location, const level::LoadOptions& options = {});
/// The same from bytes: `location.name` says what they are and where things beside it lie.
[[nodiscard]] Result<level::Level> loadLevel(std::span<const std::byte> bytes, level::Location location,
                                             const level::LoadOptions& options = {});

} // namespace pie::brushes
