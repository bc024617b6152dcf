#include "pie/level/decoders.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>

namespace pie::level {
namespace {

/// What libpng's callbacks know. It must not return from an error: it jumps back to where decoding began. Between the
/// two nothing may need a destructor.
struct Reading {
    std::span<const std::byte> left;
    std::array<char, 200> message{};
};

[[noreturn]] void onPngError(png_structp png, png_const_charp message) {
    auto& reading = *static_cast<Reading*>(png_get_error_ptr(png));
    std::strncpy(reading.message.data(), message, reading.message.size() - 1);
    png_longjmp(png, 1);
}

/// Warnings: the picture is shown all the same.
void onPngWarning(png_structp /*png*/, png_const_charp /*message*/) {}

void readBytes(png_structp png, png_bytep to, std::size_t count) {
    auto& reading = *static_cast<Reading*>(png_get_io_ptr(png));
    if (count > reading.left.size()) png_error(png, "the file ends before the picture does");
    std::memcpy(to, reading.left.data(), count);
    reading.left = reading.left.subspan(count);
}

bool startsLikePng(std::span<const std::byte> bytes) {
    constexpr std::size_t length = 8;
    return bytes.size() > length && png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, length) == 0;
}

/// libpng's two halves of a picture, and what is read from.
struct Png {
    Reading reading;
    png_structp png = nullptr;
    png_infop info = nullptr;

    explicit Png(std::span<const std::byte> bytes) : reading{bytes, {}} {
        png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, onPngError, onPngWarning);
        if (png == nullptr) return;
        info = png_create_info_struct(png);
        png_set_read_fn(png, &reading, readBytes);
    }
    ~Png() { png_destroy_read_struct(&png, &info, nullptr); }
    Png(const Png&) = delete;
    Png& operator=(const Png&) = delete;

    /// False: an error, told in reading.message.
    bool readHead() {
        if (info == nullptr) return false;
        if (setjmp(png_jmpbuf(png)) != 0) return false;
        png_read_info(png, info);
        return true;
    }
    [[nodiscard]] PictureSize size() const {
        return {static_cast<int>(png_get_image_width(png, info)), static_cast<int>(png_get_image_height(png, info))};
    }
    /// The rows as RGBA of 8 bits, into room for all of them. Stored values, whatever the file says of gamma, as in the
    /// game. False: an error.
    bool readRows(Rgba8* pixels) {
        if (setjmp(png_jmpbuf(png)) != 0) return false;
        png_set_expand(png);
        png_set_scale_16(png);
        png_set_gray_to_rgb(png);
        png_set_add_alpha(png, 0xff, PNG_FILLER_AFTER);
        const int passes = png_set_interlace_handling(png);
        png_read_update_info(png, info);
        const auto width = static_cast<std::size_t>(png_get_image_width(png, info));
        const png_uint_32 height = png_get_image_height(png, info);
        if (png_get_rowbytes(png, info) != width * sizeof(Rgba8)) png_error(png, "rows of unexpected length");
        for (int pass = 0; pass < passes; ++pass)
            for (png_uint_32 row = 0; row < height; ++row)
                png_read_row(png, reinterpret_cast<png_bytep>(pixels + row * width), nullptr);
        png_read_end(png, nullptr);
        return true;
    }
};

} // namespace

std::optional<PictureSize> pngSize(std::span<const std::byte> bytes) {
    if (!startsLikePng(bytes)) return std::nullopt;
    Png file(bytes);
    if (!file.readHead()) return std::nullopt;
    return file.size();
}

std::optional<Decoding> decodePng(std::span<const std::byte> bytes) {
    if (!startsLikePng(bytes)) return std::nullopt;
    Decoding result;
    Png file(bytes);
    if (!file.readHead()) {
        result.failure = file.reading.message.data();
        return result;
    }
    const PictureSize size = file.size();
    result.failure = sizeDefect(size.width, size.height);
    if (!result.failure.empty()) return result;
    Image image;
    image.width = size.width;
    image.height = size.height;
    image.pixels.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    if (!file.readRows(image.pixels.data())) {
        result.failure = file.reading.message.data();
        return result;
    }
    image.hasAlpha = std::any_of(image.pixels.begin(), image.pixels.end(), [](const Rgba8& p) { return p.a != 255; });
    result.image = std::move(image);
    return result;
}

} // namespace pie::level
