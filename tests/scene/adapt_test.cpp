#include "pie/scene/adapt.h"
#include "tests/scene/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pie::test {
namespace {

using scene::adapt;
using scene::AdaptOptions;
using scene::AdaptStatistics;
using scene::Mesh;
using scene::SurfacePoint;

/// The light of a sun behind a wall: a sharp edge in the planes x + 0.3 y = 37, and none elsewhere.
float shadow(const Vec3& p) { return p.x + 0.3F * p.y < 37.0F ? 100.0F : 0.0F; }

scene::ValueAt everywhere(float (*value)(const Vec3&)) {
    return [value](std::span<const SurfacePoint> points, std::span<float> values) {
        for (std::size_t i = 0; i < points.size(); ++i) values[i] = value(points[i].position);
    };
}

Mesh roomOf512() {
    LevelMaker maker;
    maker.room(maker.shader("room"), Vec3(-256.0F), Vec3(256.0F));
    return scene::makeMesh(maker.level);
}

AdaptOptions options() {
    AdaptOptions options;
    options.coarseEdge = 128;
    options.smallestEdge = 4;
    return options;
}

float longestSide(const Mesh& mesh, const scene::MeshTriangle& triangle) {
    float longest = 0;
    for (std::size_t i = 0; i < 3; ++i)
        longest = std::max(longest, glm::distance(mesh.vertices[triangle.vertices[i]].position,
                                                  mesh.vertices[triangle.vertices[(i + 1) % 3]].position));
    return longest;
}

TEST(Adapt, TrianglesGatherAtTheEdgeOfAShadow) {
    Mesh mesh = roomOf512();
    const double area = areaOf(mesh);
    const AdaptStatistics statistics = adapt(mesh, options(), everywhere(shadow));
    EXPECT_GT(statistics.splits, 500U);
    EXPECT_EQ(countTJunctionsSorted(mesh), 0U);
    EXPECT_EQ(openEdges(mesh), 0U);
    EXPECT_NEAR(areaOf(mesh), area, area * 1e-6);
    std::size_t far = 0;
    for (const scene::MeshTriangle& triangle : mesh.triangles) {
        float nearest = 1e9F;
        bool lit = false;
        bool dark = false;
        for (const std::uint32_t v : triangle.vertices) {
            const Vec3 p = mesh.vertices[v].position;
            nearest = std::min(nearest, std::abs(p.x + 0.3F * p.y - 37.0F));
            (shadow(p) > 0.0F ? lit : dark) = true;
        }
        if (lit && dark) {
            EXPECT_LT(longestSide(mesh, triangle), 4 * 4.0F) << "across the shadow's edge";
        }
        if (nearest > 150.0F && longestSide(mesh, triangle) > 64.0F) ++far;
    }
    EXPECT_GT(far, 100U) << "away from it the mesh stays coarse";
    Mesh even = roomOf512();
    scene::RefineOptions byLength;
    byLength.maxEdge = 16;
    refine(even, byLength);
    EXPECT_LT(mesh.vertices.size(), even.vertices.size() / 3);
}

TEST(Adapt, TrianglesDoNotGetThinner) {
    Mesh mesh = roomOf512();
    adapt(mesh, options(), everywhere(shadow));
    for (const scene::MeshTriangle& triangle : mesh.triangles) {
        const auto at = [&](std::size_t i) { return mesh.vertices[triangle.vertices[i]].position; };
        const float twiceArea = glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
        const float longest = longestSide(mesh, triangle);
        EXPECT_GT(twiceArea / (longest * longest), 0.2F); // a right triangle of two equal sides has 0.5
    }
}

TEST(Adapt, NothingIsSplitWhereNothingChanges) {
    Mesh mesh = roomOf512();
    Mesh coarse = mesh;
    scene::RefineOptions byLength;
    byLength.maxEdge = options().coarseEdge;
    refine(coarse, byLength);
    // A slope is what interpolation can do; a change below the tolerance is none.
    for (const auto value : {+[](const Vec3&) { return 5.0F; }, +[](const Vec3& p) { return p.x - 2 * p.y; },
                             +[](const Vec3& p) { return p.x < 37.0F ? 0.0F : 7.0F; }}) {
        Mesh adapted = mesh;
        const AdaptStatistics statistics = adapt(adapted, options(), everywhere(value));
        EXPECT_EQ(statistics.splits, 0U);
        EXPECT_GT(statistics.probes, coarse.vertices.size());
        EXPECT_EQ(adapted.triangles.size(), coarse.triangles.size());
    }
}

TEST(Adapt, KeepsToItsVerticesAndSpendsThemWhereMostIsOff) {
    AdaptOptions bounded = options();
    for (const std::size_t most : {std::size_t{24}, std::size_t{500}, std::size_t{1000}}) {
        Mesh mesh = roomOf512();
        bounded.maxVertices = most;
        adapt(mesh, bounded, everywhere(+[](const Vec3& p) {
                  return (p.x < 37.0F ? 1000.0F : 0.0F) + (p.y < -100.0F ? 10.0F : 0.0F);
              }));
        EXPECT_LE(mesh.vertices.size(), most);
        if (most < 1000) continue;
        EXPECT_GE(mesh.vertices.size() + 4, most);
        const auto shortest = [&](int axis, float plane) {
            float least = 1e9F;
            for (const scene::MeshTriangle& triangle : mesh.triangles)
                for (const std::uint32_t v : triangle.vertices)
                    if (std::abs(mesh.vertices[v].position[axis] - plane) < 16.0F)
                        least = std::min(least, longestSide(mesh, triangle));
            return least;
        };
        EXPECT_LT(shortest(0, 37.0F), 32.0F);
    }
}

TEST(Adapt, ExtremesComeToAnEnd) {
    for (const float value : {std::nanf(""), 1e38F, -1e38F}) {
        Mesh mesh = roomOf512();
        adapt(mesh, options(), [value](std::span<const SurfacePoint> points, std::span<float> values) {
            for (std::size_t i = 0; i < points.size(); ++i) values[i] = points[i].position.x < 37.0F ? value : 0.0F;
        });
        EXPECT_EQ(openEdges(mesh), 0U);
    }
    Mesh empty;
    EXPECT_EQ(adapt(empty, options(), everywhere(shadow)).splits, 0U);
    Mesh tiny = roomOf512();
    AdaptOptions small = options();
    small.smallestEdge = 0;
    small.maxTriangles = 5000;
    adapt(tiny, small, everywhere(shadow));
    EXPECT_LE(tiny.triangles.size(), 5000U);
}

} // namespace
} // namespace pie::test
