#include "pie/core/parallel.h"
#include "pie/scene/receivers.h"
#include "tests/scene/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <tuple>
#include <vector>

namespace pie::test {
namespace {

using scene::makeReceivers;
using scene::Mesh;
using scene::noReceiver;
using scene::Receiver;
using scene::Receivers;

const Receiver& at(const Receivers& receivers, const Vec3& position, const Vec3& normal = Vec3(0, 0, 1)) {
    for (const Receiver& receiver : receivers.points)
        if (receiver.position == position && glm::dot(receiver.normal, normal) > 0.999F) return receiver;
    ADD_FAILURE() << "no receiver there";
    static const Receiver none;
    return none;
}

TEST(Receivers, OnePerPositionAndNormal) {
    LevelMaker maker;
    maker.room(maker.shader("wall"), Vec3(0.0F), Vec3(64.0F));
    Mesh mesh = scene::makeMesh(maker.level);
    const Receivers coarse = makeReceivers(mesh, maker.level);
    EXPECT_EQ(coarse.points.size(), 24U) << "eight corners, three walls each";
    scene::RefineOptions options;
    options.maxEdge = 8;
    scene::refine(mesh, options);
    const Receivers fine = makeReceivers(mesh, maker.level);
    // Independently: distinct pairs of position and normal.
    std::set<std::tuple<float, float, float, float, float, float>> distinct;
    for (const scene::MeshTriangle& triangle : mesh.triangles)
        for (const std::uint32_t v : triangle.vertices) {
            const level::Vertex& vertex = mesh.vertices[v];
            distinct.insert({vertex.position.x, vertex.position.y, vertex.position.z, std::round(vertex.normal.x),
                             std::round(vertex.normal.y), std::round(vertex.normal.z)});
            const std::uint32_t r = fine.ofVertex[v];
            ASSERT_LT(r, fine.points.size());
            EXPECT_EQ(fine.points[r].position, vertex.position);
            EXPECT_NEAR(glm::dot(fine.points[r].normal, vertex.normal), 1.0F, 1e-5F);
        }
    EXPECT_EQ(fine.points.size(), distinct.size());
}

TEST(Receivers, AreSharedBySurfacesOfOnePlane) {
    LevelMaker maker;
    const std::uint32_t left = maker.shader("left");
    const std::uint32_t right = maker.shader("right");
    maker.polygon(left, {{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}});
    maker.polygon(right, {{64, 0, 0}, {128, 0, 0}, {128, 64, 0}, {64, 64, 0}});
    const Mesh mesh = scene::makeMesh(maker.level);
    EXPECT_EQ(mesh.vertices.size(), 8U);
    EXPECT_EQ(makeReceivers(mesh, maker.level).points.size(), 6U);
    maker.level.shaders[right].cull = level::Cull::None;
    const Receivers receivers = makeReceivers(mesh, maker.level);
    EXPECT_EQ(receivers.points.size(), 8U) << "one-sided and two-sided are lit differently";
    EXPECT_EQ(std::count_if(receivers.points.begin(), receivers.points.end(),
                            [](const Receiver& receiver) { return receiver.twoSided; }),
              4);
}

TEST(Receivers, UnlitSurfacesHaveNone) {
    LevelMaker maker;
    const auto add = [&](const char* name, const auto& change) {
        const std::uint32_t shader = maker.shader(name);
        change(maker.level.shaders[shader]);
        const auto z = static_cast<float>(shader);
        maker.polygon(shader, {{0, 0, z}, {8, 0, z}, {0, 8, z}});
    };
    add("lightmapped", [](level::Shader&) {});
    add("flame", [](level::Shader& shader) {
        shader.stages.erase(shader.stages.begin());
        shader.stages[0].blend = {level::BlendFactor::One, level::BlendFactor::One};
    });
    for (const level::RgbGen gen : {level::RgbGen::Vertex, level::RgbGen::ExactVertex, level::RgbGen::LightingDiffuse})
        add("vertex lit", [gen](level::Shader& shader) {
            shader.stages.erase(shader.stages.begin());
            shader.stages[0].rgbGen = gen;
        });
    const Mesh mesh = scene::makeMesh(maker.level);
    const Receivers receivers = makeReceivers(mesh, maker.level);
    ASSERT_EQ(receivers.ofVertex.size(), 15U);
    for (std::size_t v = 0; v < 15; ++v)
        EXPECT_EQ(receivers.ofVertex[v] == noReceiver, mesh.vertices[v].position.z == 1.0F) << v;
    EXPECT_EQ(receivers.points.size(), 12U);
}

TEST(ReceiverInset, LeavesBordersByAUnitAtMost) {
    LevelMaker maker;
    maker.polygon(maker.shader("floor"), {{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}});
    Mesh mesh = scene::makeMesh(maker.level);
    scene::RefineOptions options;
    options.maxEdge = 16;
    scene::refine(mesh, options);
    const Receivers receivers = makeReceivers(mesh, maker.level);
    const auto inset = [&](const Vec3& p) { return at(receivers, p).inset - p; };
    EXPECT_NEAR(glm::length(inset({0, 0, 0}) - Vec3(std::sqrt(0.5F), std::sqrt(0.5F), 0)), 0, 1e-4F);
    EXPECT_NEAR(glm::length(inset({64, 64, 0}) + Vec3(std::sqrt(0.5F), std::sqrt(0.5F), 0)), 0, 1e-4F);
    EXPECT_NEAR(glm::length(inset({0, 32, 0}) - Vec3(1, 0, 0)), 0, 1e-4F) << "whatever the triangles are";
    EXPECT_EQ(inset({32, 32, 0}), Vec3(0.0F)) << "no border near";
    for (const Receiver& receiver : receivers.points) {
        const Vec3& p = receiver.inset;
        EXPECT_LE(glm::length(p - receiver.position), 1.0001F);
        EXPECT_EQ(p.z, 0.0F);
        EXPECT_TRUE(p.x > 0.5F && p.x < 63.5F && p.y > 0.5F && p.y < 63.5F);
    }
}

TEST(ReceiverInset, ReentrantCornersGoInwardsToo) {
    LevelMaker maker;
    const std::uint32_t shader = maker.shader("floor");
    maker.polygon(shader, {{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}});
    maker.polygon(shader, {{64, 64, 0}, {64, 0, 0}, {128, 0, 0}, {128, 64, 0}});
    maker.polygon(shader, {{64, 64, 0}, {64, 128, 0}, {0, 128, 0}, {0, 64, 0}});
    const Receivers receivers = makeReceivers(scene::makeMesh(maker.level), maker.level);
    const Vec3 inset = at(receivers, {64, 64, 0}).inset - Vec3(64, 64, 0);
    EXPECT_NEAR(inset.x, -std::sqrt(0.5F), 1e-3F);
    EXPECT_NEAR(inset.y, -std::sqrt(0.5F), 1e-3F);
}

TEST(ReceiverInset, StaysOnTheSurface) {
    // Fans of all shapes: the inset point must lie in one of the triangles of its receiver.
    std::mt19937 random(5);
    std::uniform_real_distribution<float> turn(0.05F, 1.2F);
    std::uniform_real_distribution<float> reach(0.5F, 60);
    LevelMaker maker;
    maker.polygon(maker.shader("any"), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    for (int round = 0; round < 300; ++round) {
        std::vector<Vec3> corners;
        float angle = 0;
        const float full = 0.2F + 0.02F * static_cast<float>(round);
        Vec3 before(reach(random), 0, 0);
        while (angle < std::min(full, 6.0F)) {
            angle += turn(random);
            if (angle > 6.1F) break;
            const float r = reach(random);
            const Vec3 next(r * std::cos(angle), r * std::sin(angle), 0);
            if (round % 5 != 0 || corners.size() % 2 == 0) corners.insert(corners.end(), {Vec3(0.0F), before, next});
            before = next;
        }
        if (corners.empty()) continue;
        Mesh mesh = soup(corners);
        for (level::Vertex& vertex : mesh.vertices) vertex.normal = Vec3(0, 0, 1);
        const Receivers receivers = makeReceivers(mesh, maker.level);
        for (const Receiver& receiver : receivers.points) {
            bool inside = false;
            for (std::size_t i = 0; i < corners.size(); i += 3) {
                const auto area = [](const Vec3& a, const Vec3& b, const Vec3& c) {
                    return double(b.x - a.x) * (c.y - a.y) - double(b.y - a.y) * (c.x - a.x);
                };
                const Vec3& p = receiver.inset;
                const double whole = area(corners[i], corners[i + 1], corners[i + 2]);
                inside =
                    inside || std::min({area(p, corners[i], corners[i + 1]), area(p, corners[i + 1], corners[i + 2]),
                                        area(p, corners[i + 2], corners[i])}) > -1e-5 * whole - 1e-5;
            }
            EXPECT_TRUE(inside) << "round " << round;
            EXPECT_LE(glm::length(receiver.inset - receiver.position), 1.0001F);
        }
    }
}

TEST(ReceiverInset, FollowsTheLevelsScale) {
    for (const float scale : {1e-3F, 1e7F}) {
        LevelMaker maker;
        maker.room(maker.shader("wall"), Vec3(0.0F), Vec3(scale));
        const Receivers receivers = makeReceivers(scene::makeMesh(maker.level), maker.level);
        ASSERT_EQ(receivers.points.size(), 24U);
        for (const Receiver& receiver : receivers.points) {
            const float moved = glm::length(receiver.inset - receiver.position);
            EXPECT_LE(moved, std::min(1.5F, 0.15F * scale));
            EXPECT_GT(moved, std::min(0.5F, 0.01F * scale));
        }
    }
}

TEST(Receivers, SurviveBadNormals) {
    Mesh mesh = soup({{0, 0, 0}, {8, 0, 0}, {0, 8, 0}});
    mesh.vertices[0].normal = Vec3(0.0F);
    mesh.vertices[1].normal = Vec3(NAN);
    mesh.vertices[2].normal = Vec3(0, 0, 5);
    const Receivers receivers = makeReceivers(mesh, level::Level{});
    ASSERT_EQ(receivers.points.size(), 3U);
    for (const Receiver& receiver : receivers.points) EXPECT_EQ(receiver.normal, Vec3(0, 0, 1));
    EXPECT_TRUE(makeReceivers({}, {}).points.empty());
}

TEST(Receivers, SameOnAnyNumberOfThreads) {
    LevelMaker maker;
    maker.room(maker.shader("wall"), Vec3(0.0F), Vec3(256.0F));
    Mesh mesh = scene::makeMesh(maker.level);
    scene::RefineOptions options;
    options.maxEdge = 8;
    scene::refine(mesh, options);
    setThreads(1);
    const Receivers one = makeReceivers(mesh, maker.level);
    setThreads(2);
    const Receivers two = makeReceivers(mesh, maker.level);
    setThreads(0);
    ASSERT_EQ(one.points.size(), two.points.size());
    EXPECT_EQ(one.ofVertex, two.ofVertex);
    for (std::size_t i = 0; i < one.points.size(); ++i) ASSERT_EQ(one.points[i].inset, two.points[i].inset);
}

} // namespace
} // namespace pie::test
