#include "pie/scene/scene.h"
#include "tests/scene/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace pie::test {
namespace {

using level::AlphaTest;
using level::Shader;
using scene::Interaction;
using scene::makeScene;
using scene::Scene;
using scene::SceneOptions;

const std::vector<Vec3> square{{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}};

/// One square of a shader that `change` has had its way with.
struct OneShader {
    LevelMaker maker;
    Shader& shader;

    explicit OneShader(std::shared_ptr<const level::Image> image = picture(4, 4, {100, 150, 200, 255}))
        : shader(maker.level.shaders[maker.shader("textures/a", std::move(image))]) {
        maker.polygon(0, square);
    }
    [[nodiscard]] Scene scene(const SceneOptions& options = {}) const { return makeScene(maker.level, options); }
    [[nodiscard]] Rgb reflectance(const SceneOptions& options = {}) const {
        return scene(options).materials.at(0).reflectance;
    }
};

void expectColour(const Rgb& actual, const Rgb& expected, float tolerance = 1e-6F) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], tolerance) << "channel " << c;
}

TEST(SceneReflectance, IsTheMeanTexel) {
    auto image = picture(2, 1, {0, 0, 0, 255});
    image->pixels[1] = {255, 51, 0, 255};
    expectColour(OneShader(image).reflectance(), {0.5F, 0.1F, 0});
}

TEST(SceneReflectance, MeanOfALargePictureIsExact) {
    auto image = picture(700, 500, {0, 0, 0, 255});
    double sum = 0;
    for (std::size_t i = 0; i < image->pixels.size(); ++i) {
        image->pixels[i].x = static_cast<std::uint8_t>(i * 7919 % 251);
        sum += image->pixels[i].x;
    }
    image->pixels[0].y = 255;
    const Rgb reflectance = OneShader(image).reflectance();
    EXPECT_FLOAT_EQ(reflectance.x, static_cast<float>(sum / 255 / 350000));
    EXPECT_FLOAT_EQ(reflectance.y, 1.0F / 350000);
}

TEST(SceneReflectance, AlphaCountsOnlyWhereItCutsOut) {
    auto leaves = picture(2, 1, {0, 200, 0, 255});
    leaves->pixels[1] = {255, 0, 255, 0}; // behind the cut
    leaves->hasAlpha = true;
    OneShader plain(leaves);
    expectColour(plain.reflectance(), {0.5F, 100 / 255.0F, 0.5F});
    OneShader tested(leaves);
    tested.shader.stages[1].alphaTest = AlphaTest::GreaterEqual128;
    expectColour(tested.reflectance(), {0, 200 / 255.0F, 0});
    tested.shader.stages[1].alphaTest = AlphaTest::Less128;
    expectColour(tested.reflectance(), {0.95F, 0, 0.95F});
    OneShader shadowing(leaves);
    shadowing.shader.parms.alphaShadow = true;
    expectColour(shadowing.reflectance(), {0, 200 / 255.0F, 0});
    auto nothing = picture(2, 2, {51, 51, 51, 0});
    OneShader empty(nothing);
    empty.shader.stages[1].alphaTest = AlphaTest::GreaterZero;
    expectColour(empty.reflectance(), Rgb(0.2F));
}

TEST(SceneReflectance, ModelsAndLimits) {
    OneShader given;
    expectColour(given.reflectance(), {100 / 255.0F, 150 / 255.0F, 200 / 255.0F});
    SceneOptions options;
    options.reflectance = scene::ReflectanceModel::Compiler;
    expectColour(given.reflectance(options), 0.55147F * Rgb(100 / 255.0F, 150 / 255.0F, 200 / 255.0F));
    given.shader.light.bounce = 2;
    expectColour(given.reflectance(options), {0.432525F, 0.648788F, 0.865051F}, 1e-5F);
    given.shader.light.bounce = 1000;
    expectColour(given.reflectance(options), Rgb(0.95F));
    for (const float bounce : {-1.0F, std::numeric_limits<float>::quiet_NaN()}) {
        given.shader.light.bounce = bounce;
        expectColour(given.reflectance(options), Rgb(0.0F));
    }
    options = {};
    options.maxReflectance = 0.5F;
    expectColour(given.reflectance(options), {100 / 255.0F, 0.5F, 0.5F});
    options = {};
    options.linear = true;
    expectColour(given.reflectance(options), {0.127438F, 0.304987F, 0.577580F}, 1e-5F);
}

TEST(SceneReflectance, ScriptSurfaces) {
    OneShader constant;
    constant.shader.stages[1].rgbGen = level::RgbGen::Constant;
    constant.shader.stages[1].rgbConstant = {1, 0.5F, 0};
    expectColour(constant.reflectance(), {100 / 255.0F, 75 / 255.0F, 0});
    OneShader missing{nullptr};
    expectColour(missing.reflectance(), Rgb(0.5F));
    missing.shader.stages[1].source = level::Stage::Source::White;
    missing.shader.stages[1].images.clear();
    missing.shader.stages[1].rgbGen = level::RgbGen::Constant;
    missing.shader.stages[1].rgbConstant = {0.2F, 0.3F, 0.4F};
    expectColour(missing.reflectance(), {0.2F, 0.3F, 0.4F});
}

TEST(Scene, WhatLightDoesAtASurface) {
    const auto kindAfter = [](const auto& change) -> std::optional<Interaction> {
        OneShader given;
        change(given.shader);
        const Scene scene = given.scene();
        if (scene.triangles.empty()) return std::nullopt;
        return scene.material(0).interaction;
    };
    EXPECT_EQ(kindAfter([](Shader&) {}), Interaction::Opaque);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.sky = true; }), Interaction::Sky);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.sky = s.parms.translucent = s.parms.noDraw = true; }),
              Interaction::Sky);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.alphaShadow = s.parms.translucent = true; }), Interaction::Filter);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.lightFilter = true; }), Interaction::Filter);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.translucent = true; }), std::nullopt);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.noDraw = true; }), std::nullopt);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.fog = true; }), std::nullopt);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.trigger = true; }), std::nullopt);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.water = s.parms.translucent = true; }), std::nullopt);
    EXPECT_EQ(kindAfter([](Shader& s) { s.parms.lava = true; }), Interaction::Opaque);
    const auto makeDecal = [](Shader& s) {
        s.polygonOffset = true;
        s.stages[0].blend = {level::BlendFactor::DestinationColour, level::BlendFactor::Zero};
    };
    EXPECT_EQ(kindAfter(makeDecal), std::nullopt);
    EXPECT_EQ(kindAfter([](Shader& s) { s.polygonOffset = true; }), Interaction::Opaque) << "its first stage covers";
}

TEST(Scene, AFilterWithoutPictureIsOpaque) {
    OneShader given{nullptr};
    given.shader.parms.alphaShadow = true;
    EXPECT_EQ(given.scene().material(0).interaction, Interaction::Opaque);
}

TEST(Scene, ModelsNeverShownAreLeftOut) {
    LevelMaker maker;
    const std::uint32_t shader = maker.shader("a");
    maker.level.models.resize(3);
    maker.level.models[1].drawn = false;
    maker.polygon(shader, square, 1);
    maker.polygon(shader, square, 2);
    const Scene scene = makeScene(maker.level);
    ASSERT_EQ(scene.triangles.size(), 2U);
    EXPECT_EQ(scene.triangles[0].surface, 1U);
}

TEST(Scene, WeldsPositionsAndKeepsTheSums) {
    LevelMaker maker;
    maker.room(maker.shader("wall"), {-0.0F, 0, 0}, {8, 16, 32});
    maker.shader("unused");
    const Scene scene = makeScene(maker.level);
    EXPECT_EQ(scene.triangles.size(), 12U);
    EXPECT_EQ(scene.positions.size(), 8U) << "both zeros are one position";
    EXPECT_EQ(scene.materials.size(), 1U) << "only shaders in use";
    EXPECT_DOUBLE_EQ(scene.area, 2 * (8 * 16 + 16 * 32 + 32 * 8));
    EXPECT_EQ(scene.bounds.upper, Vec3(8, 16, 32));
    for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
        EXPECT_FLOAT_EQ(glm::length(scene.normals[t]), 1.0F);
        EXPECT_GT(glm::dot(scene.normals[t], Vec3(4, 8, 16) - scene.corner(t, 0)), 0.0F) << "fronts look inside";
    }
    EXPECT_TRUE(scene.textureCoordinates.empty());
}

TEST(Scene, SkyHasNoArea) {
    OneShader given;
    given.shader.parms.sky = true;
    EXPECT_EQ(given.scene().area, 0.0);
    EXPECT_FALSE(given.scene().bounds.empty());
}

TEST(Scene, TrianglesWithoutAreaAreDroppedAndCounted) {
    LevelMaker maker;
    const std::uint32_t shader = maker.shader("a");
    maker.polygon(shader, square);
    maker.polygon(shader, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
    maker.polygon(shader, {{5, 5, 5}, {5, 5, 5}, {5, 5, 5}});
    maker.polygon(shader, {{0, 0, 0}, {NAN, 0, 0}, {2, 7, 0}});
    std::size_t dropped = 99;
    EXPECT_EQ(makeScene(maker.level, {}, &dropped).triangles.size(), 2U);
    EXPECT_EQ(dropped, 3U);
}

TEST(Scene, AnyScale) {
    for (const float scale : {1e-3F, 1.0F, 1e7F}) {
        LevelMaker maker;
        maker.room(maker.shader("wall"), Vec3(-0.5F * scale), Vec3(0.5F * scale));
        std::size_t dropped = 0;
        const Scene scene = makeScene(maker.level, {}, &dropped);
        EXPECT_EQ(dropped, 0U);
        EXPECT_NEAR(scene.area / scale / scale, 6.0, 1e-5);
        for (const Vec3& normal : scene.normals) EXPECT_NEAR(glm::length(normal), 1.0F, 1e-6F);
    }
}

TEST(Scene, EmptyLevels) {
    EXPECT_TRUE(makeScene(level::Level{}).triangles.empty());
    LevelMaker maker;
    maker.shader("unused");
    const Scene scene = makeScene(maker.level);
    EXPECT_TRUE(scene.bounds.empty());
    for (const Interaction kind : {Interaction::Opaque, Interaction::Filter, Interaction::Sky})
        EXPECT_FALSE(scene.has(kind));
}

TEST(Scene, TwoSidedFollowsTheShader) {
    OneShader given;
    EXPECT_FALSE(given.scene().material(0).twoSided);
    given.shader.cull = level::Cull::None;
    EXPECT_TRUE(given.scene().material(0).twoSided);
}

TEST(SceneTransmittance, ReadsTheTexelThatIsHit) {
    auto image = picture(2, 2, {0, 0, 0, 0});
    image->pixels = {{255, 0, 0, 0}, {0, 255, 0, 51}, {0, 0, 255, 102}, {51, 102, 153, 255}};
    for (const bool alphaOnly : {true, false}) {
        OneShader given(image);
        given.shader.parms.alphaShadow = alphaOnly;
        given.shader.parms.lightFilter = !alphaOnly;
        const Scene scene = given.scene(); // texture coordinates 0 to 1 over the square, repeated by the game
        ASSERT_EQ(scene.textureCoordinates.size(), 6U);
        const auto at = [&](const Vec3& p) { // first triangle: corners (0 0) (64 0) (64 64)
            return scene.transmittance(0, (p.x - p.y) / 64, p.y / 64);
        };
        const auto expected = [&](float alpha, const Rgb& colour) { return alphaOnly ? Rgb(1 - alpha) : colour; };
        expectColour(at({16, 8, 0}), expected(0, {1, 0, 0}));
        expectColour(at({48, 8, 0}), expected(0.2F, {0, 1, 0}));
        expectColour(at({60, 40, 0}), expected(1, {0.2F, 0.4F, 0.6F}));
    }
}

TEST(SceneTransmittance, RepeatsThePicture) {
    auto image = picture(4, 1, {0, 0, 0, 0});
    for (int x = 0; x < 4; ++x) image->pixels[static_cast<std::size_t>(x)].w = static_cast<std::uint8_t>(51 * x);
    OneShader given(image);
    given.shader.parms.alphaShadow = true;
    Scene scene = given.scene();
    for (const auto& [s, expected] : {std::pair{0.3F, 0.8F},
                                      {-0.7F, 0.8F},
                                      {1000.3F, 0.8F},
                                      {0.999F, 0.4F},
                                      {-0.001F, 0.4F},
                                      {1.0F, 1.0F},
                                      {NAN, 1.0F},
                                      {INFINITY, 1.0F},
                                      {1e30F, 1.0F}}) {
        scene.textureCoordinates.assign(6, {s, 0.5F});
        EXPECT_NEAR(scene.transmittance(0, 0.2F, 0.3F).x, expected, 1e-6F) << s;
    }
}

TEST(SceneTransmittance, OpaqueAndSky) {
    const Scene scene = makeScene(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
                                  std::vector<std::uint32_t>{0, 1}, [] {
                                      std::vector<scene::Material> materials(3);
                                      materials[1].interaction = Interaction::Sky;
                                      materials[2].interaction = Interaction::Filter;
                                      return materials;
                                  }());
    EXPECT_EQ(scene.transmittance(0, 0, 0), Rgb(0.0F));
    EXPECT_EQ(scene.transmittance(1, 0, 0), Rgb(1.0F));
    EXPECT_TRUE(scene.has(Interaction::Sky));
    EXPECT_FALSE(scene.has(Interaction::Filter)) << "a material that no triangle has";
}

TEST(BareScene, KeepsEveryTriangleInItsPlace) {
    const Scene scene = makeScene(std::vector<Vec3>{{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
                                  std::vector<std::uint32_t>{7}, {});
    ASSERT_EQ(scene.triangles.size(), 2U);
    EXPECT_EQ(scene.normals[0], Vec3(0.0F)) << "no area";
    EXPECT_EQ(scene.normals[1], Vec3(0, 0, 1));
    EXPECT_EQ(scene.triangles[0].material, 0U) << "there is no material 7";
    EXPECT_DOUBLE_EQ(scene.area, 0.5);
}

TEST(Mesh, HoldsWhatIsDrawn) {
    LevelMaker maker;
    const std::uint32_t wall = maker.shader("wall");
    const std::uint32_t sky = maker.shader("sky");
    const std::uint32_t clip = maker.shader("clip");
    maker.level.shaders[sky].parms.sky = true;
    maker.level.shaders[clip].parms.noDraw = true;
    maker.level.models.resize(2);
    maker.level.models[1].drawn = false;
    maker.polygon(clip, square);
    maker.polygon(wall, square);
    maker.polygon(sky, square);
    maker.polygon(wall, square, 1);
    maker.polygon(wall, {{0, 0, 9}, {4, 0, 9}, {4, 4, 9}, {0, 4, 9}, {-2, 2, 9}});
    const scene::Mesh mesh = scene::makeMesh(maker.level);
    ASSERT_EQ(mesh.triangles.size(), 2U + 3U);
    EXPECT_EQ(mesh.vertices.size(), 4U + 5U) << "each vertex once";
    EXPECT_EQ(mesh.triangles[0].surface, 1U);
    EXPECT_EQ(mesh.triangles[2].surface, 4U);
    EXPECT_EQ(mesh.vertices[mesh.triangles[4].vertices[2]].position, Vec3(-2, 2, 9));
}

TEST(Mesh, SurfacesDoNotShareVerticesEvenIfTheFileDoes) {
    LevelMaker maker;
    maker.polygon(maker.shader("wall"), square);
    level::Surface again = maker.level.surfaces[0];
    again.shader = maker.shader("other");
    maker.level.surfaces.push_back(again);
    EXPECT_EQ(scene::makeMesh(maker.level).vertices.size(), 8U);
}

} // namespace
} // namespace pie::test
