// What the plug-in makes of a level's faces. Most tests pin a fault of OSG's own reader: mirrored levels, polygons
// drawn as fans, patches drawn eight times without texture coordinates, no normals, no submodels.

#include "tests/level/make_level.h"
#include "tests/osg/scene_reading.h"

#include <gmock/gmock.h>

#include <osg/ComputeBoundsVisitor>
#include <osg/Geode>
#include <osgUtil/Optimizer>

#include <cmath>

namespace {

using namespace pie;
using namespace pie::test;
using ::testing::SizeIs;

/// The level as it is in the file: no refinement.
constexpr const char* asStored = "view=baked";
constexpr double tolerance = 1e-4;

std::vector<DrawnTriangle> read(const LevelBuilder& builder, const std::string& options = asStored) {
    const Game game;
    const osg::ref_ptr<osg::Node> node = readNode(game.addLevel("made", builder.build()), options);
    if (node) firstUpdate(*node);
    return node ? trianglesOf(*node) : std::vector<DrawnTriangle>{};
}

/// An upright square in the plane x = 96, seen from the origin; further along y than it is high.
LevelBuilder wallAhead() {
    LevelBuilder builder;
    builder.polygon(builder.shader("t/wall"), {{96, -16, 0}, {96, -16, 32}, {96, 48, 32}, {96, 48, 0}});
    return builder;
}

class EveryView : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Views, EveryView, ::testing::Values("lit", "baked", "fullbright", "light"));

} // namespace

TEST_P(EveryView, IsNotMirrored) {
    const auto triangles = read(wallAhead(), std::string("view=") + GetParam());
    ASSERT_FALSE(triangles.empty());
    osg::BoundingBoxd box;
    for (const auto& triangle : triangles)
        for (const osg::Vec3d& place : triangle.place) box.expandBy(place);
    EXPECT_NEAR(box.xMin(), 96, tolerance);
    EXPECT_NEAR(box.xMax(), 96, tolerance);
    EXPECT_NEAR(box.yMin(), -16, tolerance);
    EXPECT_NEAR(box.yMax(), 48, tolerance);
    EXPECT_NEAR(box.zMin(), 0, tolerance);
    EXPECT_NEAR(box.zMax(), 32, tolerance);
}

TEST_P(EveryView, FrontFacesAreCounterClockwiseAndNormalsPointAlong) {
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    builder.room({-128, -96, -64}, {128, 96, 64}, {wall, wall, wall, wall, wall, wall});
    const auto triangles = read(builder, std::string("view=") + GetParam());
    ASSERT_FALSE(triangles.empty());
    for (const DrawnTriangle& triangle : triangles) {
        osg::Vec3d front = triangle.front();
        front.normalize();
        EXPECT_LT(front * triangle.centre(), 0) << "walls of a room face inwards";
        for (const osg::Vec3& normal : triangle.normal) EXPECT_GT(osg::Vec3d(normal) * front, 0.999);
    }
    EXPECT_NEAR(areaOf(triangles), 2.0 * (256 * 192 + 256 * 128 + 192 * 128), 1.0);
}

TEST(PluginGeometry, MeshVerticesDecideNotTheFan) {
    // An L whose inner corner is its first vertex: the fan from vertex 1 would cover the missing quarter.
    LevelBuilder builder;
    const int face = builder.polygon(builder.shader("t/wall"),
                                     {{0, 0, 0}, {64, 0, 0}, {64, 32, 0}, {32, 32, 0}, {32, 64, 0}, {0, 64, 0}});
    auto& bsp = builder.raw();
    // Clockwise triples, as files have them.
    bsp.meshVertices = {1, 3, 2, 1, 0, 3, 0, 5, 3, 5, 4, 3};
    bsp.faces[static_cast<std::size_t>(face)].meshVertexCount = 12;
    const auto triangles = read(builder);
    EXPECT_THAT(triangles, SizeIs(4));
    EXPECT_NEAR(areaOf(triangles), 64 * 64 - 32 * 32, tolerance);
    for (const DrawnTriangle& triangle : triangles) {
        EXPECT_GT(triangle.front().z(), 0);
        EXPECT_FALSE(triangle.centre().x() > 32 && triangle.centre().y() > 32) << "nothing is in the missing quarter";
    }
}

TEST(PluginGeometry, MeshVerticesAreRelativeToTheFacesFirstVertex) {
    LevelBuilder builder;
    builder.polygon(builder.shader("t/first"), {{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}});
    builder.polygon(builder.shader("t/second"), {{100, 0, 0}, {108, 0, 0}, {108, 8, 0}, {100, 8, 0}});
    for (const DrawnTriangle& triangle : read(builder))
        EXPECT_EQ(triangle.centre().x() > 50, triangle.material == "t/second");
}

TEST(PluginGeometry, PatchIsDrawnOnceWithTextureCoordinatesAndNormals) {
    // A flat patch first: its area is known exactly, so that a second copy shows.
    LevelBuilder builder;
    std::vector<Vec3> flat;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            flat.emplace_back(static_cast<float>(column) * 32, static_cast<float>(row) * 32, 8);
    builder.patch(builder.shader("t/flat"), 3, 3, flat);
    const auto triangles = read(builder);
    EXPECT_NEAR(areaOf(triangles), 64 * 64, 0.01);
    for (const DrawnTriangle& triangle : triangles) {
        EXPECT_GT(triangle.front().z(), 0);
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_GT(triangle.normal.at(i).z(), 0.999);
            // Control point (c, r) has the coordinates (c, r).
            EXPECT_NEAR(static_cast<double>(triangle.texture.at(i).x()), triangle.place.at(i).x() / 32, tolerance);
            EXPECT_NEAR(static_cast<double>(triangle.texture.at(i).y()), triangle.place.at(i).y() / 32, tolerance);
        }
    }
}

TEST(PluginGeometry, CurvedPatchLiesOnItsCurve) {
    // A quadratic arch over y: z = 2 t (1 − t) · 64 at y = 64 t.
    LevelBuilder builder;
    std::vector<Vec3> arch;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            arch.emplace_back(static_cast<float>(column) * 32, static_cast<float>(row) * 32, row == 1 ? 64 : 0);
    builder.patch(builder.shader("t/arch"), 3, 3, arch);
    for (std::size_t i = 0; i < 9; ++i) { // as the compiler writes them
        const std::size_t row = i / 3;
        builder.raw().vertices[i].normal = glm::normalize(Vec3(0, 2.0F * (static_cast<float>(row) - 1), 1));
    }
    const auto triangles = read(builder, "view=baked patch_tolerance=0.25");
    ASSERT_GT(triangles.size(), 8U);
    for (const DrawnTriangle& triangle : triangles) {
        EXPECT_GT(triangle.front().z(), 0);
        for (std::size_t i = 0; i < 3; ++i) {
            const double t = triangle.place.at(i).y() / 64;
            EXPECT_NEAR(triangle.place.at(i).z(), 2 * t * (1 - t) * 64, 1e-3);
            const osg::Vec3d slope(0, -(2 - 4 * t), 1);
            EXPECT_GT(osg::Vec3d(triangle.normal.at(i)) * (slope / slope.length()), 0.97);
        }
    }
}

TEST(PluginGeometry, SubmodelsStandAtTheirEntitysOrigin) {
    LevelBuilder builder;
    builder.polygon(builder.shader("t/floor"), {{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}});
    builder.submodel();
    builder.polygon(builder.shader("t/door"), {{-8, -8, 0}, {8, -8, 0}, {8, 8, 0}, {-8, 8, 0}});
    builder.entity({{"classname", "func_door"}, {"model", "*1"}, {"origin", "100 200 300"}});
    std::size_t doors = 0;
    for (const DrawnTriangle& triangle : read(builder)) {
        if (triangle.material != "t/door") continue;
        ++doors;
        EXPECT_NEAR(triangle.centre().z(), 300, tolerance);
        EXPECT_LT((triangle.centre() - osg::Vec3d(100, 200, 300)).length(), 12);
    }
    EXPECT_EQ(doors, 2U);
}

TEST(PluginGeometry, WhatTheGameDoesNotDrawIsNotDrawn) {
    const std::vector<Vec3> square{{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}};
    const Game game;
    game.addScript("t/sky\n{\nsurfaceparm sky\nskyParms env/none 512 -\n}\n"
                   "t/nodraw\n{\nsurfaceparm nodraw\n{\nmap t/a.tga\n}\n}\n"
                   "t/clip\n{\nsurfaceparm playerclip\nsurfaceparm nodraw\nsurfaceparm trans\n}\n"
                   "t/trigger\n{\nsurfaceparm trigger\nsurfaceparm nodraw\n}\n");
    LevelBuilder builder;
    for (const char* name : {"t/wall", "t/sky", "t/nodraw", "t/clip", "t/trigger"})
        builder.polygon(builder.shader(name), square);
    constexpr std::int32_t noDrawFlag = 0x80; // SURF_NODRAW of the file itself, without any script
    builder.polygon(builder.shader("t/flagged", noDrawFlag), square);
    // The flare: no surface.
    const int flare = builder.polygon(builder.shader("t/flare"), square);
    builder.raw().faces[static_cast<std::size_t>(flare)].type = level::BspFaceType::Flare;
    // A trigger volume with an ordinary texture: the game never shows its model.
    builder.submodel();
    builder.polygon(builder.shader("t/volume"), square);
    builder.entity({{"classname", "trigger_multiple"}, {"model", "*1"}});
    for (const char* view : {"view=baked", "view=lit", "view=light draw_sky=false", "view=fullbright"}) {
        const osg::ref_ptr<osg::Node> node = readNode(game.addLevel("made", builder.build()), view);
        ASSERT_TRUE(node);
        const auto triangles = trianglesOf(*node);
        EXPECT_NEAR(areaOf(triangles), 64 * 64, 0.01) << view;
        for (const DrawnTriangle& triangle : triangles) EXPECT_EQ(triangle.material, "t/wall");
    }
}

TEST(PluginGeometry, RefinementKeepsAreaAndPlaces) {
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    builder.room({-256, -256, -128}, {256, 256, 128}, {wall, wall, wall, wall, wall, wall});
    const auto plain = read(builder);
    const auto fine = read(builder, "max_edge=32");
    EXPECT_GT(fine.size(), 40 * plain.size());
    EXPECT_NEAR(areaOf(fine), areaOf(plain), 1e-3 * areaOf(plain));
    for (const DrawnTriangle& triangle : fine)
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_LE((triangle.place.at(i) - triangle.place.at((i + 1) % 3)).length(), 32.02);
            const osg::Vec3d& p = triangle.place.at(i); // the builder's texture coordinates
            EXPECT_NEAR(static_cast<double>(triangle.texture.at(i).x()), p.x() / 64, tolerance);
        }
}

TEST(PluginGeometry, ALevelIsWholeBeforeTheUpdateThatRefinesIt) {
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    builder.room({-256, -256, -128}, {256, 256, 128}, {wall, wall, wall, wall, wall, wall});
    const Game game;
    game.addPicture("t/wall", {200, 100, 50, 255});
    const osg::ref_ptr<osg::Node> node = readNode(game.addLevel("made", builder.build()), "max_edge=32");
    ASSERT_TRUE(node);
    const auto before = trianglesOf(*node);
    EXPECT_EQ(before.size(), 12U);
    const auto boxOf = [&node] {
        osg::ComputeBoundsVisitor bounds;
        node->accept(bounds);
        return bounds.getBoundingBox();
    };
    const osg::BoundingBox box = boxOf();
    const osg::Texture2D* texture = textureOf(*stateSet(*node, "t/wall"));
    ASSERT_TRUE(texture && texture->getImage() && texture->getImage()->data());
    EXPECT_EQ(texture->getImage()->data()[0], 200);
    // OSG's optimiser comes between, in osgviewer and osgconv.
    osgUtil::Optimizer optimizer;
    optimizer.optimize(node);
    firstUpdate(*node);
    const auto after = trianglesOf(*node);
    EXPECT_GT(after.size(), 40 * before.size());
    EXPECT_NEAR(areaOf(after), areaOf(before), 1e-3 * areaOf(before));
    EXPECT_EQ(boxOf()._min, box._min);
    EXPECT_EQ(boxOf()._max, box._max);
    for (const DrawnTriangle& triangle : after) EXPECT_EQ(triangle.material, "t/wall");
    firstUpdate(*node);
    EXPECT_EQ(trianglesOf(*node).size(), after.size()) << "once";
}

TEST(PluginGeometry, ALevelThatIsDroppedGivesUpItsRefinement) {
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    builder.room({-8192, -8192, -4096}, {8192, 8192, 4096}, {wall, wall, wall, wall, wall, wall});
    const Game game;
    const std::string file = game.addLevel("made", builder.build());
    // Millions of triangles each, if they were made to the end.
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(readNode(file, "max_edge=8"));
}

TEST(PluginGeometry, VertexColoursAreTheGamesLight) {
    LevelBuilder builder;
    builder.polygon(builder.shader("t/wall"), {{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}});
    for (auto& vertex : builder.raw().vertices) vertex.colour = {16, 32, 64, 128};
    for (const DrawnTriangle& triangle : read(builder, "view=baked overbright_clamp=2"))
        for (const osg::Vec4& colour : triangle.colour) {
            // 4 · byte / 255 over the range of 2 that is stored.
            EXPECT_NEAR(static_cast<double>(colour.r()), 4.0 * 16 / 255 / 2, 1e-6);
            EXPECT_NEAR(static_cast<double>(colour.g()), 4.0 * 32 / 255 / 2, 1e-6);
            EXPECT_NEAR(static_cast<double>(colour.b()), 4.0 * 64 / 255 / 2, 1e-6);
            EXPECT_NEAR(static_cast<double>(colour.a()), 128.0 / 255, 1e-6);
        }
    // Cut where the brightest channel is 1, with the hue kept.
    for (auto& vertex : builder.raw().vertices) vertex.colour = {50, 100, 200, 255};
    for (const DrawnTriangle& triangle : read(builder, "view=baked overbright_clamp=1"))
        for (const osg::Vec4& colour : triangle.colour) {
            EXPECT_NEAR(static_cast<double>(colour.r()), 0.25, 1e-6);
            EXPECT_NEAR(static_cast<double>(colour.g()), 0.5, 1e-6);
            EXPECT_NEAR(static_cast<double>(colour.b()), 1.0, 1e-6);
        }
}

TEST(PluginGeometry, BoundsAreTheLevelsNotTheSkys) {
    const Game game;
    game.addScript("t/sky\n{\nsurfaceparm sky\nskyParms env/none 512 -\n{\nmap t/cloud.tga\n}\n}\n");
    game.addPicture("t/cloud", {90, 90, 90, 255});
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    builder.room({1000, 2000, 3000}, {1128, 2128, 3128}, {wall, wall, wall, wall, wall, builder.shader("t/sky")});
    const osg::ref_ptr<osg::Node> node = readNode(game.addLevel("made", builder.build()), asStored);
    ASSERT_TRUE(node);
    osg::ComputeBoundsVisitor bounds;
    node->accept(bounds);
    const osg::BoundingBox box = bounds.getBoundingBox();
    EXPECT_NEAR(static_cast<double>(box.xMin()), 1000, 1e-3);
    EXPECT_NEAR(static_cast<double>(box.zMax()), 3128, 1e-3);
    EXPECT_LT((node->getBound().center() - osg::Vec3(1064, 2064, 3064)).length(), 1.0F);
}

TEST(PluginGeometry, LargeLevelsAreGroupedForCulling) {
    LevelBuilder builder;
    const int wall = builder.shader("t/wall");
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const Vec3 lower(static_cast<float>(x) * 512, static_cast<float>(y) * 512, 0);
            builder.room(lower, lower + Vec3(480, 480, 256), {wall, wall, wall, wall, wall, wall});
        }
    const Game game;
    const osg::ref_ptr<osg::Node> node = readNode(game.addLevel("made", builder.build()), "max_edge=64");
    ASSERT_TRUE(node);
    firstUpdate(*node);
    struct Geodes : osg::NodeVisitor {
        Geodes() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
        void apply(osg::Geode& geode) override {
            if (geode.getBound().valid()) radii.push_back(geode.getBound().radius());
        }
        std::vector<float> radii;
    } geodes;
    node->accept(geodes);
    EXPECT_GT(geodes.radii.size(), 16U);
    for (const float radius : geodes.radii) EXPECT_LT(radius, 0.5F * node->getBound().radius());
}
