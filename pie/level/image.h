#pragma once
// Pictures from the virtual file system: tga by a decoder of our own, jpg and png by libjpeg and libpng, others
// through OpenImageIO.

#include "pie/core/bulk.h"
#include "pie/core/result.h"
#include "pie/core/vec.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace pie::level {

class Vfs;

/// 8-bit RGBA, first row at the top, no colour conversion.
struct Image {
    int width = 0, height = 0;
    bool hasAlpha = false;    ///< some pixel is not opaque
    BulkVector<Rgba8> pixels; ///< what resize() adds has no value yet

    /// Mean of the stored values, 0 to 1 per channel; alpha is the mean alpha. `colour` is weighted by nothing: the
    /// mean texel.
    [[nodiscard]] Vec4 mean() const;
};

/// Resolves an image name as the game does: the name as written, else with its extension replaced by tga, jpg, png,
/// jpeg. Empty if absent.
[[nodiscard]] std::string findImage(const Vfs& files, std::string_view name);
/// `path` as returned by findImage. Limits: 16384 pixels a side.
[[nodiscard]] Result<Image> loadImage(const Vfs& files, const std::string& path);
/// Width and height, from the head of the file alone.
[[nodiscard]] std::optional<std::array<int, 2>> imageSize(const Vfs& files, const std::string& path);

} // namespace pie::level
