#include "apps/support/picture_file.h"

#include "pie/core/whole_file.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace apps {
namespace {

std::string endingOf(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending;
}

std::optional<std::string> png(const FloatPicture& picture) {
    std::vector<std::uint8_t> bytes(picture.rgb.size());
    std::transform(picture.rgb.begin(), picture.rgb.end(), bytes.begin(), [](float value) {
        return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * 255.0F)); // NaN: 0
    });
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(picture.width);
    image.height = static_cast<png_uint_32>(picture.height);
    image.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = 0;
    if (!png_image_write_get_memory_size(image, size, 0, bytes.data(), 0, nullptr)) return std::nullopt;
    std::string file(size, '\0');
    if (!png_image_write_to_memory(&image, file.data(), &size, 0, bytes.data(), 0, nullptr)) return std::nullopt;
    file.resize(size);
    return file;
}

/// Little-endian, as OpenEXR's files are.
class Bytes {
public:
    void u32(std::uint32_t value) {
        for (unsigned shift = 0; shift < 32; shift += 8) text_ += static_cast<char>(value >> shift & 0xffU);
    }
    void u64(std::uint64_t value) {
        u32(static_cast<std::uint32_t>(value));
        u32(static_cast<std::uint32_t>(value >> 32U));
    }
    void f32(float value) { u32(std::bit_cast<std::uint32_t>(value)); }
    void byte(char value) { text_ += value; }
    void name(std::string_view value) {
        text_ += value;
        text_ += '\0';
    }
    void attribute(std::string_view key, std::string_view type, std::uint32_t size) {
        name(key);
        name(type);
        u32(size);
    }
    [[nodiscard]] std::size_t size() const { return text_.size(); }
    [[nodiscard]] std::string take() { return std::move(text_); }

private:
    std::string text_;
};

/// One part, scan lines from the top, channels of 32-bit floats, no compression.
std::string exr(const FloatPicture& picture) {
    constexpr std::uint32_t magic = 20000630;
    constexpr std::uint32_t floats = 2;
    constexpr std::array<std::string_view, 3> channels{"B", "G", "R"}; // in alphabetical order
    const auto width = static_cast<std::uint32_t>(picture.width);
    const auto height = static_cast<std::uint32_t>(picture.height);
    Bytes out;
    out.u32(magic);
    out.u32(2);
    out.attribute("channels", "chlist", 3 * (2 + 16) + 1);
    for (const std::string_view channel : channels) {
        out.name(channel);
        out.u32(floats);
        out.u32(0);
        out.u32(1);
        out.u32(1);
    }
    out.byte(0);
    out.attribute("compression", "compression", 1);
    out.byte(0);
    for (const std::string_view window : {"dataWindow", "displayWindow"}) {
        out.attribute(window, "box2i", 16);
        out.u32(0);
        out.u32(0);
        out.u32(width - 1);
        out.u32(height - 1);
    }
    out.attribute("lineOrder", "lineOrder", 1);
    out.byte(0);
    out.attribute("pixelAspectRatio", "float", 4);
    out.f32(1);
    out.attribute("screenWindowCenter", "v2f", 8);
    out.f32(0);
    out.f32(0);
    out.attribute("screenWindowWidth", "float", 4);
    out.f32(1);
    out.byte(0);
    const std::uint64_t line = 8 + 12ULL * width;
    const std::uint64_t first = out.size() + 8ULL * height;
    for (std::uint32_t y = 0; y < height; ++y) out.u64(first + line * y);
    for (std::uint32_t y = 0; y < height; ++y) {
        out.u32(y);
        out.u32(12 * width);
        for (std::size_t c = 3; c-- > 0;)
            for (std::size_t x = 0; x < width; ++x) out.f32(picture.rgb[3 * (std::size_t{y} * width + x) + c]);
    }
    return out.take();
}

} // namespace

bool isPictureName(const std::filesystem::path& file) {
    const std::string ending = endingOf(file);
    return ending == ".png" || ending == ".exr";
}

std::optional<pie::Error> writePicture(const std::filesystem::path& file, const FloatPicture& picture) {
    if (endingOf(file) == ".exr") return pie::writeWhole(file, exr(picture));
    const auto bytes = png(picture);
    if (!bytes) return pie::Error{file.string(), "", "cannot be made a PNG", ""};
    return pie::writeWhole(file, *bytes);
}

} // namespace apps
