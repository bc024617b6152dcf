#include "pie/level/decoders.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace pie::level {
namespace {

constexpr std::size_t headBytes = 18;

struct Head {
    std::size_t pixelsAt = 0; ///< behind head and comment
    int width = 0, height = 0;
    std::size_t bytesPerPixel = 0;
    bool packed = false;
};

std::optional<Head> readHead(std::span<const std::byte> bytes) {
    if (bytes.size() < headBytes) return std::nullopt;
    const auto byteAt = [&](std::size_t i) { return std::to_integer<unsigned>(bytes[i]); };
    const auto wordAt = [&](std::size_t i) { return static_cast<int>(byteAt(i) | byteAt(i + 1) << 8U); };
    const unsigned palette = byteAt(1);
    const unsigned kind = byteAt(2);
    const unsigned bits = byteAt(16);
    const unsigned descriptor = byteAt(17);
    constexpr unsigned trueColour = 2;
    constexpr unsigned grey = 3;
    constexpr unsigned packedColour = 10;
    const bool colour = (kind == trueColour || kind == packedColour) && (bits == 24 || bits == 32);
    if (palette != 0 || !(colour || (kind == grey && bits == 8))) return std::nullopt;
    constexpr unsigned oddOrder = 0xd0; // right to left, interleaved
    if ((descriptor & oddOrder) != 0) return std::nullopt;
    return Head{headBytes + byteAt(0), wordAt(12), wordAt(14), bits / 8, kind == packedColour};
}

/// Stored are blue, green, red and alpha, or grey.
template <std::size_t Bytes> Rgba8 pixelAt(const std::byte* from) {
    const auto part = [from](std::size_t i) { return std::to_integer<std::uint8_t>(from[i]); };
    if constexpr (Bytes == 1) return {part(0), part(0), part(0), std::uint8_t{255}};
    if constexpr (Bytes == 3) return {part(2), part(1), part(0), std::uint8_t{255}};
    if constexpr (Bytes == 4) return {part(2), part(1), part(0), part(3)};
}

/// Row of the picture at which the file's row number `row` goes: bottom row first.
Rgba8* rowOf(Image& image, int row) {
    return image.pixels.data() +
           static_cast<std::size_t>(image.height - 1 - row) * static_cast<std::size_t>(image.width);
}

template <std::size_t Bytes> bool readPlain(std::span<const std::byte> from, Image& image) {
    const auto width = static_cast<std::size_t>(image.width);
    if (from.size() / Bytes < width * static_cast<std::size_t>(image.height)) return false;
    const std::byte* next = from.data();
    for (int y = 0; y < image.height; ++y) {
        Rgba8* row = rowOf(image, y);
        for (std::size_t x = 0; x < width; ++x, next += Bytes) row[x] = pixelAt<Bytes>(next);
    }
    return true;
}

/// Packets of up to 128 pixels: one that repeats, or as many as they are. They may go on in the next row.
template <std::size_t Bytes> bool readPacked(std::span<const std::byte> from, Image& image) {
    const std::byte* next = from.data();
    std::size_t left = from.size();
    int y = 0;
    std::size_t x = 0;
    const auto width = static_cast<std::size_t>(image.width);
    Rgba8* row = rowOf(image, 0);
    while (y < image.height) {
        if (left < 1 + Bytes) return false;
        const auto packet = std::to_integer<unsigned>(*next++);
        --left;
        std::size_t count = (packet & 0x7fU) + 1;
        const bool repeats = (packet & 0x80U) != 0;
        if (!repeats && left < count * Bytes) return false;
        while (count > 0 && y < image.height) {
            const std::size_t here = std::min(count, width - x);
            if (repeats) {
                std::fill_n(row + x, here, pixelAt<Bytes>(next));
            } else {
                for (std::size_t i = 0; i < here; ++i) row[x + i] = pixelAt<Bytes>(next + i * Bytes);
                next += here * Bytes;
                left -= here * Bytes;
            }
            count -= here;
            x += here;
            if (x < width) continue;
            x = 0;
            if (++y < image.height) row = rowOf(image, y);
        }
        if (repeats) {
            next += Bytes;
            left -= Bytes;
        }
    }
    return true;
}

template <std::size_t Bytes> bool readPixels(std::span<const std::byte> from, bool packed, Image& image) {
    return packed ? readPacked<Bytes>(from, image) : readPlain<Bytes>(from, image);
}

} // namespace

std::optional<PictureSize> tgaSize(std::span<const std::byte> bytes) {
    const std::optional<Head> head = readHead(bytes);
    if (!head) return std::nullopt;
    return PictureSize{head->width, head->height};
}

std::optional<Decoding> decodeTga(std::span<const std::byte> bytes) {
    const std::optional<Head> head = readHead(bytes);
    if (!head) return std::nullopt;
    Decoding result;
    result.failure = sizeDefect(head->width, head->height);
    if (!result.failure.empty()) return result;
    const std::span<const std::byte> pixels = bytes.subspan(std::min(head->pixelsAt, bytes.size()));
    // A packet is no more than 128 pixels: sizes that the file cannot hold get no memory.
    constexpr std::size_t mostPerPacket = 128;
    const std::size_t most =
        head->packed ? pixels.size() / (1 + head->bytesPerPixel) * mostPerPacket : pixels.size() / head->bytesPerPixel;
    Image image;
    image.width = head->width;
    image.height = head->height;
    const auto count = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    bool whole = count <= most;
    if (whole) {
        image.pixels.resize(count);
        switch (head->bytesPerPixel) {
        case 1: whole = readPixels<1>(pixels, head->packed, image); break;
        case 3: whole = readPixels<3>(pixels, head->packed, image); break;
        default: whole = readPixels<4>(pixels, head->packed, image); break;
        }
    }
    if (!whole) {
        result.failure = "it ends before its last row";
        return result;
    }
    image.hasAlpha = head->bytesPerPixel == 4 &&
                     std::any_of(image.pixels.begin(), image.pixels.end(), [](const Rgba8& p) { return p.a != 255; });
    result.image = std::move(image);
    return result;
}

} // namespace pie::level
