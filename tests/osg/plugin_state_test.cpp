// How the plug-in draws surfaces: textures, cut-outs, blending, sides, order, skies and sprites.

#include "tests/level/make_level.h"
#include "tests/osg/scene_reading.h"

#include <gmock/gmock.h>

#include <osg/BlendFunc>
#include <osg/CameraView>
#include <osg/CullFace>
#include <osg/Depth>
#include <osg/Geode>
#include <osg/Geometry>
#include <osg/Program>

#include <algorithm>
#include <array>
#include <cmath>

namespace {

using namespace pie;
using namespace pie::test;
using ::testing::HasSubstr;

constexpr auto on = osg::StateAttribute::ON;
const std::vector<Vec3> square{{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}};

/// A square for each shader, in a game with this script.
osg::ref_ptr<osg::Node> readShaders(const Game& game, const std::vector<std::string>& shaders,
                                    const std::string& options = "view=baked") {
    LevelBuilder builder;
    for (const std::string& shader : shaders) builder.polygon(builder.shader(shader), square);
    return readNode(game.addLevel("made", builder.build()), options);
}

bool isOn(const osg::StateSet& state, osg::StateAttribute::GLMode mode) { return (state.getMode(mode) & on) != 0; }

std::string fragmentSource(const osg::StateSet& state) {
    const auto* program = dynamic_cast<const osg::Program*>(state.getAttribute(osg::StateAttribute::PROGRAM));
    if (!program) return {};
    for (unsigned i = 0; i < program->getNumShaders(); ++i)
        if (program->getShader(i)->getType() == osg::Shader::FRAGMENT) return program->getShader(i)->getShaderSource();
    return {};
}

/// Bytes of the first pixel of the texture in that unit.
std::array<int, 4> texel(const osg::StateSet& state, unsigned unit = 0) {
    const osg::Texture2D* texture = textureOf(state, unit);
    if (!texture || !texture->getImage()) return {-1, -1, -1, -1};
    const osg::Vec4 c = texture->getImage()->getColor(0U, 0U) * 255.0F;
    const auto byte = [](float value) { return static_cast<int>(std::lround(value)); };
    return {byte(c.r()), byte(c.g()), byte(c.b()), byte(c.a())};
}

std::array<int, 4> colour(int r, int g, int b, int a = 255) { return {r, g, b, a}; }

} // namespace

TEST(PluginState, AlphaTestedSurfacesAreCutOut) {
    const Game game;
    game.addPicture("t/fence", {10, 20, 30, 200});
    game.addScript("t/fence\n{\n{\nmap t/fence.tga\nalphaFunc GE128\nrgbGen vertex\n}\n}\n");
    const auto node = readShaders(game, {"t/fence"});
    const auto state = stateSet(*node, "t/fence");
    ASSERT_TRUE(state);
    EXPECT_THAT(fragmentSource(*state), HasSubstr("discard"));
    EXPECT_FALSE(isOn(*state, GL_BLEND));
    EXPECT_EQ(texel(*state), colour(10, 20, 30, 200));
    // Without programs OpenGL's own alpha test does it.
    const auto fixed = stateSet(*readShaders(game, {"t/fence"}, "view=baked renderer=fixed"), "t/fence");
    EXPECT_TRUE(isOn(*fixed, GL_ALPHA_TEST));
    EXPECT_EQ(fixed->getAttribute(osg::StateAttribute::PROGRAM), nullptr);
}

TEST(PluginState, BlendedSurfacesBlendBehindOpaqueOnesWithoutDepth) {
    const Game game;
    game.addScript("t/glass\n{\n{\nmap t/a.tga\nblendFunc GL_SRC_ALPHA GL_ONE_MINUS_SRC_ALPHA\n}\n}\n"
                   "t/glow\n{\n{\nmap t/a.tga\nblendFunc add\n}\n}\n");
    game.addPicture("t/wall", {1, 2, 3, 255});
    const auto node = readShaders(game, {"t/glass", "t/wall", "t/glow"});
    const auto glass = stateSet(*node, "t/glass");
    const auto wall = stateSet(*node, "t/wall");
    const auto glow = stateSet(*node, "t/glow");
    ASSERT_TRUE(glass && wall && glow);
    const auto blend = [](const osg::StateSet& state) {
        const auto* function = dynamic_cast<const osg::BlendFunc*>(state.getAttribute(osg::StateAttribute::BLENDFUNC));
        return function ? std::pair(function->getSource(), function->getDestination()) : std::pair(0U, 0U);
    };
    EXPECT_EQ(blend(*glass), (std::pair<GLenum, GLenum>(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA)));
    EXPECT_EQ(blend(*glow), (std::pair<GLenum, GLenum>(GL_ONE, GL_ONE)));
    for (const auto& state : {glass, glow}) {
        EXPECT_TRUE(isOn(*state, GL_BLEND));
        const auto* depth = dynamic_cast<const osg::Depth*>(state->getAttribute(osg::StateAttribute::DEPTH));
        ASSERT_NE(depth, nullptr);
        EXPECT_FALSE(depth->getWriteMask());
        EXPECT_GT(state->getBinNumber(), wall->getBinNumber());
        EXPECT_EQ(state->getBinName(), "DepthSortedBin");
    }
    EXPECT_FALSE(isOn(*wall, GL_BLEND));
}

TEST(PluginState, SidesFollowTheScript) {
    const Game game;
    game.addScript("t/both\n{\ncull none\n{\nmap t/a.tga\n}\n}\nt/inside\n{\ncull back\n{\nmap t/a.tga\n}\n}\n");
    const auto node = readShaders(game, {"t/both", "t/inside", "t/wall"});
    const auto face = [&](const std::string& name) {
        const auto state = stateSet(*node, name);
        const auto* cull = dynamic_cast<const osg::CullFace*>(state->getAttribute(osg::StateAttribute::CULLFACE));
        return isOn(*state, GL_CULL_FACE) && cull ? static_cast<GLenum>(cull->getMode()) : GLenum{0};
    };
    EXPECT_EQ(face("t/both"), 0U);
    EXPECT_EQ(face("t/inside"), static_cast<GLenum>(GL_FRONT));
    EXPECT_EQ(face("t/wall"), static_cast<GLenum>(GL_BACK));
}

TEST(PluginState, TexturesAreFoundByScriptAndByName) {
    const Game game;
    game.addPicture("t/plain", {1, 2, 3, 255});
    game.addPicture("t/other", {4, 5, 6, 255});
    game.addScript("t/scripted\n{\n{\nmap t/other.jpg\n}\n}\n"); // the extension is wrong, as in many scripts
    const auto node = readShaders(game, {"t/plain", "t/scripted", "t/gone"});
    EXPECT_EQ(texel(*stateSet(*node, "t/plain")), colour(1, 2, 3));
    EXPECT_EQ(texel(*stateSet(*node, "t/scripted")), colour(4, 5, 6));
    const osg::Texture2D* plain = textureOf(*stateSet(*node, "t/plain"));
    EXPECT_EQ(plain->getWrap(osg::Texture::WRAP_S), osg::Texture::REPEAT);
    EXPECT_EQ(plain->getFilter(osg::Texture::MIN_FILTER), osg::Texture::LINEAR_MIPMAP_LINEAR);
    EXPECT_GE(texel(*stateSet(*node, "t/gone"))[0], 0) << "a missing picture is drawn plain, not left out";
}

TEST(PluginState, TextureFoldersOfTheOptionsAreSearched) {
    const Game game;
    const Game base;
    base.addPicture("t/shared", {7, 8, 9, 255});
    const auto node = readShaders(game, {"t/shared"}, "view=baked textures=" + base.folder().path().string());
    EXPECT_EQ(texel(*stateSet(*node, "t/shared")), colour(7, 8, 9));
}

TEST(PluginState, LightmapsAreTheGamesLight) {
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    builder.polygon(wall, square, 0);
    builder.polygon(wall, square, 1);
    level::BspLightmap plain;
    plain.fill(40);
    level::BspLightmap bright;
    for (std::size_t i = 0; i < bright.size(); i += 3) {
        bright[i] = 200;
        bright[i + 1] = 100;
        bright[i + 2] = 50;
    }
    builder.raw().lightmaps = {plain, bright};
    const Game game;
    const auto node = readNode(game.addLevel("made", builder.build()), "view=baked overbright_clamp=1");
    ASSERT_TRUE(node);
    std::vector<std::array<int, 4>> found;
    for (const auto& state : stateSetsOf(*node)) {
        found.push_back(texel(*state, 1));
        EXPECT_EQ(textureOf(*state, 1)->getWrap(osg::Texture::WRAP_S), osg::Texture::CLAMP_TO_EDGE);
        EXPECT_EQ(textureOf(*state, 1)->getFilter(osg::Texture::MIN_FILTER), osg::Texture::LINEAR) << "no mipmaps";
    }
    // R_ColorShiftLightingBytes: byte << 2; where that leaves the range, every channel × 255 / largest.
    EXPECT_THAT(found, testing::UnorderedElementsAre(colour(160, 160, 160), colour(255, 127, 63)));
}

TEST(PluginState, EveryLightmapByteIsShiftedAsTheGameDoes) {
    LevelBuilder builder;
    builder.polygon(builder.shader("t/wall"), square, 0);
    level::BspLightmap ramp{};
    for (std::size_t i = 0; i < 256; ++i)
        ramp.at(3 * i) = ramp.at(3 * i + 1) = ramp.at(3 * i + 2) = static_cast<std::uint8_t>(i);
    builder.raw().lightmaps = {ramp};
    const Game game;
    for (const int clamp : {1, 2}) {
        const auto node =
            readNode(game.addLevel("made", builder.build()), "view=baked overbright_clamp=" + std::to_string(clamp));
        const osg::Texture2D* texture = textureOf(*stateSet(*node, "t/wall"), 1);
        ASSERT_NE(texture, nullptr);
        for (int byte = 0; byte < 256; ++byte) {
            const int side = level::lightmapSide;
            const auto* pixel =
                texture->getImage()->data(static_cast<unsigned>(byte % side), static_cast<unsigned>(byte / side));
            EXPECT_EQ(int{pixel[0]}, std::min(255, 4 * byte / clamp)) << byte << " at " << clamp;
        }
    }
}

TEST(PluginState, OneStatePerShaderAndLightmap) {
    LevelBuilder builder;
    const int a = builder.shader("t/a");
    const int b = builder.shader("t/b");
    for (int i = 0; i < 20; ++i) builder.polygon(i % 2 == 0 ? a : b, square);
    const Game game;
    const auto node = readNode(game.addLevel("made", builder.build()), "view=fullbright");
    EXPECT_EQ(stateSetsOf(*node).size(), 2U);
}

TEST(PluginState, LitSurfacesFollowTheDrawStagesRules) {
    const Game game;
    const auto node = readShaders(game, {"t/wall"}, "view=lit");
    ASSERT_TRUE(node);
    firstUpdate(*node);
    struct Rules : osg::NodeVisitor {
        Rules() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
        void apply(osg::Geometry& geometry) override {
            ++seen;
            // Without DYNAMIC the next update overlaps a running draw, and the Optimizer merges what has a callback.
            EXPECT_EQ(geometry.getDataVariance(), osg::Object::DYNAMIC);
            EXPECT_FALSE(geometry.getUseDisplayList());
            EXPECT_TRUE(geometry.getUseVertexBufferObjects());
            EXPECT_NE(geometry.getDrawCallback(), nullptr);
            EXPECT_NE(geometry.getColorArray()->getVertexBufferObject(),
                      geometry.getVertexArray()->getVertexBufferObject())
                << "only the colours are sent again";
        }
        int seen = 0;
    } rules;
    node->accept(rules);
    EXPECT_EQ(rules.seen, 1);
    EXPECT_NE(node->getUpdateCallback(), nullptr);
    EXPECT_EQ(readShaders(game, {"t/wall"}, "view=baked")->getUpdateCallback(), nullptr)
        << "nothing to trace, nothing to do";
}

TEST(PluginState, SkyIsDrawnAsACubeWithoutPlace) {
    const Game game;
    game.addScript("t/sky\n{\nsurfaceparm sky\nskyParms env/box 512 -\n}\n");
    for (const char* side : {"rt", "lf", "bk", "ft", "up", "dn"})
        game.addPicture(std::string("env/box_") + side, {50, 60, 70, 255});
    const auto node = readShaders(game, {"t/wall", "t/sky"});
    const auto state = stateSet(*node, "t/sky");
    ASSERT_TRUE(state);
    for (unsigned unit = 0; unit < 6; ++unit) {
        EXPECT_EQ(texel(*state, unit), colour(50, 60, 70));
        EXPECT_EQ(textureOf(*state, unit)->getWrap(osg::Texture::WRAP_T), osg::Texture::CLAMP_TO_EDGE);
    }
    const auto* depth = dynamic_cast<const osg::Depth*>(state->getAttribute(osg::StateAttribute::DEPTH));
    ASSERT_NE(depth, nullptr);
    EXPECT_FALSE(depth->getWriteMask());
    EXPECT_GT(state->getBinNumber(), 0) << "behind what is opaque";
    for (const auto& other : stateSetsOf(*readShaders(game, {"t/wall", "t/sky"}, "view=baked draw_sky=false")))
        EXPECT_NE(other->getName(), "t/sky");
}

TEST(PluginState, SpritesCarryTheirCentre) {
    const Game game;
    game.addScript("t/flare\n{\ndeformVertexes autosprite\n{\nmap t/a.tga\nblendFunc add\n}\n}\n");
    const auto node = readShaders(game, {"t/flare"});
    struct Sprites : osg::NodeVisitor {
        Sprites() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
        void apply(osg::Geometry& geometry) override {
            if (const auto* found = dynamic_cast<osg::Vec3Array*>(geometry.getTexCoordArray(2)))
                centres.assign(found->begin(), found->end());
        }
        std::vector<osg::Vec3> centres;
    } sprites;
    node->accept(sprites);
    ASSERT_EQ(sprites.centres.size(), 4U);
    for (const osg::Vec3& centre : sprites.centres) EXPECT_EQ(centre, osg::Vec3(32, 32, 0));
    EXPECT_FALSE(isOn(*stateSet(*node, "t/flare"), GL_CULL_FACE));
}

TEST(PluginState, TurningSpritesKeepTheirShape) {
    const Game game;
    game.addScript("t/flame\n{\ndeformVertexes autosprite2\n{\nmap t/a.tga\nblendFunc add\n}\n}\n");
    // A tall one and a square; corners in both orders that compilers write.
    for (const float height : {128.0F, 64.0F})
        for (const bool turned : {false, true}) {
            std::vector<Vec3> corners{{0, 0, 0}, {64, 0, 0}, {64, 0, height}, {0, 0, height}};
            if (turned) std::rotate(corners.begin(), corners.begin() + 1, corners.end());
            LevelBuilder builder;
            builder.polygon(builder.shader("t/flame"), corners);
            const auto node = readNode(game.addLevel("made", builder.build()), "view=baked");
            EXPECT_NEAR(areaOf(trianglesOf(*node, "t/flame")), 64.0 * static_cast<double>(height), 1e-3);
        }
}

TEST(PluginState, FogVolumesReachTheProgram) {
    const Game game;
    game.addScript(
        "t/fog\n{\nsurfaceparm fog\nsurfaceparm nodraw\nsurfaceparm trans\nfogParms ( 0.25 0.5 0.75 ) 512\n}\n");
    LevelBuilder builder;
    const int face = builder.polygon(builder.shader("t/floor"), square);
    const int brush = builder.brush(builder.shader("t/fog"), {0, 0, -64}, {64, 64, 64});
    builder.effect("t/fog", brush, 5);
    builder.raw().faces[static_cast<std::size_t>(face)].effect = 0;
    const auto node = readNode(game.addLevel("made", builder.build()), "view=baked");
    const auto state = stateSet(*node, "t/floor");
    const auto vec3 = [&](const char* name) {
        osg::Vec3 value(-1, -1, -1);
        if (const osg::Uniform* uniform = state->getUniform(name)) uniform->get(value);
        return value;
    };
    EXPECT_EQ(vec3("fogColour"), osg::Vec3(0.25F, 0.5F, 0.75F));
    osg::Vec4 plane;
    ASSERT_NE(state->getUniform("fogPlane"), nullptr);
    state->getUniform("fogPlane")->get(plane);
    EXPECT_EQ(plane, osg::Vec4(0, 0, -1, 64)) << "depth below the upper side";
    EXPECT_THAT(fragmentSource(*state), HasSubstr("fogAmount()"));
}

TEST(PluginState, FirstPlayerStartIsTheStartingView) {
    LevelBuilder builder;
    builder.polygon(builder.shader("t/wall"), square);
    builder.entity({{"classname", "info_player_deathmatch"}, {"origin", "10 20 30"}, {"angle", "90"}});
    const Game game;
    const auto node = readNode(game.addLevel("made", builder.build()), "view=baked");
    struct Start : osg::NodeVisitor {
        Start() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
        void apply(osg::CameraView& found) override { view = &found; }
        osg::ref_ptr<osg::CameraView> view;
    } start;
    node->accept(start);
    ASSERT_TRUE(start.view);
    const osg::Vec3d place = start.view->getPosition();
    EXPECT_NEAR(place.x(), 10, 1e-3);
    EXPECT_NEAR(place.y(), 20, 1e-3);
    EXPECT_GT(place.z(), 30) << "eyes are above the origin";
    EXPECT_LT((start.view->getAttitude() * osg::Vec3d(0, 0, -1) - osg::Vec3d(0, 1, 0)).length(), 1e-4) << "90° is +y";
    EXPECT_LT((start.view->getAttitude() * osg::Vec3d(0, 1, 0) - osg::Vec3d(0, 0, 1)).length(), 1e-4) << "upright";
}
