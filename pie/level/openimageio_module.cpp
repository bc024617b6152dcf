#include "pie/level/openimageio_module.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <exception>
#include <memory>

namespace pie::level {
namespace {

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

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

/// The picture, or why there is none.
std::string decode(OIIO::ImageInput& input, Image& image) {
    const OIIO::ImageSpec& spec = input.spec();
    if (spec.depth > 1) return "it has depth";
    if (std::string defect = sizeDefect(spec.width, spec.height); !defect.empty()) return defect;
    const int channels = std::min(spec.nchannels, 4);
    if (channels < 1) return "it has no channels";
    image.width = spec.width;
    image.height = spec.height;
    image.pixels.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
    if (!input.read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, image.pixels.data(), channels))
        return firstLine(input.geterror());
    expand(image, channels);
    const bool carriesAlpha = channels == 2 || channels == 4;
    image.hasAlpha = carriesAlpha &&
                     std::any_of(image.pixels.begin(), image.pixels.end(), [](const Rgba8& p) { return p.a != 255; });
    return {};
}

void read(std::span<const std::byte> bytes, const std::string& extension, Decoding& result,
          std::optional<PictureSize>* size) {
    OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(bytes.data()), bytes.size());
    OIIO::ImageSpec hints;
    // The game's alpha says nothing about the colours: do not multiply them.
    hints.attribute("oiio:UnassociatedAlpha", 1);
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(extension);
    if (!input) {
        result.failure = firstLine(OIIO::geterror());
        return;
    }
    OIIO::ImageSpec opened;
    if (!input->set_ioproxy(&memory) || !input->open("picture." + extension, opened, hints)) {
        result.failure = firstLine(input->geterror());
        return;
    }
    if (size != nullptr) {
        *size = PictureSize{opened.width, opened.height};
        return;
    }
    Image image;
    result.failure = decode(*input, image);
    if (result.failure.empty()) result.image = std::move(image);
}

} // namespace
} // namespace pie::level

extern "C" __attribute__((visibility("default"))) void pieOpenImageIo1(std::span<const std::byte> bytes,
                                                                       const std::string& extension,
                                                                       pie::level::Decoding& result,
                                                                       std::optional<pie::level::PictureSize>* size) {
    try {
        pie::level::read(bytes, extension, result, size);
    } catch (const std::exception& error) {
        result.failure = error.what();
    }
}
