// The levels that Debian ships, through the plug-in and into a picture.

#include "osgPlugins/osgpie/material_program.h"
#include "pie/level/level.h"
#include "tests/osg/link_check.h"
#include "tests/osg/offscreen.h"
#include "tests/osg/ray_picture.h"
#include "tests/osg/scene_reading.h"
#include "tests/support/game_data.h"

#include <gmock/gmock.h>

#include <osg/ComputeBoundsVisitor>

#include <algorithm>
#include <cmath>
#include <set>

namespace {

using namespace pie;
using namespace pie::test;
using osgpie::LightSource;

level::Level load(const std::string& name, bool images) {
    level::LoadOptions options;
    options.images = images;
    auto loaded = level::loadLevel(level::Location{GameData::instance().files, name}, options);
    EXPECT_TRUE(loaded) << loaded.error().message();
    return loaded ? std::move(*loaded) : level::Level{};
}

osg::ref_ptr<osg::Node> readShipped(const std::string& name, const std::string& options) {
    return readNode(name, options + " game=" + GameData::instance().folder.string());
}

void expectBox(const osg::BoundingBox& seen, const Box& expected, const std::string& name) {
    const Vec3 size = expected.upper - expected.lower;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<unsigned>(axis);
        EXPECT_NEAR(seen._min[a], expected.lower[axis], 1e-3F * size[axis]) << name;
        EXPECT_NEAR(seen._max[a], expected.upper[axis], 1e-3F * size[axis]) << name;
    }
}

/// Area and bounds of the graph against what the library counted while loading (which tests/level compares with a
/// second reading of the file).
void expectWholeLevel(const std::string& name, const std::string& options) {
    const level::Level level = load(name, false);
    const osg::ref_ptr<osg::Node> node = readShipped(name, options);
    ASSERT_TRUE(node) << name;
    EXPECT_NEAR(areaOf(trianglesOf(*node)), level.statistics.drawnArea, 1e-3 * level.statistics.drawnArea) << name;
    osg::ComputeBoundsVisitor bounds;
    node->accept(bounds);
    expectBox(bounds.getBoundingBox(), level.statistics.drawnBounds, name);
}

class ShippedPicture : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Levels, ShippedPicture, ::testing::Values("oa_dm1", "oa_dm4", "wrackdm17"));

} // namespace

TEST(Shipped, TwentyLevelsAreWhole) {
    PIE_NEED_GAME_DATA();
    const auto& levels = GameData::instance().levels;
    const std::size_t step = std::max<std::size_t>(1, levels.size() / 20);
    std::size_t read = 0;
    for (std::size_t i = 0; i < levels.size() && read < 20; i += step, ++read)
        expectWholeLevel(levels[i], "view=fullbright");
    EXPECT_EQ(read, std::min<std::size_t>(20, levels.size()));
}

TEST(Shipped, RefinedLevelsAreWhole) {
    PIE_NEED_GAME_DATA();
    for (const char* name : {"maps/oa_dm1.bsp", "maps/am_thornish.bsp"})
        if (GameData::instance().files.contains(name)) expectWholeLevel(name, "view=lit");
}

TEST(Shipped, EveryShaderOfTheGameLinks) {
    PIE_NEED_GAME_DATA();
    PIE_NEED_DISPLAY();
    LinkCheck check;
    if (!check.ready()) GTEST_SKIP() << noDisplay;
    const level::ShaderLibrary library = level::ShaderLibrary::load(GameData::instance().files);
    std::set<std::pair<std::string, std::string>> seen;
    std::vector<std::string> faults;
    const auto link = [&](const osgpie::MaterialProgram& program, const std::string& name) {
        if (!program.visible || !seen.emplace(program.vertexSource, program.fragmentSource).second) return;
        const std::string fault = check.fault(program.vertexSource, program.fragmentSource);
        if (!fault.empty()) faults.push_back(name + ": " + fault);
    };
    std::size_t shaders = 0;
    for (const std::string& name : library.names()) {
        const level::Shader* shader = library.find(name);
        if (!shader) continue; // "terrain.vertex": the game takes the dot for an extension and never finds it either
        ++shaders;
        for (const auto light :
             {LightSource::Irradiance, LightSource::Lightmap, LightSource::Vertex, LightSource::None}) {
            osgpie::Look look;
            look.light = light;
            link(osgpie::makeMaterialProgram(*shader, look), name);
            look.fog = true;
            if (light == LightSource::Irradiance) link(osgpie::makeMaterialProgram(*shader, look), name + " in fog");
        }
        if (shader->parms.sky) {
            osgpie::Look look;
            look.light = LightSource::None;
            look.cloudHeight = shader->cloudHeight;
            link(osgpie::makeSkyProgram(*shader, look), name + " as sky");
        }
    }
    EXPECT_THAT(faults, testing::IsEmpty());
    EXPECT_GT(shaders, 1000U);
    EXPECT_GT(seen.size(), 200U);
}

TEST(Shipped, ProgramsOfALoadedLevelLink) {
    PIE_NEED_GAME_DATA();
    PIE_NEED_DISPLAY();
    LinkCheck check;
    if (!check.ready()) GTEST_SKIP() << noDisplay;
    for (const char* name : {"maps/oa_dm1.bsp", "maps/wrackdm17.bsp"}) {
        if (!GameData::instance().files.contains(name)) continue;
        std::vector<std::string> faults;
        EXPECT_GT(check.check(*readShipped(name, "view=baked"), faults), 5U);
        EXPECT_THAT(faults, testing::IsEmpty()) << name;
    }
}

// Picture × lightmap at the places that rays meet, computed pixel by pixel from the level's data, against the picture
// that OpenGL draws. Surfaces with scripts are left out: their blending is tested stage by stage elsewhere.
TEST_P(ShippedPicture, BakedViewIsPictureTimesLightmap) {
    PIE_NEED_GAME_DATA();
    PIE_NEED_DISPLAY();
    const std::string name = std::string("maps/") + GetParam() + ".bsp";
    if (!GameData::instance().files.contains(name)) GTEST_SKIP() << GameData::missing;
    const level::Level level = load(name, true);
    const auto start = level.firstView();
    const double yaw = osg::DegreesToRadians(static_cast<double>(start.yaw));
    const osg::Vec3d eye(start.eye.x, start.eye.y, start.eye.z);
    Shot shot = lookingAt(eye, eye + osg::Vec3d(std::cos(yaw), std::sin(yaw), -0.1));
    shot.width = 160;
    shot.height = 120;
    const RayPicture expected = castPicture(level, shot);
    const osg::ref_ptr<osg::Node> node = readShipped(name, "view=baked draw_sky=false animate=false draw_fog=false");
    ASSERT_TRUE(node);
    const Picture seen = render(*node, shot);
    ASSERT_FALSE(seen.empty());
    const auto known = static_cast<std::size_t>(std::count(expected.known.begin(), expected.known.end(), 1));
    EXPECT_GT(known, expected.known.size() / 4) << "enough of the view is plain";
    // Filters differ (mipmaps here, a few rays there), so textures' details do; light and places must not.
    EXPECT_TRUE(similar(seen, expected.picture, 4.0, std::string("shipped-") + GetParam(), expected.known));
}
