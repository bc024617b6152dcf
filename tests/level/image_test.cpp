#include "pie/level/image.h"
#include "pie/level/vfs.h"
#include "tests/level/make_level.h"
#include "tests/support/files.h"
#include "tests/support/picture.h"

#include <gtest/gtest.h>

using namespace pie;
using namespace pie::level;
using namespace pie::test;

namespace {

Vfs memory(std::vector<std::pair<std::string, Bytes>> files) {
    Vfs vfs;
    vfs.mountMemory("memory", std::move(files));
    return vfs;
}

Rgba8 gradient(int x, int y) {
    return {static_cast<std::uint8_t>(10 * x), static_cast<std::uint8_t>(20 * y), 7,
            static_cast<std::uint8_t>(x == 0 ? 0 : 255)};
}

} // namespace

TEST(Image, TgaKeepsColoursUnderTransparentPixels) {
    const Vfs files = memory({{"a.tga", makeTga(5, 3, gradient)}});
    const Result<Image> image = loadImage(files, "a.tga");
    ASSERT_TRUE(image) << image.error().message();
    ASSERT_EQ(image->width, 5);
    ASSERT_EQ(image->height, 3);
    EXPECT_TRUE(image->hasAlpha);
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 5; ++x)
            EXPECT_EQ(image->pixels[static_cast<std::size_t>(y * 5 + x)], gradient(x, y)) << x << " " << y;
}

TEST(Image, ATopDownTgaIsTakenForABottomUpOneAsInTheGame) {
    const Vfs files = memory({{"a.tga", makeTga(2, 3, gradient, true)}});
    const Result<Image> image = loadImage(files, "a.tga");
    ASSERT_TRUE(image) << image.error().message();
    for (int y = 0; y < 3; ++y) EXPECT_EQ(image->pixels[static_cast<std::size_t>(y * 2 + 1)], gradient(1, 2 - y)) << y;
}

TEST(Image, PngAndJpegComeFromMemoryToo) {
    const TemporaryFolder folder;
    Picture picture{16, 8, {}};
    for (int i = 0; i < 16 * 8; ++i) picture.rgb.insert(picture.rgb.end(), {200, 100, 50});
    for (const char* name : {"a.png", "b.jpg"}) ASSERT_TRUE(writePicture(folder.path() / name, picture));
    const Vfs files = memory(
        {{"a.png", toBytes(readText(folder.path() / "a.png"))}, {"b.jpg", toBytes(readText(folder.path() / "b.jpg"))}});
    for (const char* name : {"a.png", "b.jpg"}) {
        const Result<Image> image = loadImage(files, name);
        ASSERT_TRUE(image) << image.error().message();
        EXPECT_EQ(image->width, 16);
        EXPECT_EQ(image->height, 8);
        EXPECT_FALSE(image->hasAlpha);
        const Vec4 mean = image->mean();
        EXPECT_NEAR(mean.x, 200 / 255.0, 0.01) << name; // JPEG is off by a step or two
        EXPECT_NEAR(mean.y, 100 / 255.0, 0.01) << name;
        EXPECT_NEAR(mean.z, 50 / 255.0, 0.01) << name;
        EXPECT_EQ(mean.w, 1.0F);
    }
}

TEST(Image, TheMeanIsTheMeanTexel) {
    Image image;
    EXPECT_EQ(image.mean(), Vec4(0.0F));
    image.pixels = {Rgba8(0, 255, 51, 255), Rgba8(255, 255, 51, 0)};
    const Vec4 mean = image.mean();
    EXPECT_FLOAT_EQ(mean.x, 0.5F);
    EXPECT_FLOAT_EQ(mean.y, 1.0F);
    EXPECT_FLOAT_EQ(mean.z, 0.2F);
    EXPECT_FLOAT_EQ(mean.w, 0.5F);
}

TEST(Image, NamesAreResolvedInTheGamesOrder) {
    const Bytes any = toBytes("x");
    const Vfs files = memory({{"t/a.jpg", any},
                              {"t/a.png", any},
                              {"t/b.tga", any},
                              {"t/b.jpg", any},
                              {"t/c.jpeg", any},
                              {"t/d.blend.tga", any},
                              {"t/e.png", any}});
    EXPECT_EQ(findImage(files, "t/a"), "t/a.jpg");
    EXPECT_EQ(findImage(files, "t/a.tga"), "t/a.jpg");
    EXPECT_EQ(findImage(files, "t/a.png"), "t/a.png");
    EXPECT_EQ(findImage(files, "t/b"), "t/b.tga");
    EXPECT_EQ(findImage(files, "t/b.jpg"), "t/b.jpg");
    EXPECT_EQ(findImage(files, "t/c.tga"), "t/c.jpeg");
    EXPECT_EQ(findImage(files, "t/d.blend"), "t/d.blend.tga");
    EXPECT_EQ(findImage(files, "t/e.jpg"), "t/e.png");
    EXPECT_EQ(findImage(files, "t/none"), "");
    EXPECT_EQ(findImage(files, "../t/a"), "");
    EXPECT_EQ(findImage(files, ""), "");
}

TEST(Image, DamagedPicturesAreErrorsThatNameTheFile) {
    Bytes cut = makeTga(64, 64, gradient);
    cut.resize(cut.size() / 2);
    Bytes huge = makeTga(1, 1, gradient);
    huge[13] = huge[15] = std::byte{0xff};
    const Vfs files = memory({{"text.jpg", toBytes("no picture")},
                              {"cut.tga", cut},
                              {"huge.tga", huge},
                              {"empty.png", {}},
                              {"x.bmpx", toBytes("BM")}});
    for (const char* name : {"text.jpg", "cut.tga", "huge.tga", "empty.png", "x.bmpx"}) {
        const Result<Image> image = loadImage(files, name);
        ASSERT_FALSE(image) << name;
        const std::string message = image.error().message();
        EXPECT_NE(message.find(std::string("memory/") + name + ": is not a readable picture: "), std::string::npos)
            << message;
        EXPECT_EQ(message.find('\n'), std::string::npos);
    }
    EXPECT_FALSE(loadImage(files, "absent.tga"));
}
