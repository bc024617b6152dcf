// libpng's pictures against OpenImageIO's, for every kind that the format has.

#include "pie/level/decoders.h"

#include <gtest/gtest.h>

#include <png.h>

#include <algorithm>
#include <array>
#include <random>
#include <string>

using namespace pie;
using namespace pie::level;

namespace {

using Raw = std::vector<std::byte>;

struct Kind {
    int colour = PNG_COLOR_TYPE_RGB;
    int depth = 8;
    int interlace = PNG_INTERLACE_NONE;
    bool see = false; ///< with a transparent colour, or palette entries that are
};

void append(png_structp png, png_bytep bytes, std::size_t count) {
    auto& to = *static_cast<Raw*>(png_get_io_ptr(png));
    const auto* first = reinterpret_cast<const std::byte*>(bytes);
    to.insert(to.end(), first, first + count);
}

/// Noise, 13 × 11.
Raw noise(const Kind& kind) {
    constexpr png_uint_32 width = 13;
    constexpr png_uint_32 height = 11;
    Raw bytes;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(png, &bytes, append, nullptr);
    png_set_IHDR(png, info, width, height, kind.depth, kind.colour, kind.interlace, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    std::mt19937 random(7);
    std::vector<png_color> palette(1U << static_cast<unsigned>(std::min(kind.depth, 8)));
    for (png_color& c : palette)
        c = {static_cast<png_byte>(random()), static_cast<png_byte>(random()), static_cast<png_byte>(random())};
    std::vector<png_byte> alphas(palette.size(), 255);
    alphas[1] = 40;
    png_color_16 clear{};
    if (kind.colour == PNG_COLOR_TYPE_PALETTE) {
        png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
        if (kind.see) png_set_tRNS(png, info, alphas.data(), static_cast<int>(alphas.size()), nullptr);
    } else if (kind.see) {
        png_set_tRNS(png, info, nullptr, 0, &clear);
    }
    png_write_info(png, info);
    const std::size_t row = png_get_rowbytes(png, info);
    std::vector<png_byte> rows(row * height);
    for (png_byte& value : rows) value = static_cast<png_byte>(random());
    if (kind.see) std::fill_n(rows.begin(), 6, png_byte{0}); // the transparent colour comes up
    std::vector<png_bytep> starts;
    for (png_uint_32 y = 0; y < height; ++y) starts.push_back(rows.data() + y * row);
    png_write_image(png, starts.data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return bytes;
}

} // namespace

TEST(Png, EveryKindIsWhatOpenImageIoMakesOfIt) {
    struct Format {
        int colour;
        std::vector<int> depths;
        bool canSee;
    };
    for (const Format& format :
         {Format{PNG_COLOR_TYPE_GRAY, {1, 2, 4, 8, 16}, true}, Format{PNG_COLOR_TYPE_RGB, {8, 16}, true},
          Format{PNG_COLOR_TYPE_PALETTE, {1, 2, 4, 8}, true}, Format{PNG_COLOR_TYPE_GRAY_ALPHA, {8, 16}, false},
          Format{PNG_COLOR_TYPE_RGB_ALPHA, {8, 16}, false}})
        for (const int depth : format.depths)
            for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7})
                for (const bool see : {false, true}) {
                    if (see && !format.canSee) continue;
                    SCOPED_TRACE("colour " + std::to_string(format.colour) + ", depth " + std::to_string(depth) +
                                 ", interlace " + std::to_string(interlace) + ", see-through " + std::to_string(see));
                    const Raw bytes = noise({format.colour, depth, interlace, see});
                    const auto ours = decodePng(bytes);
                    ASSERT_TRUE(ours);
                    ASSERT_TRUE(ours->image) << ours->failure;
                    const Decoding other = decodeOther(bytes, "png");
                    ASSERT_TRUE(other.image) << other.failure;
                    EXPECT_EQ(ours->image->width, 13);
                    EXPECT_EQ(ours->image->height, 11);
                    EXPECT_EQ(ours->image->hasAlpha, other.image->hasAlpha);
                    EXPECT_EQ(ours->image->pixels, other.image->pixels);
                    EXPECT_EQ(pngSize(bytes)->width, 13);
                    EXPECT_EQ(pngSize(bytes)->height, 11);
                }
}

TEST(Png, EveryCutIsAnErrorOrNoPng) {
    const Raw bytes = noise({PNG_COLOR_TYPE_RGB, 8, PNG_INTERLACE_ADAM7, false});
    constexpr std::size_t signature = 8;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        const auto decoded = decodePng(std::span(bytes).first(size));
        if (size <= signature) {
            EXPECT_FALSE(decoded) << size;
            continue;
        }
        ASSERT_TRUE(decoded) << size;
        EXPECT_FALSE(decoded->image) << size;
        EXPECT_NE(decoded->failure, "") << size;
    }
}

TEST(Png, DamagedBytesNeverBreakAnything) {
    const Raw whole = noise({PNG_COLOR_TYPE_PALETTE, 4, PNG_INTERLACE_NONE, true});
    for (std::size_t i = 0; i < whole.size(); ++i)
        for (const int flip : {1, 0x40, 0xff}) {
            Raw bytes = whole;
            bytes[i] ^= static_cast<std::byte>(flip);
            const auto decoded = decodePng(bytes);
            if (!decoded) continue; // the signature
            EXPECT_EQ(decoded->image.has_value(), decoded->failure.empty()) << i;
        }
}

TEST(Png, SizesBeyondTheLimitsAreRefusedBeforeAnythingIsAllocated) {
    Raw bytes = noise({PNG_COLOR_TYPE_RGB, 8, PNG_INTERLACE_NONE, false});
    // Width 0x00010000, with the check sum that goes with it.
    const std::array<int, 4> width{0, 1, 0, 0};
    for (std::size_t i = 0; i < 4; ++i) bytes[16 + i] = static_cast<std::byte>(width.at(i));
    std::uint32_t sum = 0xffffffffU;
    for (std::size_t i = 12; i < 29; ++i) {
        sum ^= static_cast<std::uint32_t>(bytes[i]);
        for (int bit = 0; bit < 8; ++bit) sum = (sum >> 1U) ^ ((sum & 1U) != 0 ? 0xedb88320U : 0U);
    }
    sum = ~sum;
    for (std::size_t i = 0; i < 4; ++i) bytes[29 + i] = static_cast<std::byte>(sum >> (24U - 8U * i));
    const auto decoded = decodePng(bytes);
    ASSERT_TRUE(decoded);
    EXPECT_FALSE(decoded->image);
    EXPECT_EQ(decoded->failure, "65536 x 11 pixels are beyond the limits (16384 a side, 67108864 in all)");
}
