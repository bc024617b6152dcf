#pragma once
// Pictures from bytes in memory. TGA, JPEG and PNG, of which levels are made, are decoded here; whatever else there is
// goes through OpenImageIO, which brings some 260 libraries along: they take longer to load than a level does, so they
// are loaded when the first such picture comes up (openimageio_module.h). Not for use outside pie/level.
//
// All may be called from several threads at once. Rows are top first; RGBA, without colour conversion.

#include "pie/level/image.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace pie::level {

/// What a decoder made of the bytes: a picture, or why they are none.
struct Decoding {
    std::optional<Image> image;
    std::string failure; ///< one line; only without `image`
};

/// Bounds on what a head may claim: 16384 pixels a side, 2^26 in all. Empty if the size is within them.
[[nodiscard]] inline std::string sizeDefect(std::int64_t width, std::int64_t height) {
    constexpr std::int64_t maxSide = 16384;
    constexpr std::int64_t maxPixels = std::int64_t{1} << 26;
    if (width >= 1 && height >= 1 && width <= maxSide && height <= maxSide && width * height <= maxPixels) return {};
    return std::to_string(width) + " x " + std::to_string(height) + " pixels are beyond the limits (" +
           std::to_string(maxSide) + " a side, " + std::to_string(maxPixels) + " in all)";
}

/// As the game reads it: true colour of 24 or 32 bits or 8 bits of grey, packed or not, bottom row first whatever the
/// header says. Nothing for kinds that the game does not know.
[[nodiscard]] std::optional<Decoding> decodeTga(std::span<const std::byte> bytes);
/// Grey or colour. Nothing for what is made for printing (CMYK), and for what is no JPEG.
[[nodiscard]] std::optional<Decoding> decodeJpeg(std::span<const std::byte> bytes);
/// Any PNG. Nothing for what is none.
[[nodiscard]] std::optional<Decoding> decodePng(std::span<const std::byte> bytes);
/// Any format that OpenImageIO knows by this extension.
[[nodiscard]] Decoding decodeOther(std::span<const std::byte> bytes, const std::string& extension);

struct PictureSize {
    int width = 0, height = 0;
};
/// From the head of the file alone; nothing where the decoder above would decline.
[[nodiscard]] std::optional<PictureSize> tgaSize(std::span<const std::byte> bytes);
[[nodiscard]] std::optional<PictureSize> jpegSize(std::span<const std::byte> bytes);
[[nodiscard]] std::optional<PictureSize> pngSize(std::span<const std::byte> bytes);
[[nodiscard]] std::optional<PictureSize> otherSize(std::span<const std::byte> bytes, const std::string& extension);

} // namespace pie::level
