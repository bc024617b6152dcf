#pragma once
// Sizes of the records of an IBSP 46 file, shared by its reader and its writer.

#include "pie/level/bsp.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace pie::level {

inline constexpr std::size_t bspHeaderBytes = 8 + std::size_t{lumpCount} * 8;
inline constexpr std::size_t bspNameBytes = 64;

/// Bytes of one record, in the order of `Lump`.
inline constexpr std::array<std::size_t, lumpCount> bspRecordBytes = {
    1, 72, 16, 36, 48, 4, 4, 40, 12, 8, 44, 4, 72, 104, sizeof(BspLightmap), 8, 1};

/// Limits: far beyond what a level holds, near enough to stop a damaged count before memory does.
inline constexpr std::int32_t maxPatchSide = 1025;
inline constexpr std::int64_t maxPatchControls = 65536;
inline constexpr std::int64_t maxFaceVertices = std::int64_t{1} << 24;     ///< of all faces together
inline constexpr std::int64_t maxFaceMeshVertices = std::int64_t{1} << 26; ///< of all faces together
inline constexpr std::int32_t maxExternalLightmap = 4096;

} // namespace pie::level
