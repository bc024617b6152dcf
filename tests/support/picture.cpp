#include "tests/support/picture.h"

#include "tests/support/files.h"

#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>

namespace pie::test {
namespace {

namespace oiio = OIIO;

std::size_t pixelCount(const Picture& p) {
    return static_cast<std::size_t>(p.width) * static_cast<std::size_t>(p.height);
}

Picture amplified(const Picture& a, const Picture& b) {
    Picture picture{a.width, a.height, std::vector<std::uint8_t>(a.rgb.size())};
    for (std::size_t i = 0; i < a.rgb.size(); ++i)
        picture.rgb[i] = static_cast<std::uint8_t>(std::min(255, 4 * std::abs(int{a.rgb[i]} - int{b.rgb[i]})));
    return picture;
}

} // namespace

Picture readPicture(const std::filesystem::path& file) {
    const auto input = oiio::ImageInput::open(file.string());
    if (!input) {
        static_cast<void>(oiio::geterror());
        return {};
    }
    const oiio::ImageSpec& spec = input->spec();
    const auto channels = static_cast<std::size_t>(spec.nchannels);
    Picture picture{spec.width, spec.height, {}};
    std::vector<std::uint8_t> stored(pixelCount(picture) * channels);
    if (!input->read_image(0, 0, 0, spec.nchannels, oiio::TypeDesc::UINT8, stored.data())) return {};
    picture.rgb.resize(pixelCount(picture) * 3);
    for (std::size_t i = 0; i < pixelCount(picture); ++i)
        for (std::size_t c = 0; c < 3; ++c) picture.rgb[3 * i + c] = stored[i * channels + (channels < 3 ? 0 : c)];
    return picture;
}

bool writePicture(const std::filesystem::path& file, const Picture& picture) {
    const auto output = oiio::ImageOutput::create(file.string());
    if (!output) {
        static_cast<void>(oiio::geterror());
        return false;
    }
    const oiio::ImageSpec spec(picture.width, picture.height, 3, oiio::TypeDesc::UINT8);
    return output->open(file.string(), spec) && output->write_image(oiio::TypeDesc::UINT8, picture.rgb.data()) &&
           output->close();
}

PictureDifference difference(const Picture& result, const Picture& reference, int limit,
                             const std::vector<std::uint8_t>& mask) {
    PictureDifference found;
    std::size_t counted = 0;
    std::size_t above = 0;
    double sum = 0;
    for (std::size_t i = 0; i < pixelCount(result); ++i) {
        if (!mask.empty() && mask[i] == 0) continue;
        int worst = 0;
        for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) {
            const int off = std::abs(int{result.rgb[c]} - int{reference.rgb[c]});
            sum += off;
            worst = std::max(worst, off);
        }
        ++counted;
        above += worst > limit ? 1 : 0;
        found.largest = std::max(found.largest, worst);
    }
    if (counted == 0) return found;
    found.mean = sum / (3.0 * static_cast<double>(counted));
    found.shareAbove = static_cast<double>(above) / static_cast<double>(counted);
    return found;
}

::testing::AssertionResult similar(const Picture& result, const Picture& reference, double meanAllowed,
                                   const std::string& name, const std::vector<std::uint8_t>& mask) {
    const bool comparable = !result.empty() && result.width == reference.width && result.height == reference.height &&
                            (mask.empty() || mask.size() == pixelCount(result));
    const PictureDifference found = comparable ? difference(result, reference, 16, mask) : PictureDifference{};
    if (comparable && found.mean <= meanAllowed) return ::testing::AssertionSuccess();
    const std::filesystem::path folder = outputFolder();
    const bool written =
        (result.empty() || writePicture(folder / (name + "-result.png"), result)) &&
        (reference.empty() || writePicture(folder / (name + "-reference.png"), reference)) &&
        (!comparable || writePicture(folder / (name + "-difference.png"), amplified(result, reference)));
    const std::string where =
        written ? fmt::format("; see {}/{}-*.png", folder.string(), name) : std::string("; could not be written");
    if (!comparable)
        return ::testing::AssertionFailure() << fmt::format("{}: {}x{} against {}x{}{}", name, result.width,
                                                            result.height, reference.width, reference.height, where);
    return ::testing::AssertionFailure() << fmt::format("{}: mean difference {:.2f} of 255, allowed {:.2f}; largest "
                                                        "{}, {:.1f} % of pixels off by more than 16{}",
                                                        name, found.mean, meanAllowed, found.largest,
                                                        100 * found.shareAbove, where);
}

} // namespace pie::test
