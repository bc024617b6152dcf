#include "pie/scene/cells.h"
#include "tests/scene/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace pie::test {
namespace {

using scene::CellNode;
using scene::makeCells;
using scene::Mesh;

void collect(const CellNode& node, std::vector<const CellNode*>& leaves) {
    if (node.children.empty())
        leaves.push_back(&node);
    else
        EXPECT_TRUE(node.triangles.empty()) << "triangles only in nodes without children";
    EXPECT_NE(node.children.size(), 1U);
    for (const CellNode& child : node.children) collect(child, leaves);
}

std::vector<const CellNode*> leavesOf(const CellNode& root) {
    std::vector<const CellNode*> leaves;
    collect(root, leaves);
    return leaves;
}

void expectPartition(const CellNode& root, const Mesh& mesh) {
    std::vector<int> seen(mesh.triangles.size(), 0);
    for (const CellNode* leaf : leavesOf(root))
        for (const std::uint32_t t : leaf->triangles) ++seen.at(t);
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](int count) { return count == 1; }));
}

Mesh fine(const level::Level& level, float edge) {
    Mesh mesh = scene::makeMesh(level);
    scene::RefineOptions options;
    options.maxEdge = edge;
    scene::refine(mesh, options);
    return mesh;
}

/// Rooms in a row, and a tree that parts them.
LevelMaker rooms(int count) {
    LevelMaker maker;
    const std::uint32_t shader = maker.shader("wall");
    for (int i = 0; i < count; ++i) {
        const auto x = static_cast<float>(300 * i);
        maker.room(shader, {x, 0, 0}, {x + 256, 256, 128});
        if (i == 0) continue;
        level::Tree::Node& node = maker.level.tree.nodes.emplace_back();
        node.plane = static_cast<std::uint32_t>(i - 1);
        node.children = {i + 1 < count ? i : -(i + 1), -i};
        maker.level.tree.planes.push_back({{1, 0, 0}, x - 20});
    }
    maker.level.tree.leaves.resize(static_cast<std::size_t>(count) + 1);
    return maker;
}

TEST(Cells, FollowTheLevelsTree) {
    const LevelMaker maker = rooms(5);
    const Mesh mesh = fine(maker.level, 16);
    const std::size_t each = mesh.triangles.size() / 5;
    const CellNode root = makeCells(mesh, maker.level, each + each / 10);
    expectPartition(root, mesh);
    const std::vector<const CellNode*> leaves = leavesOf(root);
    EXPECT_EQ(leaves.size(), 5U);
    for (const CellNode* leaf : leaves) {
        Box bounds;
        for (const std::uint32_t t : leaf->triangles)
            for (const std::uint32_t v : mesh.triangles[t].vertices) bounds.extend(mesh.vertices[v].position);
        EXPECT_LE(bounds.size().x, 256.0F) << "one room";
    }
}

TEST(Cells, AreNeitherCrumbsNorTooBig) {
    const LevelMaker maker = rooms(9);
    const Mesh mesh = fine(maker.level, 12);
    for (const std::size_t wanted : {100UL, 700UL, 2000UL}) {
        const CellNode root = makeCells(mesh, maker.level, wanted);
        expectPartition(root, mesh);
        for (const CellNode* leaf : leavesOf(root)) {
            EXPECT_LE(leaf->triangles.size(), wanted + wanted / 2);
            EXPECT_GE(leaf->triangles.size(), wanted / 8);
        }
    }
}

TEST(Cells, CullPieceByPiece) {
    LevelMaker maker;
    maker.polygon(maker.shader("floor"), {{0, 0, 0}, {2048, 0, 0}, {2048, 2048, 0}, {0, 2048, 0}});
    const Mesh mesh = fine(maker.level, 24);
    const std::vector<const CellNode*> leaves = [&] {
        static CellNode root;
        root = makeCells(mesh, maker.level, 1000);
        expectPartition(root, mesh);
        return leavesOf(root);
    }();
    EXPECT_GE(leaves.size(), mesh.triangles.size() / 1500);
    double boxes = 0;
    for (const CellNode* leaf : leaves) {
        Box bounds;
        for (const std::uint32_t t : leaf->triangles)
            for (const std::uint32_t v : mesh.triangles[t].vertices) bounds.extend(mesh.vertices[v].position);
        boxes += static_cast<double>(bounds.size().x) * bounds.size().y;
    }
    EXPECT_LT(boxes, 1.3 * 2048 * 2048) << "cells of one floor hardly overlap";
}

TEST(Cells, SubmodelsStandApart) {
    LevelMaker maker = rooms(2);
    maker.level.models.resize(3);
    maker.polygon(0, {{10, 10, 10}, {40, 10, 10}, {40, 40, 10}}, 1);
    maker.polygon(0, {{10, 10, 20}, {40, 10, 20}, {40, 40, 20}}, 2);
    const Mesh mesh = fine(maker.level, 64);
    const CellNode root = makeCells(mesh, maker.level, 100000);
    expectPartition(root, mesh);
    ASSERT_EQ(root.children.size(), 3U);
    for (const CellNode& child : root.children) {
        std::vector<std::uint32_t> models;
        for (const CellNode* leaf : leavesOf(child))
            for (const std::uint32_t t : leaf->triangles)
                models.push_back(maker.level.surfaces[mesh.triangles[t].surface].model);
        EXPECT_TRUE(std::all_of(models.begin(), models.end(), [&](std::uint32_t m) { return m == models[0]; }));
    }
}

TEST(Cells, EmptyAndTiny) {
    EXPECT_TRUE(makeCells({}, {}).triangles.empty());
    const Mesh one = soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    EXPECT_EQ(makeCells(one, {}).triangles.size(), 1U);
    EXPECT_EQ(makeCells(one, {}, 0).triangles.size(), 1U);
}

TEST(Cells, TrianglesInOnePlaceAndDamagedTrees) {
    std::vector<Vec3> corners;
    for (int i = 0; i < 5000; ++i) corners.insert(corners.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    const Mesh heap = soup(corners);
    level::Level level;
    level.surfaces.emplace_back();
    expectPartition(makeCells(heap, level, 100), heap);
    level.tree.planes.push_back({{1, 0, 0}, 0.25F});
    level.tree.nodes.resize(2);
    level.tree.nodes[0].children = {1, 1};
    level.tree.nodes[1].children = {0, 77};
    level.tree.nodes[1].plane = 0;
    expectPartition(makeCells(heap, level, 100), heap);
}

} // namespace
} // namespace pie::test
