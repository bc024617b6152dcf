#include "pie/core/parallel.h"
#include "pie/scene/mesh.h"
#include "tests/scene/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace pie::test {
namespace {

using scene::Mesh;
using scene::refine;
using scene::RefineOptions;
using scene::RefineStatistics;

RefineOptions toEdge(float units) {
    RefineOptions options;
    options.maxEdge = units;
    return options;
}
RefineOptions bySplits(std::size_t splits) {
    RefineOptions options;
    options.maxSplits = splits;
    return options;
}

Mesh roomMesh(const Vec3& lower, const Vec3& upper) {
    LevelMaker maker;
    maker.room(maker.shader("wall"), lower, upper);
    return scene::makeMesh(maker.level);
}

TEST(Refine, SplitsTheLongestEdgeInItsMiddle) {
    Mesh mesh = soup({{0, 0, 0}, {8, 0, 0}, {0, 3, 0}});
    const RefineStatistics statistics = refine(mesh, bySplits(1));
    EXPECT_EQ(statistics.splits, 1U);
    ASSERT_EQ(mesh.triangles.size(), 2U);
    ASSERT_EQ(mesh.vertices.size(), 4U);
    EXPECT_EQ(mesh.vertices[3].position, Vec3(4, 1.5F, 0));
    EXPECT_EQ(mesh.vertices[3].texture, Vec2(4, 1.5F));
    EXPECT_FLOAT_EQ(statistics.longestEdge, 8.0F);
}

TEST(Refine, SplitsEveryTriangleOfTheEdgeWhateverItsSurface) {
    LevelMaker maker;
    const std::uint32_t red = maker.shader("red");
    maker.polygon(red, {{0, 0, 0}, {8, 0, 0}, {4, 2, 0}});
    maker.polygon(red, {{8, 0, 0}, {0, 0, 0}, {4, 0, 3}});
    maker.polygon(red, {{0, 0, 0}, {8, 0, 0}, {4, -2, -2}});
    Mesh mesh = scene::makeMesh(maker.level);
    const RefineStatistics statistics = refine(mesh, bySplits(1));
    EXPECT_EQ(statistics.splits, 3U) << "the edge is split as a whole, even past the wanted number";
    EXPECT_EQ(mesh.triangles.size(), 6U);
    EXPECT_EQ(mesh.vertices.size(), 9U + 3U) << "surfaces do not share attributes";
}

TEST(Refine, ReachesMaximumEdgeAndKeepsAreaAndClosure) {
    Mesh mesh = roomMesh({-100, -70, 0}, {212, 130, 96});
    const double area = areaOf(mesh);
    const RefineStatistics statistics = refine(mesh, toEdge(20));
    EXPECT_LE(longestEdgeOf(mesh), 20.0001);
    EXPECT_NEAR(statistics.longestEdge, longestEdgeOf(mesh), 1e-3);
    EXPECT_GT(statistics.longestEdge, 10.0F) << "an edge is halved only when it is too long";
    EXPECT_NEAR(areaOf(mesh), area, area * 1e-6);
    EXPECT_EQ(openEdges(mesh), 0U);
    EXPECT_EQ(countTJunctionsSorted(mesh), 0U);
    EXPECT_EQ(statistics.tJunctions, 0U) << "a room has none, and splitting whole edges makes none";
}

TEST(Refine, NewVerticesAreSharedWithinTheirSurface) {
    Mesh mesh = roomMesh(Vec3(0.0F), Vec3(64.0F));
    refine(mesh, toEdge(8.1F));
    // One floor: as many attribute vertices as positions, so none is made twice.
    for (std::uint32_t surface = 0; surface < 6; ++surface) {
        std::vector<std::uint32_t> used;
        for (const scene::MeshTriangle& triangle : mesh.triangles)
            if (triangle.surface == surface)
                used.insert(used.end(), triangle.vertices.begin(), triangle.vertices.end());
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
        std::vector<std::array<float, 3>> positions;
        for (const std::uint32_t v : used) {
            const Vec3& p = mesh.vertices[v].position;
            positions.push_back({p.x, p.y, p.z});
        }
        std::sort(positions.begin(), positions.end());
        positions.erase(std::unique(positions.begin(), positions.end()), positions.end());
        EXPECT_EQ(used.size(), positions.size());
    }
}

TEST(Refine, InterpolatesAttributes) {
    Mesh mesh = soup({{0, 0, 0}, {10, 0, 0}, {0, 2, 0}});
    mesh.vertices[1].normal = Vec3(0, 1, 0);
    mesh.vertices[2].normal = Vec3(0, 0, 1);
    mesh.vertices[1].lightmap = {1, 0};
    mesh.vertices[2].lightmap = {0, 1};
    mesh.vertices[1].colour = {200, 0, 10, 255};
    mesh.vertices[2].colour = {100, 255, 11, 255};
    refine(mesh, bySplits(1));
    ASSERT_EQ(mesh.vertices.size(), 4U);
    const level::Vertex& middle = mesh.vertices[3];
    EXPECT_NEAR(glm::length(middle.normal - Vec3(0, std::sqrt(0.5F), std::sqrt(0.5F))), 0.0F, 1e-6F);
    EXPECT_EQ(middle.lightmap, Vec2(0.5F));
    EXPECT_EQ(middle.colour.x, 150);
    EXPECT_EQ(middle.colour.y, 128);
    EXPECT_EQ(middle.colour.w, 255);
}

TEST(Refine, NothingToDoChangesNothing) {
    for (const RefineOptions& options : {bySplits(0), RefineOptions{}, toEdge(1000), toEdge(NAN)}) {
        Mesh mesh = roomMesh(Vec3(0.0F), Vec3(64.0F));
        const Mesh before = mesh;
        EXPECT_EQ(refine(mesh, options).splits, 0U);
        ASSERT_EQ(mesh.triangles.size(), before.triangles.size());
        EXPECT_EQ(mesh.vertices.size(), before.vertices.size());
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            EXPECT_EQ(mesh.triangles[t].vertices, before.triangles[t].vertices);
    }
    Mesh empty;
    EXPECT_EQ(refine(empty, toEdge(1)).longestEdge, 0.0F);
}

TEST(Refine, AMillionSplits) {
    Mesh mesh = roomMesh(Vec3(-512.0F), Vec3(512.0F));
    const RefineStatistics statistics = refine(mesh, bySplits(1'000'000));
    EXPECT_GE(statistics.splits, 1'000'000U);
    EXPECT_LE(statistics.splits, 1'000'001U) << "two triangles an edge";
    EXPECT_EQ(mesh.triangles.size(), 12U + statistics.splits);
    EXPECT_NEAR(areaOf(mesh), 6.0 * 1024 * 1024, 10.0);
}

TEST(Refine, MemoryIsBounded) {
    Mesh mesh = roomMesh(Vec3(0.0F), Vec3(64.0F));
    RefineOptions options = toEdge(0.0F);
    options.maxTriangles = 5000;
    refine(mesh, options);
    EXPECT_LE(mesh.triangles.size(), 5000U);
    EXPECT_GT(mesh.triangles.size(), 4900U);
}

TEST(Refine, EndsWhereFloatsHaveNoMiddle) {
    const float one = 1.0F;
    const float next = std::nextafter(one, 2.0F);
    Mesh mesh = soup({{one, 0, 0}, {next, 0, 0}, {one, next - one, 0}});
    const double area = areaOf(mesh);
    const RefineStatistics statistics = refine(mesh, toEdge(1e-9F));
    EXPECT_GT(statistics.splits, 10U);
    EXPECT_LT(statistics.splits, 1000U);
    EXPECT_NEAR(areaOf(mesh), area, 1e-6 * area);
}

TEST(Refine, SliversAndPointsEnd) {
    Mesh mesh = soup({{0, 0, 0},
                      {1000, 0, 0},
                      {500, 1e-4F, 0}, // sliver whose apex is on the edge
                      {0, 0, 0},
                      {1000, 0, 0},
                      {100, 0.5F, 0}, // sliver
                      {5, 5, 5},
                      {5, 5, 5},
                      {5, 5, 5}, // point
                      {0, 0, 1},
                      {10, 0, 1},
                      {20, 0, 1}, // line
                      {0, 0, 2},
                      {0, 0, 2},
                      {10, 3, 2}, // zero-length edge
                      {NAN, 0, 0},
                      {10, 3, 2},
                      {0, 3, 2}}); // not a number
    refine(mesh, toEdge(7));
    EXPECT_LE(longestEdgeOf(mesh), 7.001);
    EXPECT_EQ(countTJunctionsSorted(mesh), 0U);
    EXPECT_NEAR(areaOf(mesh), 250.0, 2.5) << "only the second sliver has area";
}

TEST(Refine, AnyScale) {
    for (const float scale : {1e-3F, 1.0F, 1e7F}) {
        Mesh mesh = roomMesh(Vec3(-0.5F * scale), Vec3(0.5F * scale, 0.3F * scale, 0.25F * scale));
        const double area = areaOf(mesh);
        refine(mesh, toEdge(0.05F * scale));
        EXPECT_LE(longestEdgeOf(mesh), 0.05001 * scale);
        EXPECT_GT(mesh.triangles.size(), 1000U);
        EXPECT_NEAR(areaOf(mesh), area, area * 1e-5);
        EXPECT_EQ(openEdges(mesh), 0U) << scale;
    }
}

TEST(Refine, FarFromTheOrigin) {
    Mesh mesh = roomMesh(Vec3(1e6F), Vec3(1e6F) + Vec3(256, 128, 64));
    refine(mesh, toEdge(16));
    EXPECT_EQ(openEdges(mesh), 0U);
    EXPECT_LE(longestEdgeOf(mesh), 16.2);
}

TEST(Refine, ClosesAndMakesNoTJunctionsOnRandomFloors) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
        std::mt19937 random(seed);
        Mesh mesh = cutFloor(random, 40, 512, seed % 2 == 0);
        const std::size_t before = countTJunctions(mesh);
        ASSERT_GT(before, 10U);
        const double area = areaOf(mesh);
        const RefineStatistics statistics = refine(mesh, toEdge(40));
        EXPECT_EQ(countTJunctionsSorted(mesh), 0U) << "seed " << seed;
        EXPECT_GE(statistics.tJunctions, 1U);
        EXPECT_LE(longestEdgeOf(mesh), 40.0001);
        EXPECT_NEAR(areaOf(mesh), area, area * 1e-4);
    }
}

TEST(Refine, ClosesTJunctionsOfTrianglesThatCross) {
    for (unsigned seed = 1; seed <= 6; ++seed) {
        std::mt19937 random(seed);
        std::uniform_int_distribution<int> coordinate(0, 32);
        std::vector<Vec3> corners;
        corners.reserve(300);
        for (int i = 0; i < 300; ++i) // on few planes and grid points, so that vertices meet edges often
            corners.emplace_back(8 * coordinate(random), 8 * coordinate(random), 64 * (i / 3 % 2));
        Mesh mesh = soup(corners);
        refine(mesh, toEdge(25));
        EXPECT_EQ(countTJunctionsSorted(mesh), 0U) << "seed " << seed;
        EXPECT_LE(longestEdgeOf(mesh), 25.0001);
    }
}

TEST(Refine, SameResultOnAnyNumberOfThreads) {
    std::vector<Mesh> meshes;
    for (const unsigned count : {1U, 2U}) {
        setThreads(count);
        std::mt19937 random(7);
        meshes.push_back(cutFloor(random, 60, 1000));
        refine(meshes.back(), toEdge(12));
    }
    setThreads(0);
    for (const Mesh& mesh : meshes) {
        ASSERT_EQ(mesh.vertices.size(), meshes[0].vertices.size());
        ASSERT_EQ(mesh.triangles.size(), meshes[0].triangles.size());
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            ASSERT_EQ(mesh.vertices[v].position, meshes[0].vertices[v].position);
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            ASSERT_EQ(mesh.triangles[t].vertices, meshes[0].triangles[t].vertices);
    }
}

TEST(Refine, ManyTrianglesOnOneEdge) {
    std::vector<Vec3> corners;
    for (int i = 0; i < 5000; ++i) {
        const float angle = static_cast<float>(i) * 0.00125F;
        corners.insert(corners.end(), {{0, 0, 0}, {0, 0, 90}, {40 * std::cos(angle), 40 * std::sin(angle), 45}});
    }
    Mesh mesh = soup(corners);
    const RefineStatistics statistics = refine(mesh, toEdge(61));
    EXPECT_EQ(statistics.splits, 5000U);
    EXPECT_EQ(mesh.triangles.size(), 10000U);
}

TEST(TJunctions, OneVertexOnOneEdge) {
    Mesh mesh = soup({{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 0, 0}, {3, 0, 0}, {0, -4, 0}});
    EXPECT_EQ(countTJunctions(mesh), 1U);
    EXPECT_EQ(scene::closeTJunctions(mesh), 1U);
    EXPECT_EQ(countTJunctions(mesh), 0U);
    ASSERT_EQ(mesh.triangles.size(), 3U);
    EXPECT_EQ(mesh.vertices.back().position, Vec3(3, 0, 0)) << "the vertex itself, to the bit";
    EXPECT_EQ(mesh.vertices.back().texture, Vec2(3, 0));
    EXPECT_EQ(scene::closeTJunctions(mesh), 0U);
}

TEST(TJunctions, ToleranceDecides) {
    const std::vector<Vec3> corners{{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, -3, 0}, {3, -0.005F, 0}, {0, -4, 0}};
    Mesh near = soup(corners);
    EXPECT_EQ(scene::closeTJunctions(near, 0.01F), 1U);
    Mesh far = soup(corners);
    EXPECT_EQ(scene::closeTJunctions(far, 0.004F), 0U);
    Mesh off = soup(corners);
    EXPECT_EQ(scene::closeTJunctions(off, 0.0F), 0U);
    EXPECT_EQ(scene::closeTJunctions(off, NAN), 0U);
}

TEST(TJunctions, RandomFloorsOfAnyKind) {
    for (unsigned seed = 20; seed < 40; ++seed) {
        std::mt19937 random(seed);
        Mesh mesh = cutFloor(random, 200, 4096, seed % 2 == 0);
        const double area = areaOf(mesh);
        EXPECT_GT(scene::closeTJunctions(mesh), 0U);
        EXPECT_EQ(countTJunctions(mesh), 0U) << "seed " << seed;
        EXPECT_NEAR(areaOf(mesh), area, area * 1e-4);
    }
}

TEST(TJunctions, DetailsMuchSmallerThanWalls) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> share(0.0F, 1.0F);
    std::vector<Vec3> corners{{-1e5F, 0, 0}, {1e5F, 0, 0}, {1e5F, 1e5F, 0}};
    for (int i = 0; i < 3000; ++i) {
        const Vec3 p(share(random), -share(random), share(random));
        corners.insert(corners.end(), {p, p + Vec3(0.02F, 0, 0), p + Vec3(0, 0.02F, 0)});
    }
    corners.insert(corners.end(), {{0.5F, 0, 0}, {0.5F, -1, 0}, {0.6F, -1, 0}});
    Mesh mesh = soup(corners);
    EXPECT_GE(scene::closeTJunctions(mesh), 1U);
    EXPECT_EQ(countTJunctionsSorted(mesh), 0U);
}

} // namespace
} // namespace pie::test
