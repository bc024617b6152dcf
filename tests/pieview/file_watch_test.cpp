// A save is seen however an editor makes it, and nothing else is taken for one.

#include "apps/pieview/file_watch.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <fcntl.h>
#include <fstream>
#include <unistd.h>

namespace {

namespace fs = std::filesystem;
using pie::test::TemporaryFolder;

class Watching : public ::testing::Test {
protected:
    void write(const fs::path& file, const std::string& text) const { std::ofstream(file) << text; }

    TemporaryFolder folder_;
    fs::path file_ = folder_.write("maps/x.map", "first");
};

TEST_F(Watching, SeesAFileWrittenOver) {
    pieview::FileWatch watch({file_});
    EXPECT_FALSE(watch.changed());
    write(file_, "second");
    EXPECT_TRUE(watch.changed());
    EXPECT_FALSE(watch.changed());
}

TEST_F(Watching, SeesAFileRenamedOverTwice) {
    pieview::FileWatch watch({file_});
    for (int i = 0; i < 2; ++i) {
        write(folder_.path() / "maps/x.map.tmp", "next");
        EXPECT_FALSE(watch.changed()) << "another file";
        fs::rename(folder_.path() / "maps/x.map.tmp", file_);
        EXPECT_TRUE(watch.changed());
    }
}

TEST_F(Watching, SeesAFileRemovedAndWrittenAnew) {
    pieview::FileWatch watch({file_});
    fs::remove(file_);
    EXPECT_FALSE(watch.changed()) << "there is nothing to read";
    write(file_, "anew");
    EXPECT_TRUE(watch.changed());
}

TEST_F(Watching, WaitsUntilAFileIsClosed) {
    pieview::FileWatch watch({file_});
    const int descriptor = ::open(file_.c_str(), O_WRONLY | O_TRUNC);
    ASSERT_GE(descriptor, 0);
    ASSERT_EQ(::write(descriptor, "half", 4), 4);
    EXPECT_FALSE(watch.changed());
    ::close(descriptor);
    EXPECT_TRUE(watch.changed());
}

TEST_F(Watching, OutlivesItsFolder) {
    pieview::FileWatch watch({file_});
    fs::remove_all(folder_.path() / "maps");
    (void)watch.changed();
    (void)folder_.write("maps/x.map", "back");
    bool seen = false;
    for (int i = 0; i < 100 && !seen; ++i) { // twice a second it is looked for
        seen = watch.changed();
        ::usleep(20'000);
    }
    EXPECT_TRUE(seen);
}

TEST_F(Watching, WhatALevelIsReadFrom) {
    const fs::path bsp = folder_.write("maps/y.bsp", "");
    EXPECT_EQ(pieview::filesOfLevel(bsp), (std::vector<fs::path>{bsp, folder_.path() / "maps/y.map"}));
    const fs::path archive = folder_.write("pak.pk3", "");
    EXPECT_EQ(pieview::filesOfLevel(archive / "maps/z.map"), std::vector<fs::path>{archive});
    const fs::path link = folder_.path() / "link.map";
    fs::create_symlink(file_, link);
    EXPECT_EQ(pieview::filesOfLevel(link), (std::vector<fs::path>{link, fs::canonical(file_)}));
}

} // namespace
