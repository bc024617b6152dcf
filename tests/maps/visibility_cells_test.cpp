// Cells of a level's visibility: what they hold and what is seen from where, against the tree itself.

#include "pie/maps/visibility_cells.h"
#include "tests/maps/clouds.h"
#include "tests/maps/trees.h"

#include <gtest/gtest.h>

namespace pie::maps {
namespace {

constexpr float size = 100;

Vec3 place(std::mt19937& random) { return size * test::unit3(random); }

TEST(VisibilityCells, SeesWhatTheClusterSeesAndJoinsWholeLeaves) {
    std::mt19937 random(5);
    for (const std::size_t nodes : {2, 3, 20, 63, 64, 400}) {
        const level::Tree tree = test::randomTree(nodes, size, random);
        for (const std::size_t wanted : {1, 2, 7, 63, 1000}) {
            const VisibilityCells cells(tree, wanted);
            ASSERT_LE(cells.size(), std::min<std::size_t>(wanted, 63) + 1);
            std::vector<std::int64_t> cellOfLeaf(tree.leaves.size(), -1);
            std::vector<Vec3> points;
            for (int i = 0; i < 400; ++i) points.push_back(place(random));
            for (const Vec3& p : points) {
                const std::size_t leaf = tree.leafAt(p);
                const std::uint32_t cell = cells.cellAt(p);
                ASSERT_LT(cell, cells.size());
                ASSERT_TRUE(cellOfLeaf[leaf] < 0 || cellOfLeaf[leaf] == cell) << "a leaf in two cells";
                cellOfLeaf[leaf] = cell;
            }
            for (const Vec3& p : points) {
                const VisibilityCells::Set seen = cells.seenFrom(p);
                EXPECT_EQ(seen & 1U, 1U);
                const std::int32_t from = tree.leaves[tree.leafAt(p)].cluster;
                for (const Vec3& q : points) {
                    const std::int32_t to = tree.leaves[tree.leafAt(q)].cluster;
                    if (to < 0) continue; // rock goes with the cell around it
                    const bool may =
                        from < 0 || tree.visibility.sees(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
                    if (!may) continue;
                    ASSERT_TRUE(seen >> cells.cellAt(q) & 1U) << "something visible is not seen";
                }
            }
        }
    }
}

TEST(VisibilityCells, DoNotSeeBehindWalls) {
    const level::Tree tree = test::rooms(5, 100.0F, 90.0F);
    const VisibilityCells cells(tree);
    EXPECT_EQ(cells.size(), 6U);
    for (int from = 0; from < 5; ++from)
        for (int to = 0; to < 5; ++to) {
            const VisibilityCells::Set seen = cells.seenFrom({100.0F * static_cast<float>(from) + 45.0F, 0, 0});
            const std::uint32_t cell = cells.cellAt({100.0F * static_cast<float>(to) + 45.0F, 0, 0});
            EXPECT_EQ(seen >> cell & 1U, from == to ? 1U : 0U);
        }
    EXPECT_EQ(cells.cellAt({95.0F, 0, 0}), 0U) << "rock";
    EXPECT_EQ(cells.seenFrom({95.0F, 0, 0}), ~VisibilityCells::Set{0});
    EXPECT_EQ(cells.seenFrom(Vec3(std::numeric_limits<float>::quiet_NaN())), ~VisibilityCells::Set{0});
    // Two cells for five rooms: a room sees the others of its cell.
    const VisibilityCells two(tree, 2);
    EXPECT_EQ(two.size(), 3U);
}

TEST(VisibilityCells, WithoutVisibilityThereIsOne) {
    const VisibilityCells::Set all = ~VisibilityCells::Set{0};
    level::Tree tree = test::rooms(5, 100.0F, 90.0F);
    const auto expectOne = [&](const level::Tree& of) {
        const VisibilityCells cells(of);
        EXPECT_EQ(cells.size(), 1U);
        EXPECT_EQ(cells.cellAt({45.0F, 0, 0}), 0U);
        EXPECT_EQ(cells.seenFrom({45.0F, 0, 0}), all);
    };
    expectOne({});
    level::Tree blind = tree;
    blind.visibility = {};
    expectOne(blind);
    level::Tree cut = tree;
    cut.visibility.bits.pop_back();
    expectOne(cut);
    level::Tree circle = tree;
    circle.nodes[4].children[0] = 1;
    expectOne(circle);
    level::Tree torn = tree;
    torn.nodes[4].children[0] = 4711;
    expectOne(torn);
    torn.nodes[4].children[0] = -4711;
    expectOne(torn);
    torn = tree;
    torn.nodes[4].plane = 4711;
    expectOne(torn);
}

double areaOf(const std::vector<glm::dvec3>& corners) {
    glm::dvec3 sum(0);
    for (std::size_t i = 2; i < corners.size(); ++i)
        sum += glm::cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
    return 0.5 * glm::length(sum);
}

TEST(VisibilityCells, PiecesFillTheTriangleAndLieInTheirCells) {
    std::mt19937 random(6);
    const level::Tree tree = test::randomTree(200, size, random);
    const VisibilityCells cells(tree);
    ASSERT_GT(cells.size(), 30U);
    std::size_t pieces = 0;
    for (int i = 0; i < 300; ++i) {
        const std::vector<glm::dvec3> triangle{place(random), place(random), place(random)};
        const Vec3 offset = test::unit3(random);
        double area = 0;
        for (const auto& piece : cells.cut(triangle, glm::dvec3(offset))) {
            area += areaOf(piece.corners);
            ++pieces;
            for (std::size_t c = 2; c < piece.corners.size(); ++c) {
                const glm::dvec3 inside = (piece.corners[0] + piece.corners[c - 1] + piece.corners[c]) / 3.0;
                // Slivers lie on their planes.
                if (areaOf({piece.corners[0], piece.corners[c - 1], piece.corners[c]}) < 0.1) continue;
                EXPECT_EQ(cells.cellAt(Vec3(inside) + offset), piece.cell);
            }
        }
        EXPECT_NEAR(area, areaOf(triangle), 1e-9 * size * size);
    }
    EXPECT_GT(pieces, 1000U);
}

} // namespace
} // namespace pie::maps
