// A lamp behind a board: the shadow's edge gets the vertices.
#include "pie/core/parallel.h"
#include "pie/engine/engine.h"
#include "tests/level/make_level.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace pie::engine {
namespace {

/// The board in x = 0 ends at the lamp's height, so that the wall x = 256 is dark below z = 0 for |y| < 192.
std::shared_ptr<const level::Level> boardInARoom(bool lamp = true) {
    test::LevelBuilder builder;
    const int wall = builder.shader("textures/made/wall");
    builder.room(Vec3(-256), Vec3(256), {wall, wall, wall, wall, wall, wall});
    builder.polygon(wall, {{0, 64, -256}, {0, -64, -256}, {0, -64, 0}, {0, 64, 0}});
    if (lamp) builder.entity({{"classname", "light"}, {"origin", "-128 0 0"}, {"light", "2000"}});
    auto level = level::loadLevel(test::inMemory(builder.build()));
    EXPECT_TRUE(level) << level.error().message();
    return std::make_shared<const level::Level>(std::move(*level));
}

Settings byLight() {
    Settings settings;
    settings.refineBy = RefineBy::Light;
    settings.refineError = 20;
    return settings;
}

/// Longest sides of the triangles of the wall x = 256 that come near a height, between two shadows' corners.
std::pair<float, float> sidesAt(const scene::Mesh& mesh, float height) {
    float shortest = 1e9F;
    float longest = 0;
    for (const scene::MeshTriangle& triangle : mesh.triangles) {
        float side = 0;
        float low = 1e9F;
        float high = -1e9F;
        bool counts = true;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 p = mesh.vertices[triangle.vertices[i]].position;
            const Vec3 q = mesh.vertices[triangle.vertices[(i + 1) % 3]].position;
            side = std::max(side, glm::distance(p, q));
            low = std::min(low, p.z);
            high = std::max(high, p.z);
            counts = counts && p.x == 256.0F && std::abs(p.y) < 150.0F;
        }
        if (!counts || low > height || high < height) continue;
        shortest = std::min(shortest, side);
        longest = std::max(longest, side);
    }
    return {shortest, longest};
}

} // namespace

TEST(RefineByLight, TheEdgeOfAShadowGetsTheTriangles) {
    const Engine engine(boardInARoom(), byLight());
    const auto [shortest, longest] = sidesAt(engine.mesh(), -1.0F); // 64 / 8, and its diagonal
    EXPECT_LE(longest, 32.0F);
    EXPECT_LE(shortest, 16.1F);
    EXPECT_GE(sidesAt(engine.mesh(), 140.0F).second, 64.0F) << "where light changes slowly";
    scene::Mesh closed = engine.mesh();
    EXPECT_EQ(scene::closeTJunctions(closed), 0U);
    Settings length = byLight();
    length.refineBy = RefineBy::Length;
    length.maxEdge = 16;
    EXPECT_LT(engine.mesh().vertices.size(), Engine(boardInARoom(), length).mesh().vertices.size() / 2);
}

TEST(RefineByLight, KeepsToItsVertices) {
    Settings settings = byLight();
    settings.refineError = 0.1F;
    settings.maxVertices = 1000;
    const Engine engine(boardInARoom(), settings);
    EXPECT_LE(engine.mesh().vertices.size(), 1000U);
    EXPECT_GT(engine.mesh().vertices.size(), 950U);
}

TEST(RefineByLight, SameMeshOnAnyNumberOfThreads) {
    std::vector<level::Vertex> first;
    for (const unsigned threadCount : {1U, 2U}) {
        setThreads(threadCount);
        Engine engine(boardInARoom(), byLight(), Refinement::Later);
        engine.complete();
        const std::vector<level::Vertex>& vertices = engine.mesh().vertices;
        if (first.empty()) first = vertices;
        ASSERT_EQ(first.size(), vertices.size());
        for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].position, vertices[i].position);
    }
    setThreads(0);
}

TEST(RefineByLight, WithoutSplitsTheLevelsOwnTrianglesAreDrawn) {
    Settings settings = byLight();
    settings.meshRefinement = 0;
    EXPECT_EQ(Engine(boardInARoom(), settings).mesh().triangles.size(), 14U);
}

} // namespace pie::engine
