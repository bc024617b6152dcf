// The helpers themselves: a comparison that cannot fail would let every picture pass.

#include "tests/support/command.h"
#include "tests/support/display.h"
#include "tests/support/files.h"
#include "tests/support/picture.h"

#include <csignal>
#include <cstdlib>
#include <gmock/gmock.h>

namespace pie::test {
namespace {

using ::testing::HasSubstr;

Picture plain(int width, int height, std::uint8_t value) {
    return {width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height) * 3, value)};
}

TEST(TemporaryFolder, IsRemovedWithItsFiles) {
    std::filesystem::path path;
    {
        const TemporaryFolder folder;
        path = folder.path();
        EXPECT_EQ(readText(folder.write("a/b.txt", "text")), "text");
    }
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Command, KeepsStatusAndBothStreams) {
    const CommandResult result = run({"sh", "-c", "echo out; echo err >&2; exit 3"});
    EXPECT_EQ(result.status, 3);
    EXPECT_EQ(result.out, "out\n");
    EXPECT_EQ(result.err, "err\n");
    EXPECT_FALSE(result.timedOut);
}

TEST(Command, PassesArgumentsEnvironmentAndFolder) {
    ::setenv("PIE_TEST_GONE", "here", 1);
    const CommandResult result =
        run({"sh", "-c", R"(printf '%s|%s|%s|%s' "$1" "$PIE_TEST_SET" "${PIE_TEST_GONE-unset}" "$PWD")", "sh", "a b"},
            {{{"PIE_TEST_SET", "x y"}, {"PIE_TEST_GONE", ""}}, "/", 10});
    EXPECT_EQ(result.out, "a b|x y|unset|/");
}

TEST(Command, ReportsSignalsTimeoutsAndMissingPrograms) {
    EXPECT_EQ(run({"sh", "-c", "kill -SEGV $$"}).status, 128 + SIGSEGV);
    EXPECT_EQ(run({"no-such-program-anywhere"}).status, 127);
    const CommandResult slow = run({"sh", "-c", "sleep 60 & sleep 60"}, {{}, "", 0.2});
    EXPECT_TRUE(slow.timedOut);
    EXPECT_EQ(slow.status, 128 + SIGKILL);
}

TEST(Picture, SurvivesPngAndPpm) {
    const TemporaryFolder folder;
    Picture picture = plain(5, 3, 0);
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) picture.rgb[i] = static_cast<std::uint8_t>(5 * i);
    for (const char* name : {"a.png", "a.ppm"}) {
        ASSERT_TRUE(writePicture(folder.path() / name, picture)) << name;
        const Picture read = readPicture(folder.path() / name);
        EXPECT_EQ(read.width, 5);
        EXPECT_EQ(read.height, 3);
        EXPECT_EQ(read.rgb, picture.rgb) << name;
    }
    EXPECT_TRUE(readPicture(folder.path() / "none.png").empty());
    EXPECT_TRUE(readPicture(folder.write("broken.png", "no picture")).empty());
}

TEST(Picture, DifferenceCountsWhatTheMaskLeaves) {
    const Picture reference = plain(4, 1, 100);
    Picture result = reference;
    result.rgb[0] = 130;
    result.rgb[3] = 90;
    const PictureDifference all = difference(result, reference);
    EXPECT_DOUBLE_EQ(all.mean, 40.0 / 12.0);
    EXPECT_EQ(all.largest, 30);
    EXPECT_DOUBLE_EQ(all.shareAbove, 0.25);
    const PictureDifference masked = difference(result, reference, 16, {0, 1, 1, 1});
    EXPECT_DOUBLE_EQ(masked.mean, 10.0 / 9.0);
    EXPECT_DOUBLE_EQ(masked.shareAbove, 0.0);
}

TEST(Picture, SimilarFailsAndLeavesThreePictures) {
    const TemporaryFolder folder;
    ::setenv("PIE_TEST_OUTPUT", folder.path().c_str(), 1);
    const Picture reference = plain(4, 4, 100);
    const Picture result = plain(4, 4, 103);
    EXPECT_TRUE(similar(result, reference, 3.0, "near"));
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "near-result.png"));
    const ::testing::AssertionResult failed = similar(result, reference, 2.9, "far");
    EXPECT_FALSE(failed);
    EXPECT_THAT(failed.message(), HasSubstr("mean difference 3.00"));
    EXPECT_EQ(readPicture(folder.path() / "far-result.png").rgb, result.rgb);
    EXPECT_EQ(readPicture(folder.path() / "far-reference.png").rgb, reference.rgb);
    EXPECT_EQ(readPicture(folder.path() / "far-difference.png").rgb, plain(4, 4, 12).rgb);
    EXPECT_FALSE(similar(result, plain(4, 5, 103), 255, "sizes"));
    EXPECT_FALSE(similar({}, reference, 255, "nothing"));
    ::unsetenv("PIE_TEST_OUTPUT");
}

TEST(VirtualDisplay, TwoAtOnceHaveTheirOwnNumbers) {
    const auto first = VirtualDisplay::start(64, 64);
    if (!first) GTEST_SKIP() << "needs a virtual display: apt-get install xvfb";
    const auto second = VirtualDisplay::start(64, 64);
    ASSERT_TRUE(second);
    EXPECT_NE(first->name(), second->name());
    EXPECT_EQ(first->name().front(), ':');
}

} // namespace
} // namespace pie::test
