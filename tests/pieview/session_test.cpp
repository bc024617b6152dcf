// The session under commands and saves, without a window.

#include "apps/pieview/session.h"
#include "tests/support/picture.h"
#include "tests/support/room.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

namespace {

namespace fs = std::filesystem;
using namespace pieview;
using pie::engine::View;
using ::testing::HasSubstr;

class SessionTest : public ::testing::Test {
protected:
    void SetUp() override {
        ::setenv("XDG_CONFIG_HOME", (folder_.path() / "config").c_str(), 1);
        pie::test::writeGame(folder_, "room", pie::test::makeRoom());
        settings_.photonsFromLight = 500;
        settings_.stillFrames = 2;
        settings_.gatherRays = 4;
        settings_.maxEdge = 256;
    }
    void TearDown() override { ::unsetenv("XDG_CONFIG_HOME"); }

    [[nodiscard]] std::string level() const { return folder_.path() / "maps/room.bsp"; }
    static bool until(Session& session, const std::function<bool()>& done) {
        for (int i = 0; i < 4000 && !done(); ++i) {
            session.step(0.002, {});
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        return done();
    }
    static bool load(Session& session) {
        return until(session, [&] { return session.level() && !session.loading(); });
    }
    void saveRoom(const std::string& entities) const {
        pie::test::Room room;
        if (!entities.empty()) room.entities = entities;
        const auto error = pie::level::writeBsp(pie::test::makeRoom(room));
        std::ofstream(level(), std::ios::binary)
            .write(reinterpret_cast<const char*>(error.data()), static_cast<std::streamsize>(error.size()));
    }

    pie::test::TemporaryFolder folder_;
    pie::engine::Settings settings_;
};

TEST_F(SessionTest, StartsAtThePlayerStart) {
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    EXPECT_EQ(session.camera().yaw, 90);
    EXPECT_NEAR(session.camera().eye.y, -128, 0.1F);
    EXPECT_TRUE(session.error().empty());
    EXPECT_EQ(session.lights().size(), 1U);
    EXPECT_EQ(session.groupOf(0), "point");
}

TEST_F(SessionTest, ViewsSwitchWithoutReading) {
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    session.run(Command::ViewNormals);
    session.step(0, {});
    EXPECT_EQ(session.level()->views()->view(), View::Normals);
    EXPECT_EQ(session.loads(), 1U);
}

TEST_F(SessionTest, ABrokenSaveKeepsTheLevelAndTheNextOneMendsIt) {
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    osgpie::LevelNode* before = session.level();
    session.setCamera({{1, 2, 3}, 4, 5});
    std::ofstream(level(), std::ios::trunc) << "IBSP";
    ASSERT_TRUE(until(session, [&] { return !session.error().empty(); }));
    EXPECT_THAT(session.error(), HasSubstr("room.bsp"));
    EXPECT_EQ(session.level(), before);
    saveRoom("");
    ASSERT_TRUE(until(session, [&] { return session.error().empty(); }));
    EXPECT_NE(session.level(), before);
    EXPECT_EQ(session.camera(), (Camera{{1, 2, 3}, 4, 5}));
}

TEST_F(SessionTest, PicturesThatAreSavedAreReadAgainToo) {
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    pie::test::Picture picture{16, 16, std::vector<std::uint8_t>(std::size_t{3} * 16 * 16, 90)};
    ASSERT_TRUE(pie::test::writePicture(folder_.path() / "textures/room/plain.png", picture));
    ASSERT_TRUE(until(session, [&] { return session.loads() >= 2; }));
    const auto* texture = session.level()->level().texture("textures/room/plain");
    ASSERT_TRUE(texture && texture->image);
    EXPECT_EQ(texture->image->pixels.front().r, 90);
}

TEST_F(SessionTest, ASaveDuringReadingIsNotLost) {
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    session.run(Command::Reload);
    ASSERT_TRUE(session.loading());
    saveRoom(
        "{\n\"classname\" \"light\"\n\"origin\" \"0 0 1\"\n}\n{\n\"classname\" \"light\"\n\"origin\" \"0 0 2\"\n}\n");
    ASSERT_TRUE(until(session, [&] { return session.lights().size() == 2; }));
    ASSERT_TRUE(until(session, [&] { return !session.loading(); }));
    EXPECT_GE(session.loads(), 2U);
}

TEST_F(SessionTest, ReadingCanBeGivenUp) {
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    session.run(Command::Reload);
    session.run(Command::Cancel);
    EXPECT_FALSE(session.loading());
    for (int i = 0; i < 50; ++i) session.step(0.01, {});
    EXPECT_EQ(session.loads(), 1U);
    EXPECT_TRUE(session.level());
}

TEST_F(SessionTest, LightsSwitchByKeysAndTheEngineHearsOfIt) {
    settings_.recursionDepth = 0; // direct light, which has no noise here
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    auto& engine = session.level()->engine();
    engine.advance();
    std::vector<std::uint32_t> some(32);
    for (std::uint32_t i = 0; i < some.size(); ++i) some[i] = i;
    std::vector<pie::Rgb> light(some.size());
    const auto brightness = [&] {
        for (int i = 0; i < 8; ++i) {
            engine.advance();
            engine.irradiance(some, light);
        }
        float sum = 0;
        for (const pie::Rgb& l : light) sum += pie::meanChannel(l);
        return sum;
    };
    const float before = brightness();
    EXPECT_GT(before, 1);
    session.run(Command::SwitchLight);
    EXPECT_THAT(session.note(), HasSubstr("no light is chosen"));
    session.run(Command::NextLight);
    session.run(Command::SwitchLight);
    session.step(0, {});
    EXPECT_LT(brightness(), 0.05F * before);
    session.run(Command::SwitchGroup);
    session.run(Command::LightBrighter);
    session.step(0, {});
    EXPECT_NEAR(brightness() / before, 1.1F, 0.01F);
    session.run(Command::UndoLights);
    EXPECT_TRUE(session.lights().edits().empty());
}

TEST_F(SessionTest, EditsStayWhenTheLevelIsReadAgain) {
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    session.run(Command::NextLight);
    session.nudge(16, 0, false);
    session.run(Command::Reload);
    ASSERT_TRUE(until(session, [&] { return session.loads() == 2; }));
    ASSERT_EQ(session.lights().edits().size(), 1U);
    EXPECT_NEAR(positionOf(session.lights().light(0))->x, 16, 0.01F) << "looking along +y, right is +x";
    EXPECT_EQ(session.selected(), 0U);
}

TEST_F(SessionTest, SavedLightsAreInTheMapAndWhatWasThereIsBeside) {
    saveRoom("{\n\"classname\" \"info_player_start\"\n\"origin\" \"0 -128 -64\"\n\"angle\" \"90\"\n}\n");
    const std::string before = "// by hand\n{\n\"classname\" \"light\"\n\"origin\" \"0 0 128\"\n\"light\" \"300\"\n}\n";
    const fs::path map = folder_.write("maps/room.map", before);
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    session.run(Command::SaveLights);
    EXPECT_THAT(session.note(), HasSubstr("no light entity is edited"));
    session.run(Command::NextLight);
    session.nudge(16.126F, 0, false); // looking along +y
    session.run(Command::LightBrighter);
    session.step(0, {});
    EXPECT_EQ(session.unsavedLights(), 1U);
    session.run(Command::Quit);
    EXPECT_FALSE(session.ended()) << "not without a word";
    EXPECT_THAT(session.note(), HasSubstr("1 edited light not saved: Ctrl+S saves"));
    const unsigned loads = session.loads();
    session.run(Command::SaveLights);
    EXPECT_THAT(session.note(), HasSubstr("1 light saved to"));
    EXPECT_EQ(pie::test::readText(map),
              "// by hand\n{\n\"classname\" \"light\"\n\"origin\" \"16.13 0 128\"\n\"light\" \"330\"\n}\n");
    EXPECT_EQ(pie::test::readText(map.string() + ".before"), before);
    ASSERT_TRUE(until(session, [&] { return session.loads() > loads && !session.loading(); }));
    EXPECT_TRUE(session.lights().edits().empty()) << "they are the level's now";
    EXPECT_NEAR(positionOf(session.lights().light(0))->x, 16.13F, 1e-3F);
    EXPECT_NEAR(strengthOf(session.lights().light(0)), 330, 0.01F);
    session.run(Command::Quit);
    EXPECT_TRUE(session.ended());
}

TEST_F(SessionTest, LightsOfACompiledLevelAreNotSavedAndThatIsSaid) {
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    const std::string before = pie::test::readText(level());
    session.run(Command::NextLight);
    session.run(Command::LightBrighter);
    session.run(Command::SaveLights);
    EXPECT_THAT(session.note(), HasSubstr("is compiled"));
    EXPECT_EQ(pie::test::readText(level()), before);
    session.run(Command::UndoLight);
    session.run(Command::SwitchLight);
    session.run(Command::SaveLights);
    EXPECT_THAT(session.note(), HasSubstr("1 light switched off, but left on in the level"));
    session.run(Command::Quit);
    EXPECT_TRUE(session.ended()) << "switches are for looking";
}

TEST_F(SessionTest, SettingsThatAreWrongAreSaidAndOthersReadTheLevelAgain) {
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    const auto error = session.change("max_edge", "none");
    ASSERT_TRUE(error);
    EXPECT_THAT(error->message(), HasSubstr("max_edge"));
    EXPECT_FALSE(session.loading());
    const std::size_t before = session.level()->engine().mesh().triangles.size();
    EXPECT_FALSE(session.change("max_edge", "64"));
    ASSERT_TRUE(until(session, [&] { return session.loads() == 2; }));
    EXPECT_GT(session.level()->engine().mesh().triangles.size(), before);
}

TEST_F(SessionTest, BookmarksAndPathAreKeptForTheNextSession) {
    {
        Session session(level(), settings_, Camera{{10, 20, 30}, 40, 5});
        session.run(Command::SetBookmark, 3);
        session.run(Command::AddPathKey);
        session.setCamera({{110, 20, 30}, 40, 5});
        session.run(Command::AddPathKey);
    }
    Session session(level(), settings_);
    ASSERT_TRUE(load(session));
    session.run(Command::GoToBookmark, 3);
    EXPECT_EQ(session.camera(), (Camera{{10, 20, 30}, 40, 5}));
    session.run(Command::PlayPath);
    ASSERT_TRUE(session.playing());
    ASSERT_TRUE(until(session, [&] { return !session.playing(); }));
    EXPECT_NEAR(session.camera().eye.x, 110, 0.5F);
    session.run(Command::GoToBookmark, 4);
    EXPECT_THAT(session.note(), HasSubstr("no bookmark 4"));
}

TEST_F(SessionTest, DamagedNotesAreSaidAndLeftAlone) {
    const fs::path file = notesFile(level());
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "path = [";
    Session session(level(), settings_);
    EXPECT_THAT(session.note(), HasSubstr("mend or remove it"));
    session.run(Command::SetBookmark, 1);
    EXPECT_EQ(pie::test::readText(file), "path = [");
}

TEST_F(SessionTest, WalksOnTheFloorOfTheLevel) {
    Session session(level(), settings_, Camera{{0, 0, 0}, 0, 0});
    ASSERT_TRUE(load(session));
    session.run(Command::Walk);
    for (int i = 0; i < 120; ++i) session.step(1.0 / 60, {});
    EXPECT_NEAR(session.camera().eye.z, -256 + Walker::eyeHeight, 0.5F);
    Held ahead;
    ahead.push = {0, 1, 0};
    for (int i = 0; i < 240; ++i) session.step(1.0 / 60, ahead);
    EXPECT_NEAR(session.camera().eye.x, 256 - Walker::halfWidth, 1);
}

} // namespace
