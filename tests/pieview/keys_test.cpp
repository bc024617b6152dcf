// One table of keys: no key means two things, and the manual says what the program does.

#include "apps/pieview/keys.h"
#include "tests/support/files.h"

#include <GLFW/glfw3.h>
#include <gmock/gmock.h>

#include <set>

namespace {

using pieview::Command;

TEST(PieviewKeys, NoKeyMeansTwoThings) {
    std::set<std::pair<int, int>> keys;
    std::set<Command> commands;
    for (const auto& binding : pieview::bindings()) {
        EXPECT_FALSE(binding.keys.empty());
        EXPECT_FALSE(binding.what.empty());
        const bool first = binding.command == Command::None || commands.insert(binding.command).second;
        EXPECT_TRUE(first) << binding.keys;
        if (binding.key == 0) continue;
        EXPECT_TRUE(keys.insert({binding.key, binding.modifiers}).second) << binding.keys;
        EXPECT_EQ(pieview::commandOf(binding.key, binding.modifiers), binding.command) << binding.keys;
    }
}

TEST(PieviewKeys, EveryCommandHasAKey) {
    for (int i = 1; i <= static_cast<int>(Command::VerticalSync); ++i)
        EXPECT_FALSE(pieview::keysOf(static_cast<Command>(i)).empty()) << i;
}

TEST(PieviewKeys, DigitsAreBookmarksAndModifiersCount) {
    EXPECT_EQ(pieview::commandOf(GLFW_KEY_7, 0), Command::GoToBookmark);
    EXPECT_EQ(pieview::commandOf(GLFW_KEY_7, GLFW_MOD_CONTROL), Command::SetBookmark);
    EXPECT_EQ(pieview::commandOf(GLFW_KEY_K, GLFW_MOD_SHIFT | GLFW_MOD_NUM_LOCK), Command::PlayPath);
    EXPECT_EQ(pieview::commandOf(GLFW_KEY_K, GLFW_MOD_ALT), Command::None);
}

TEST(PieviewKeys, StandInTheManual) {
    EXPECT_THAT(pie::test::readText(PIE_MANUAL), ::testing::HasSubstr(pieview::keysPage()))
        << "put this into “The window”:\n"
        << pieview::keysPage();
}

} // namespace
