#include "pie/level/image.h"
#include "pie/level/decoders.h"
#include "pie/level/names.h"
#include "pie/level/vfs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace pie::level {
namespace {

constexpr std::array<std::string_view, 4> extensions = {"tga", "jpg", "jpeg", "png"}; // in the game's order

Decoding decode(std::span<const std::byte> bytes, const std::string& kind) {
    if (kind == "tga")
        if (std::optional<Decoding> done = decodeTga(bytes)) return std::move(*done);
    if (kind == "jpg" || kind == "jpeg")
        if (std::optional<Decoding> done = decodeJpeg(bytes)) return std::move(*done);
    if (kind == "png")
        if (std::optional<Decoding> done = decodePng(bytes)) return std::move(*done);
    return decodeOther(bytes, kind);
}

std::optional<PictureSize> sizeOf(std::span<const std::byte> bytes, const std::string& kind) {
    if (kind == "tga")
        if (const std::optional<PictureSize> size = tgaSize(bytes)) return size;
    if (kind == "jpg" || kind == "jpeg")
        if (const std::optional<PictureSize> size = jpegSize(bytes)) return size;
    if (kind == "png")
        if (const std::optional<PictureSize> size = pngSize(bytes)) return size;
    return otherSize(bytes, kind);
}

} // namespace

Vec4 Image::mean() const {
    if (pixels.empty()) return Vec4(0.0F);
    std::array<std::uint64_t, 4> sums{};
    for (const Rgba8& p : pixels)
        for (int c = 0; c < 4; ++c) sums.at(static_cast<std::size_t>(c)) += p[c];
    const double scale = 1.0 / (255.0 * static_cast<double>(pixels.size()));
    Vec4 result;
    for (int c = 0; c < 4; ++c)
        result[c] = static_cast<float>(static_cast<double>(sums.at(static_cast<std::size_t>(c))) * scale);
    return result;
}

std::string findImage(const Vfs& files, std::string_view name) {
    std::string_view base = name;
    const std::string written = lower(extension(name));
    if (std::find(extensions.begin(), extensions.end(), written) != extensions.end()) {
        if (files.contains(name)) return std::string(name);
        base = withoutExtension(name);
    }
    for (const std::string_view candidate : extensions) {
        if (candidate == written) continue;
        std::string path = fmt::format("{}.{}", base, candidate);
        if (files.contains(path)) return path;
    }
    return {};
}

std::optional<std::array<int, 2>> imageSize(const Vfs& files, const std::string& path) {
    const Result<Bytes> bytes = files.read(path);
    if (!bytes) return std::nullopt;
    const std::optional<PictureSize> size = sizeOf(*bytes, lower(extension(path)));
    if (!size || size->width < 1 || size->height < 1) return std::nullopt;
    return std::array{size->width, size->height};
}

Result<Image> loadImage(const Vfs& files, const std::string& path) {
    const Result<Bytes> bytes = files.read(path);
    if (!bytes) return bytes.error();
    Decoding decoded = decode(*bytes, lower(extension(path)));
    if (decoded.image) return std::move(*decoded.image);
    const std::string why = decoded.failure.empty() ? "unknown format" : decoded.failure;
    return Error{files.origin(path), "", "is not a readable picture: " + why, ""};
}

} // namespace pie::level
