#include "pie/level/decoders.h"

#include <csetjmp>
#include <cstdio> // jpeglib.h needs it before itself

#include <jpeglib.h>

#include <jerror.h>

#include <algorithm>
#include <array>

namespace pie::level {
namespace {

static_assert(sizeof(Rgba8) == 4);

/// libjpeg reports through callbacks and must not return from an error: it jumps back to where decoding began. Between
/// the two nothing may need a destructor.
struct Errors {
    jpeg_error_mgr manager{}; // first: libjpeg knows the whole by this part
    std::jmp_buf back{};
    std::array<char, JMSG_LENGTH_MAX> message{};
    bool cut = false; ///< the bytes ended before the picture did
};

Errors& errorsOf(j_common_ptr info) { return *reinterpret_cast<Errors*>(info->err); }

[[noreturn]] void onError(j_common_ptr info) {
    Errors& errors = errorsOf(info);
    info->err->format_message(info, errors.message.data());
    std::longjmp(errors.back, 1);
}

/// Warnings: the picture is shown as far as it goes, as in the game, unless its end is missing.
void onMessage(j_common_ptr info, int level) {
    if (level >= 0) return;
    if (info->err->msg_code != JWRN_JPEG_EOF) return;
    Errors& errors = errorsOf(info);
    info->err->format_message(info, errors.message.data());
    errors.cut = true;
}

void onOutput(j_common_ptr /*info*/) {}

void prepare(jpeg_decompress_struct& info, Errors& errors) {
    info.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = onError;
    errors.manager.emit_message = onMessage;
    errors.manager.output_message = onOutput;
}

bool startsLikeJpeg(std::span<const std::byte> bytes) {
    return bytes.size() > 2 && bytes[0] == std::byte{0xff} && bytes[1] == std::byte{0xd8};
}

void openMemory(jpeg_decompress_struct& info, std::span<const std::byte> bytes) {
    jpeg_create_decompress(&info);
    jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&info, TRUE);
}

/// Reads the head. False: an error, told in `errors`. On success the caller destroys `info`, else it is done.
bool openHead(jpeg_decompress_struct& info, Errors& errors, std::span<const std::byte> bytes) {
    prepare(info, errors);
    if (setjmp(errors.back) != 0) {
        jpeg_destroy_decompress(&info);
        return false;
    }
    openMemory(info, bytes);
    return true;
}

/// The rows, into room for all of them. False: an error.
bool readRows(jpeg_decompress_struct& info, Errors& errors, Rgba8* pixels) {
    if (setjmp(errors.back) != 0) return false;
    info.out_color_space = JCS_EXT_RGBA; // alpha 255
    jpeg_start_decompress(&info);
    constexpr unsigned rowsAtOnce = 16;
    std::array<JSAMPROW, rowsAtOnce> rows{};
    while (info.output_scanline < info.output_height) {
        const unsigned count = std::min(rowsAtOnce, info.output_height - info.output_scanline);
        for (unsigned i = 0; i < count; ++i)
            rows[i] = reinterpret_cast<JSAMPROW>(pixels + std::size_t{info.output_scanline + i} * info.output_width);
        jpeg_read_scanlines(&info, rows.data(), count);
    }
    jpeg_finish_decompress(&info);
    return true;
}

bool printed(const jpeg_decompress_struct& info) { return info.num_components != 1 && info.num_components != 3; }

} // namespace

std::optional<PictureSize> jpegSize(std::span<const std::byte> bytes) {
    if (!startsLikeJpeg(bytes)) return std::nullopt;
    jpeg_decompress_struct info{};
    Errors errors;
    if (!openHead(info, errors, bytes)) return std::nullopt;
    const PictureSize size{static_cast<int>(info.image_width), static_cast<int>(info.image_height)};
    jpeg_destroy_decompress(&info);
    return size;
}

std::optional<Decoding> decodeJpeg(std::span<const std::byte> bytes) {
    if (!startsLikeJpeg(bytes)) return std::nullopt;
    Decoding result;
    jpeg_decompress_struct info{};
    Errors errors;
    if (!openHead(info, errors, bytes)) {
        result.failure = errors.message.data();
        return result;
    }
    if (printed(info)) {
        jpeg_destroy_decompress(&info);
        return std::nullopt;
    }
    result.failure = sizeDefect(info.image_width, info.image_height);
    if (result.failure.empty()) {
        Image image;
        image.width = static_cast<int>(info.image_width);
        image.height = static_cast<int>(info.image_height);
        image.pixels.resize(std::size_t{info.image_width} * info.image_height);
        if (!readRows(info, errors, image.pixels.data()) || errors.cut)
            result.failure = errors.message.data();
        else
            result.image = std::move(image);
    }
    jpeg_destroy_decompress(&info);
    return result;
}

} // namespace pie::level
