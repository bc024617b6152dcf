#pragma once
// Pictures as files, whole or not at all: PNG in bytes, or OpenEXR in floats, uncompressed.

#include "pie/core/result.h"

#include <filesystem>
#include <optional>
#include <vector>

namespace apps {

/// Values as they are shown, 1 is white; rows from the top.
struct FloatPicture {
    int width = 0, height = 0;
    std::vector<float> rgb;
};

/// Whether the name ends in .png or .exr.
[[nodiscard]] bool isPictureName(const std::filesystem::path& file);
/// By its ending. A PNG is cut to 0 … 1, an EXR holds what is there.
[[nodiscard]] std::optional<pie::Error> writePicture(const std::filesystem::path& file, const FloatPicture& picture);

} // namespace apps
