#pragma once
// Pictures in tests: read, compare, and keep what a failed comparison saw.

#include <cstdint>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace pie::test {

/// 8-bit RGB, first row at the top.
struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
    [[nodiscard]] bool empty() const { return rgb.empty(); }
};

/// PNG, PPM, TGA or JPEG; grey is spread, alpha dropped. Empty if it cannot be read.
[[nodiscard]] Picture readPicture(const std::filesystem::path& file);
/// The format follows the extension. False if it cannot be written.
[[nodiscard]] bool writePicture(const std::filesystem::path& file, const Picture& picture);

/// In steps of 8-bit channels.
struct PictureDifference {
    double mean = 0; ///< absolute, over all channels
    int largest = 0;
    double shareAbove = 0; ///< of pixels with a channel off by more than `limit`
};
/// Pictures of the same size. `mask`: one value per pixel, 0 leaves the pixel out; empty: all count.
[[nodiscard]] PictureDifference difference(const Picture& result, const Picture& reference, int limit = 16,
                                           const std::vector<std::uint8_t>& mask = {});

/// Fails when sizes differ or the mean absolute difference is larger than allowed; then writes NAME-result.png,
/// NAME-reference.png and NAME-difference.png (four times the difference) to `outputFolder` and says so.
[[nodiscard]] ::testing::AssertionResult similar(const Picture& result, const Picture& reference, double meanAllowed,
                                                 const std::string& name, const std::vector<std::uint8_t>& mask = {});

} // namespace pie::test
