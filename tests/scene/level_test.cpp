// Scene, refinement, receivers and cells of shipped levels.

#include "pie/core/parallel.h"
#include "pie/scene/cells.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"
#include "tests/scene/shapes.h"
#include "tests/support/game_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace pie::test {
namespace {

level::Level load(const std::string& path, bool images) {
    level::LoadOptions options;
    options.images = images;
    Result<level::Level> level = level::loadLevel({GameData::instance().files, path}, options);
    if (level) return std::move(*level);
    ADD_FAILURE() << level.error().message();
    return {};
}

TEST(ShippedScene, EveryLevelMakesAUsableScene) {
    PIE_NEED_GAME_DATA();
    for (const std::string& path : GameData::instance().levels) {
        const level::Level level = load(path, false);
        std::size_t dropped = 0;
        const scene::Scene scene = scene::makeScene(level, {}, &dropped);
        EXPECT_GT(scene.triangles.size(), 100U) << path;
        EXPECT_LT(dropped, scene.triangles.size() / 20) << path;
        EXPECT_TRUE(std::isfinite(scene.area) && scene.area > 0) << path;
        EXPECT_TRUE(std::all_of(scene.normals.begin(), scene.normals.end(), [](const Vec3& normal) {
            return std::abs(glm::length(normal) - 1.0F) < 1e-5F;
        })) << path;
        const scene::Mesh mesh = scene::makeMesh(level);
        EXPECT_NEAR(areaOf(mesh), level.statistics.drawnArea, 1e-3 * areaOf(mesh)) << path;
    }
}

TEST(ShippedScene, ReflectanceComesFromThePictures) {
    PIE_NEED_GAME_DATA();
    const level::Level level = load("maps/oa_dm1.bsp", true);
    const scene::Scene scene = scene::makeScene(level);
    std::size_t grey = 0;
    for (const scene::Material& material : scene.materials) {
        for (int c = 0; c < 3; ++c) {
            EXPECT_GE(material.reflectance[c], 0.0F);
            EXPECT_LE(material.reflectance[c], 0.95F);
        }
        grey += material.reflectance == Rgb(0.5F) ? 1 : 0;
    }
    EXPECT_LE(grey, scene.materials.size() / 10) << "only pictures that are missing are unknown";
}

TEST(ShippedRefinement, LeavesNoTJunctionAndKeepsTheArea) {
    PIE_NEED_GAME_DATA();
    for (const char* const path : {"maps/aggressor.bsp", "maps/oa_dm1.bsp"}) {
        const level::Level level = load(path, false);
        scene::Mesh mesh = scene::makeMesh(level);
        const double area = areaOf(mesh);
        EXPECT_GT(countTJunctionsSorted(mesh), 0U) << path;
        scene::RefineOptions options;
        options.maxEdge = 48;
        const scene::RefineStatistics statistics = scene::refine(mesh, options);
        EXPECT_EQ(countTJunctionsSorted(mesh), 0U) << path;
        EXPECT_GT(statistics.tJunctions, 0U);
        EXPECT_LE(longestEdgeOf(mesh), 48.011) << path;
        EXPECT_NEAR(areaOf(mesh), area, 2e-4 * area) << path;
    }
}

TEST(ShippedRefinement, SameOnOneAndTwoThreads) {
    PIE_NEED_GAME_DATA();
    const level::Level level = load("maps/oa_dm1.bsp", false);
    scene::RefineOptions options;
    options.maxEdge = 64;
    setThreads(1);
    scene::Mesh one = scene::makeMesh(level);
    scene::refine(one, options);
    setThreads(2);
    scene::Mesh two = scene::makeMesh(level);
    scene::refine(two, options);
    setThreads(0);
    ASSERT_EQ(one.triangles.size(), two.triangles.size());
    for (std::size_t t = 0; t < one.triangles.size(); ++t)
        ASSERT_EQ(one.triangles[t].vertices, two.triangles[t].vertices);
    for (std::size_t v = 0; v < one.vertices.size(); ++v) ASSERT_EQ(one.vertices[v].position, two.vertices[v].position);
}

void countLeaves(const scene::CellNode& node, std::vector<std::size_t>& sizes) {
    if (node.children.empty()) sizes.push_back(node.triangles.size());
    for (const scene::CellNode& child : node.children) countLeaves(child, sizes);
}

TEST(ShippedCells, AreWorthADrawCallEach) {
    PIE_NEED_GAME_DATA();
    const level::Level level = load("maps/aggressor.bsp", false);
    scene::Mesh mesh = scene::makeMesh(level);
    scene::RefineOptions options;
    options.maxEdge = 32;
    scene::refine(mesh, options);
    std::vector<std::size_t> sizes;
    countLeaves(scene::makeCells(mesh, level), sizes);
    std::size_t sum = 0;
    for (const std::size_t size : sizes) sum += size;
    EXPECT_EQ(sum, mesh.triangles.size());
    EXPECT_LE(*std::max_element(sizes.begin(), sizes.end()), 2250U);
    const double mean = static_cast<double>(sum) / static_cast<double>(sizes.size());
    EXPECT_GT(mean, 600);
}

TEST(ShippedReceivers, AreFewerThanVerticesAndOnTheirSurfaces) {
    PIE_NEED_GAME_DATA();
    const level::Level level = load("maps/aggressor.bsp", false);
    scene::Mesh mesh = scene::makeMesh(level);
    scene::RefineOptions options;
    options.maxEdge = 64;
    scene::refine(mesh, options);
    const scene::Receivers receivers = scene::makeReceivers(mesh, level);
    EXPECT_LT(receivers.points.size(), mesh.vertices.size());
    EXPECT_GT(receivers.points.size(), mesh.vertices.size() / 4);
    std::size_t moved = 0;
    for (const scene::Receiver& receiver : receivers.points) {
        const float distance = glm::length(receiver.inset - receiver.position);
        EXPECT_LE(distance, 1.001F);
        moved += distance > 0.0F ? 1 : 0;
    }
    EXPECT_GT(moved, receivers.points.size() / 5);
    EXPECT_LT(moved, receivers.points.size());
}

} // namespace
} // namespace pie::test
