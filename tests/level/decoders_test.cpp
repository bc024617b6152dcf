// Our own decoders, on pictures made byte by byte.

#include "pie/level/decoders.h"
#include "tests/support/files.h"
#include "tests/support/picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

using namespace pie;
using namespace pie::level;
using namespace pie::test;

namespace {

using Raw = std::vector<std::byte>;

Raw tgaHead(int kind, int width, int height, int bits, int descriptor = 0) {
    Raw bytes(18);
    bytes[2] = static_cast<std::byte>(kind);
    bytes[12] = static_cast<std::byte>(width & 255);
    bytes[13] = static_cast<std::byte>(width >> 8);
    bytes[14] = static_cast<std::byte>(height & 255);
    bytes[15] = static_cast<std::byte>(height >> 8);
    bytes[16] = static_cast<std::byte>(bits);
    bytes[17] = static_cast<std::byte>(descriptor);
    return bytes;
}

void append(Raw& bytes, std::initializer_list<int> more) {
    for (const int value : more) bytes.push_back(static_cast<std::byte>(value));
}

/// Rows top first.
std::vector<Rgba8> pixelsOf(const std::optional<Decoding>& decoded) {
    if (!decoded || !decoded->image) return {};
    return {decoded->image->pixels.begin(), decoded->image->pixels.end()};
}

Raw bytesOfFile(const std::filesystem::path& file) {
    const std::string text = readText(file);
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
}

/// A JPEG of 48 × 32 pixels, written by OpenImageIO.
Raw jpeg(const TemporaryFolder& folder) {
    Picture picture{48, 32, {}};
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 48; ++x)
            picture.rgb.insert(picture.rgb.end(),
                               {static_cast<std::uint8_t>(5 * x), static_cast<std::uint8_t>(7 * y), 90});
    EXPECT_TRUE(writePicture(folder.path() / "a.jpg", picture));
    return bytesOfFile(folder.path() / "a.jpg");
}

} // namespace

TEST(Tga, ColourWithoutAlphaIsOpaqueAndStartsBelow) {
    Raw bytes = tgaHead(2, 1, 2, 24);
    append(bytes, {1, 2, 3, 4, 5, 6});
    EXPECT_EQ(pixelsOf(decodeTga(bytes)), (std::vector<Rgba8>{{6, 5, 4, 255}, {3, 2, 1, 255}}));
    EXPECT_FALSE(decodeTga(bytes)->image->hasAlpha);
}

TEST(Tga, GreyIsSpread) {
    Raw bytes = tgaHead(3, 2, 1, 8);
    append(bytes, {9, 200});
    EXPECT_EQ(pixelsOf(decodeTga(bytes)), (std::vector<Rgba8>{{9, 9, 9, 255}, {200, 200, 200, 255}}));
}

TEST(Tga, ACommentIsSkipped) {
    Raw bytes = tgaHead(3, 1, 1, 8);
    bytes[0] = std::byte{3};
    append(bytes, {70, 71, 72, 50});
    EXPECT_EQ(pixelsOf(decodeTga(bytes)), (std::vector<Rgba8>{{50, 50, 50, 255}}));
}

TEST(Tga, PacketsGoOnInTheNextRow) {
    Raw bytes = tgaHead(10, 3, 2, 32);
    append(bytes, {0x80 | 3, 1, 2, 3, 4}); // four alike: a row and one
    append(bytes, {1, 5, 6, 7, 8, 9, 10, 11, 255});
    const Rgba8 same(3, 2, 1, 4);
    EXPECT_EQ(pixelsOf(decodeTga(bytes)), (std::vector<Rgba8>{same, {7, 6, 5, 8}, {11, 10, 9, 255}, same, same, same}));
    EXPECT_TRUE(decodeTga(bytes)->image->hasAlpha);
}

TEST(Tga, APacketThatIsLongerThanThePictureIsCut) {
    Raw bytes = tgaHead(10, 1, 1, 24);
    append(bytes, {0x80 | 127, 1, 2, 3});
    EXPECT_EQ(pixelsOf(decodeTga(bytes)), (std::vector<Rgba8>{{3, 2, 1, 255}}));
}

TEST(Tga, EveryCutIsAnError) {
    for (const bool packed : {false, true}) {
        Raw bytes = tgaHead(packed ? 10 : 2, 3, 2, 24);
        if (packed)
            append(bytes, {0x80 | 2, 1, 2, 3, 2, 1, 2, 3, 4, 5, 6, 7, 8, 9});
        else
            for (int i = 0; i < 18; ++i) append(bytes, {i});
        ASSERT_TRUE(decodeTga(bytes)->image);
        for (std::size_t size = 18; size < bytes.size(); ++size) {
            const auto decoded = decodeTga(std::span(bytes).first(size));
            ASSERT_TRUE(decoded);
            EXPECT_FALSE(decoded->image) << packed << " " << size;
            EXPECT_EQ(decoded->failure, "it ends before its last row");
        }
    }
}

TEST(Tga, SizesBeyondTheLimitsAreRefusedBeforeAnythingIsAllocated) {
    const auto decoded = decodeTga(tgaHead(2, 65535, 65535, 32));
    ASSERT_TRUE(decoded);
    EXPECT_FALSE(decoded->image);
    EXPECT_EQ(decoded->failure, "65535 x 65535 pixels are beyond the limits (16384 a side, 67108864 in all)");
    EXPECT_NE(decodeTga(tgaHead(2, 0, 5, 32))->failure, "");
}

TEST(Tga, WhatTheGameDoesNotKnowIsLeftToOthers) {
    EXPECT_FALSE(decodeTga(Raw(17)));
    EXPECT_FALSE(decodeTga(tgaHead(1, 1, 1, 8)));        // palette
    EXPECT_FALSE(decodeTga(tgaHead(2, 1, 1, 16)));       // 15 or 16 bits
    EXPECT_FALSE(decodeTga(tgaHead(11, 1, 1, 8)));       // packed grey
    EXPECT_FALSE(decodeTga(tgaHead(2, 1, 1, 24, 0x10))); // right to left
}

TEST(Jpeg, IsWhatOpenImageIoMakesOfIt) {
    const TemporaryFolder folder;
    const Raw bytes = jpeg(folder);
    const auto ours = decodeJpeg(bytes);
    ASSERT_TRUE(ours);
    ASSERT_TRUE(ours->image) << ours->failure;
    const Decoding other = decodeOther(bytes, "jpg");
    ASSERT_TRUE(other.image) << other.failure;
    EXPECT_EQ(ours->image->width, 48);
    EXPECT_EQ(ours->image->height, 32);
    EXPECT_FALSE(ours->image->hasAlpha);
    EXPECT_EQ(ours->image->pixels, other.image->pixels);
}

TEST(Jpeg, EveryCutIsAnErrorOrNoJpeg) {
    const TemporaryFolder folder;
    const Raw bytes = jpeg(folder);
    // The last two bytes are the end mark, which libjpeg can do without.
    for (std::size_t size = 0; size + 2 < bytes.size(); ++size) {
        const auto decoded = decodeJpeg(std::span(bytes).first(size));
        if (size <= 2) {
            EXPECT_FALSE(decoded) << size;
            continue;
        }
        ASSERT_TRUE(decoded) << size;
        EXPECT_FALSE(decoded->image) << size;
        EXPECT_NE(decoded->failure, "") << size;
    }
}

TEST(Jpeg, DamagedBytesNeverBreakAnything) {
    const TemporaryFolder folder;
    const Raw bytes = jpeg(folder);
    for (std::size_t at = 2; at < bytes.size(); ++at)
        for (const std::byte value : {std::byte{0}, std::byte{0xff}, bytes[at] ^ std::byte{0x10}}) {
            Raw damaged = bytes;
            damaged[at] = value;
            // The head alone decides the size; within the limits there is a picture, or a reason why there is none.
            if (const auto size = jpegSize(damaged); size && size->width * size->height > 1'000'000) continue;
            const auto decoded = decodeJpeg(damaged);
            EXPECT_TRUE(!decoded || decoded->image.has_value() == decoded->failure.empty()) << at;
        }
}

TEST(PictureSizes, ComeFromTheHead) {
    const TemporaryFolder folder;
    const Raw bytes = jpeg(folder);
    EXPECT_EQ(jpegSize(bytes)->width, 48);
    EXPECT_EQ(jpegSize(bytes)->height, 32);
    EXPECT_EQ(otherSize(bytes, "jpg")->width, 48);
    EXPECT_EQ(tgaSize(tgaHead(2, 300, 7, 24))->width, 300);
    EXPECT_EQ(tgaSize(tgaHead(2, 300, 7, 24))->height, 7);
    EXPECT_FALSE(tgaSize(tgaHead(1, 300, 7, 8)));
    EXPECT_FALSE(jpegSize(tgaHead(2, 300, 7, 24)));
}
