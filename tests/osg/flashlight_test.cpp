// The light at the view: what is ahead gets lighter, and follows when the view turns.

#include "tests/level/make_level.h"
#include "tests/osg/offscreen.h"
#include "tests/osg/scene_reading.h"

#include <osg/ValueObject>

#include <gtest/gtest.h>

namespace {

using namespace pie;
using namespace pie::test;

double brightness(const Picture& picture) {
    double sum = 0;
    for (const std::uint8_t value : picture.rgb) sum += value;
    return picture.empty() ? -1 : sum / static_cast<double>(picture.rgb.size());
}

class FlashlightView : public ::testing::Test {
protected:
    void SetUp() override {
        PIE_NEED_DISPLAY();
        game_.addPicture("t/plain", {160, 160, 160, 255});
    }
    [[nodiscard]] osg::ref_ptr<osg::Node> read(const std::string& options) const {
        LevelBuilder builder;
        const int plain = builder.shader("t/plain");
        builder.room({-256, -256, -128}, {256, 256, 128}, {plain, plain, plain, plain, plain, plain});
        builder.entity({{"classname", "light"}, {"origin", "0 0 100"}, {"light", "20"}});
        return readNode(game_.addLevel("dim", builder.build()),
                        "photons_from_light=2000 still_frames=4 accumulation_frames=4 max_edge=64 " + options);
    }

private:
    Game game_;
};

TEST_F(FlashlightView, LightsWhatIsAheadAndFollows) {
    const osg::ref_ptr<osg::Node> without = read("");
    const osg::ref_ptr<osg::Node> with = read("flashlight=true flashlight_intensity=1000");
    ASSERT_TRUE(without && with);
    Shot ahead = lookingAt({0, -100, 0}, {0, 256, 0});
    ahead.frames = 12;
    const double dim = brightness(render(*without, ahead));
    const double lit = brightness(render(*with, ahead));
    EXPECT_GT(lit, dim + 20);
    // The same node, turned round: what is ahead now is as light, for the room is the same on both sides.
    Shot behind = lookingAt({0, 100, 0}, {0, -256, 0});
    behind.frames = 12;
    EXPECT_NEAR(brightness(render(*with, behind)), lit, 3);
}

TEST_F(FlashlightView, StandsStillWhenTheViewDoes) {
    const osg::ref_ptr<osg::Node> node = read("flashlight=true");
    ASSERT_TRUE(node);
    Shot ahead = lookingAt({0, -100, 0}, {0, 256, 0});
    ahead.frames = 60;
    const std::vector<std::vector<Picture>> frames = renderFrames(*node, ahead);
    ASSERT_FALSE(frames.empty());
    bool settled = false;
    EXPECT_TRUE(node->getUserValue("pie.settled", settled));
    EXPECT_TRUE(settled);
    EXPECT_EQ(frames[0].back().rgb, frames[0][58].rgb);
}

} // namespace
