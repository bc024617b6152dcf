#include "pie/level/image.h"
#include "pie/level/names.h"
#include "pie/level/vfs.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace pie::level {
namespace {

constexpr int maxSide = 16384;
constexpr std::int64_t maxPixels = std::int64_t{1} << 26;

constexpr std::array<std::string_view, 4> extensions = {"tga", "jpg", "jpeg", "png"}; // in the game's order

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

/// The game takes every TGA for a bottom-up one and only warns where the header says otherwise.
bool flippedByGame(const std::string& path, const Bytes& bytes) {
    constexpr std::size_t descriptor = 17;
    return equalNoCase(extension(path), "tga") && bytes.size() > descriptor &&
           (std::to_integer<unsigned>(bytes[descriptor]) & 0x20U) != 0;
}

void flip(Image& image) {
    const auto width = static_cast<std::ptrdiff_t>(image.width);
    for (int top = 0, bottom = image.height - 1; top < bottom; ++top, --bottom)
        std::swap_ranges(image.pixels.begin() + top * width, image.pixels.begin() + (top + 1) * width,
                         image.pixels.begin() + bottom * width);
}

/// Grey, grey with alpha or RGB, as read, becomes RGBA.
void expand(Image& image, int channels) {
    if (channels >= 4) return;
    auto* bytes = reinterpret_cast<std::uint8_t*>(image.pixels.data());
    const auto step = static_cast<std::size_t>(channels);
    // Backwards, because the wide pixels overwrite the narrow ones behind them.
    for (std::size_t i = image.pixels.size(); i-- > 0;) {
        const std::uint8_t* from = bytes + i * step;
        const Rgba8 pixel = channels == 3   ? Rgba8(from[0], from[1], from[2], 255)
                            : channels == 2 ? Rgba8(from[0], from[0], from[0], from[1])
                                            : Rgba8(from[0], from[0], from[0], 255);
        image.pixels[i] = pixel;
    }
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
    OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(bytes->data()), bytes->size());
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(lower(extension(path)));
    OIIO::ImageSpec opened;
    if (!input || !input->set_ioproxy(&memory) || !input->open(lower(path), opened)) return std::nullopt;
    if (opened.width < 1 || opened.height < 1) return std::nullopt;
    return std::array{opened.width, opened.height};
}

Result<Image> loadImage(const Vfs& files, const std::string& path) {
    const Result<Bytes> bytes = files.read(path);
    if (!bytes) return bytes.error();
    const std::string origin = files.origin(path);
    OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(bytes->data()), bytes->size());
    OIIO::ImageSpec hints;
    // The game's alpha says nothing about the colours: do not multiply them.
    hints.attribute("oiio:UnassociatedAlpha", 1);
    const auto failed = [&](const std::string& why) {
        return Error{origin, "", "is not a readable picture: " + (why.empty() ? "unknown format" : firstLine(why)), ""};
    };
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(lower(extension(path)));
    if (!input) return failed(OIIO::geterror());
    OIIO::ImageSpec opened;
    if (!input->set_ioproxy(&memory) || !input->open(lower(path), opened, hints)) return failed(input->geterror());
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.width > maxSide || spec.height > maxSide ||
        std::int64_t{spec.width} * spec.height > maxPixels)
        return failed(fmt::format("{} x {} pixels are beyond the limits ({} a side, {} in all)", spec.width,
                                  spec.height, maxSide, maxPixels));
    const int channels = std::min(spec.nchannels, 4);
    if (channels < 1) return failed("it has no channels");
    Image image;
    image.width = spec.width;
    image.height = spec.height;
    image.pixels.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, image.pixels.data(), channels))
        return failed(input->geterror());
    expand(image, channels);
    if (flippedByGame(path, *bytes)) flip(image);
    const bool carriesAlpha = channels == 2 || channels == 4;
    image.hasAlpha = carriesAlpha &&
                     std::any_of(image.pixels.begin(), image.pixels.end(), [](const Rgba8& p) { return p.a != 255; });
    return image;
}

} // namespace pie::level
