#include "pie/level/patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <tuple>

using namespace pie;
using namespace pie::level;

namespace {

struct Grid {
    int width = 3, height = 3;
    std::vector<PatchVertex> controls;
    [[nodiscard]] std::size_t index(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
    }
    PatchVertex& at(int column, int row) { return controls[index(column, row)]; }
    [[nodiscard]] const PatchVertex& at(int column, int row) const { return controls[index(column, row)]; }
    [[nodiscard]] PatchMesh mesh(float tolerance = 1.0F) const {
        return tessellate(controls, width, height, tolerance);
    }
};

Grid makeGrid(int width, int height, const std::function<Vec3(int, int)>& position) {
    Grid grid{width, height, {}};
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            PatchVertex v;
            v.position = position(column, row);
            v.normal = Vec3(0, 0, 1);
            v.texture = Vec2(column, row);
            v.lightmap = Vec2(column, row) / 16.0F;
            v.colour = Vec4(10.0F * static_cast<float>(column), 20.0F * static_cast<float>(row), 0, 255);
            grid.controls.push_back(v);
        }
    return grid;
}

Grid flatGrid(int width, int height, float step = 64) {
    return makeGrid(width, height,
                    [=](int c, int r) { return Vec3(step * static_cast<float>(c), step * static_cast<float>(r), 0); });
}

/// Positions compare bit by bit (no zeros of two signs occur here).
using Key = std::tuple<float, float, float>;
Key key(const Vec3& p) { return {p.x, p.y, p.z}; }

/// Edges that belong to one triangle only, as pairs of positions in the triangle's direction.
std::vector<std::pair<Key, Key>> borderOf(const PatchMesh& mesh) {
    std::map<std::pair<Key, Key>, int> count;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k)
            ++count[{key(mesh.vertices[mesh.indices[i + k]].position),
                     key(mesh.vertices[mesh.indices[i + (k + 1) % 3]].position)}];
    std::vector<std::pair<Key, Key>> border;
    for (const auto& [edge, uses] : count) {
        EXPECT_EQ(uses, 1) << "an edge is used twice in one direction";
        if (!count.contains({edge.second, edge.first})) border.push_back(edge);
    }
    return border;
}

double areaOf(const PatchMesh& mesh) {
    double area = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const Vec3& a = mesh.vertices[mesh.indices[i]].position;
        area += 0.5 * glm::length(glm::cross(mesh.vertices[mesh.indices[i + 1]].position - a,
                                             mesh.vertices[mesh.indices[i + 2]].position - a));
    }
    return area;
}

Vec3 curve(const Vec3& a, const Vec3& b, const Vec3& c, float t) {
    return (1 - t) * (1 - t) * a + 2 * t * (1 - t) * b + t * t * c;
}

Vec3 surface(const Grid& grid, float u, float v) {
    const int column = std::min(static_cast<int>(u), (grid.width - 1) / 2 - 1) * 2;
    const int row = std::min(static_cast<int>(v), (grid.height - 1) / 2 - 1) * 2;
    const float s = u - static_cast<float>(column) / 2;
    const float t = v - static_cast<float>(row) / 2;
    Vec3 rows[3];
    for (int r = 0; r < 3; ++r)
        rows[r] = curve(grid.at(column, row + r).position, grid.at(column + 1, row + r).position,
                        grid.at(column + 2, row + r).position, s);
    return curve(rows[0], rows[1], rows[2], t);
}

/// Distance of a point to the nearest triangle's plane patch, by brute force.
double distanceToMesh(const Vec3& p, const PatchMesh& mesh) {
    double best = 1e30;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const Vec3 a = mesh.vertices[mesh.indices[i]].position;
        const Vec3 ab = mesh.vertices[mesh.indices[i + 1]].position - a;
        const Vec3 ac = mesh.vertices[mesh.indices[i + 2]].position - a;
        // Dense sampling of the triangle is enough for a bound that is compared with a tolerance.
        for (int s = 0; s <= 12; ++s)
            for (int t = 0; s + t <= 12; ++t)
                best = std::min<double>(
                    best, glm::length(a + ab * (static_cast<float>(s) / 12) + ac * (static_cast<float>(t) / 12) - p));
    }
    return best;
}

} // namespace

TEST(Patch, FlatPatchesAreTwoTrianglesPerPiece) {
    EXPECT_EQ(flatGrid(3, 3).mesh().indices.size(), 6U);
    EXPECT_EQ(flatGrid(5, 3).mesh().indices.size(), 12U);
    EXPECT_EQ(flatGrid(5, 5).mesh().indices.size(), 24U);
    EXPECT_NEAR(areaOf(flatGrid(5, 5).mesh()), 256.0 * 256, 1e-3);
}

TEST(Patch, TheFrontIsWhereRowsCrossColumns) {
    for (const auto& [w, h] : {std::pair(3, 3), std::pair(5, 3), std::pair(3, 5), std::pair(7, 5)})
        for (const float bow : {0.0F, 40.0F}) {
            Grid grid = flatGrid(w, h);
            for (int r = 0; r < h; ++r)
                for (int c = 0; c < w; ++c) grid.at(c, r).position.z = bow * static_cast<float>((c % 2) + 2 * (r % 2));
            const PatchMesh mesh = grid.mesh();
            for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
                const Vec3& a = mesh.vertices[mesh.indices[i]].position;
                const Vec3 n = glm::cross(mesh.vertices[mesh.indices[i + 1]].position - a,
                                          mesh.vertices[mesh.indices[i + 2]].position - a);
                EXPECT_GT(n.z, 0) << w << "x" << h << " triangle " << i / 3;
            }
        }
}

TEST(Patch, VerticesLieOnTheSurfaceAndChordsNearIt) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> offset(-60, 60);
    for (const float tolerance : {0.5F, 4.0F}) {
        Grid grid = flatGrid(5, 5, 64);
        for (PatchVertex& v : grid.controls) v.position.z = offset(random);
        const PatchMesh mesh = grid.mesh(tolerance);
        for (const PatchVertex& v : mesh.vertices) {
            // x and y are linear in the parameters here, so they tell where on the surface the vertex should be.
            const Vec3 expected = surface(grid, v.position.x / 128, v.position.y / 128);
            EXPECT_NEAR(v.position.z, expected.z, 1e-3);
        }
        double worst = 0;
        for (int i = 0; i <= 20; ++i)
            for (int j = 0; j <= 20; ++j)
                worst = std::max(
                    worst, distanceToMesh(surface(grid, static_cast<float>(i) / 10, static_cast<float>(j) / 10), mesh));
        // Both directions and the twist may err by the tolerance; the rest is the sampling of the triangles.
        EXPECT_LT(worst, 3 * tolerance + 1.5);
    }
}

TEST(Patch, AFinerToleranceApproachesTheTrueArea) {
    // A quarter of a cylinder of radius 128, length 256, as a quadratic arc: compare with its arc length by Simpson.
    const Grid grid = makeGrid(3, 3, [](int c, int r) {
        return std::array{Vec3(128, 0, 0), Vec3(128, 128, 0), Vec3(0, 128, 0)}[static_cast<std::size_t>(c)] +
               Vec3(0, 0, 128.0F * static_cast<float>(r));
    });
    double length = 0;
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
        const auto point = [&](int k) {
            return curve({128, 0, 0}, {128, 128, 0}, {0, 128, 0}, static_cast<float>(k) / n);
        };
        length += glm::length(point(i + 1) - point(i));
    }
    const double exact = length * 256;
    double before = 1;
    for (const float tolerance : {8.0F, 1.0F, 0.05F}) {
        const double error = std::abs(areaOf(grid.mesh(tolerance)) / exact - 1);
        EXPECT_LE(error, before);
        before = error;
    }
    EXPECT_LT(before, 1e-3);
}

TEST(Patch, AttributesFollowTheSameCurve) {
    Grid grid = flatGrid(3, 3);
    for (int r = 0; r < 3; ++r) grid.at(1, r).position.z = 100;
    for (int r = 0; r < 3; ++r) grid.at(1, r).normal = Vec3(1, 0, 0);
    const PatchMesh mesh = grid.mesh(0.25F);
    ASSERT_GT(mesh.vertices.size(), 8U);
    for (const PatchVertex& v : mesh.vertices) {
        const float t = v.position.x / 128;
        EXPECT_NEAR(v.texture.x, 2 * t, 1e-4);
        EXPECT_NEAR(v.lightmap.x, 2 * t / 16, 1e-5);
        EXPECT_NEAR(v.colour.x, 20 * t, 1e-3);
        EXPECT_NEAR(v.colour.w, 255, 1e-3);
        EXPECT_NEAR(glm::length(v.normal), 1, 1e-5);
        const Vec3 expected = glm::normalize(curve({0, 0, 1}, {1, 0, 0}, {0, 0, 1}, t));
        EXPECT_NEAR(glm::dot(v.normal, expected), 1, 1e-4);
    }
}

TEST(Patch, CollapsedRowsGiveNoTrianglesWithoutArea) {
    // A cone: the whole first row is its tip, and its normals cancel out.
    Grid grid = makeGrid(5, 3, [](int c, int r) {
        const Vec3 ring[5] = {{64, 0, 0}, {64, 64, 0}, {0, 64, 0}, {-64, 64, 0}, {-64, 0, 0}};
        return r == 0 ? Vec3(0, 0, 100) : r == 1 ? 0.5F * ring[c] + Vec3(0, 0, 50) : ring[c];
    });
    for (int c = 0; c < 5; ++c) grid.at(c, 0).normal = Vec3(0);
    const PatchMesh mesh = grid.mesh();
    EXPECT_GT(mesh.indices.size(), 6U);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        std::set<Key> corners;
        for (std::size_t k = 0; k < 3; ++k) corners.insert(key(mesh.vertices[mesh.indices[i + k]].position));
        EXPECT_EQ(corners.size(), 3U);
    }
    for (const PatchVertex& v : mesh.vertices) EXPECT_NEAR(glm::length(v.normal), 1, 1e-5);
    // A patch that is a single point makes nothing, and does not fail.
    EXPECT_TRUE(makeGrid(3, 3, [](int, int) { return Vec3(1, 2, 3); }).mesh().indices.empty());
}

TEST(Patch, NumbersThatWouldBreakItDoNot) {
    for (const float scale : {1e-30F, 1e-3F, 1e7F, 1e18F}) {
        Grid grid = flatGrid(3, 3, scale);
        grid.at(1, 1).position.z = scale;
        const PatchMesh mesh = grid.mesh();
        EXPECT_FALSE(mesh.vertices.empty());
        EXPECT_LE(mesh.vertices.size(), 40U * 40U);
        for (const PatchVertex& v : mesh.vertices)
            EXPECT_TRUE(std::isfinite(v.position.x + v.position.y + v.position.z + v.normal.z));
    }
    Grid bent = flatGrid(3, 3);
    bent.at(1, 0).position.z = 1000;
    for (const float tolerance : {0.0F, -1.0F, 1e-38F, 1e30F}) EXPECT_FALSE(bent.mesh(tolerance).indices.empty());
    EXPECT_LE(tessellate(bent.controls, 3, 3, 1e-6F, 4).vertices.size(), 25U);
}

TEST(Patch, AStraightSegmentThatTurnsBackIsCut) {
    // The middle control point lies beyond the end: the curve overshoots and comes back.
    Grid grid = makeGrid(3, 3, [](int c, int r) {
        return Vec3(std::array{0.0F, 200.0F, 100.0F}[static_cast<std::size_t>(c)], 64.0F * static_cast<float>(r), 0);
    });
    const PatchMesh mesh = grid.mesh();
    float farthest = 0;
    for (const PatchVertex& v : mesh.vertices) farthest = std::max(farthest, v.position.x);
    EXPECT_GT(farthest, 130); // the true maximum is 133.3
}

TEST(Patch, TheMeshIsAClosedSheetInsideItsBorder) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> offset(-90, 90);
    for (int round = 0; round < 40; ++round) {
        const int w = 3 + 2 * static_cast<int>(random() % 3);
        const int h = 3 + 2 * static_cast<int>(random() % 3);
        Grid grid = flatGrid(w, h);
        for (PatchVertex& v : grid.controls)
            if (random() % 2 == 0) v.position += Vec3(offset(random) / 4, offset(random) / 4, offset(random));
        // Every inner edge is shared by two triangles, so the border is one loop round the sheet.
        const auto border = borderOf(grid.mesh());
        std::map<Key, Key> next;
        for (const auto& [from, to] : border) EXPECT_TRUE(next.emplace(from, to).second);
        std::size_t steps = 0;
        Key at = border.front().first;
        do {
            at = next.at(at);
            ++steps;
        } while (at != border.front().first && steps <= border.size());
        EXPECT_EQ(steps, border.size());
    }
}

// Two patches that share one edge's control points, in any of the ways an editor may store them, meet bit by bit.
TEST(Patch, NeighboursMeetInBitEqualEdges) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> coordinate(-300, 300);
    const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
    for (int round = 0; round < 150; ++round) {
        const int length = 3 + 2 * static_cast<int>(random() % 3);
        std::vector<Vec3> shared;
        shared.reserve(static_cast<std::size_t>(length));
        for (int i = 0; i < length; ++i) shared.push_back(point());
        if (random() % 4 == 0) shared[1] = 0.5F * (shared[0] + shared[2]); // a straight segment
        if (random() % 8 == 0) shared.back() = shared.front();             // a closed edge
        const auto patchWithEdge = [&](bool reversed, int side, int depth) {
            const bool rows = side < 2; // the edge is a row, else a column
            const int w = rows ? length : depth;
            const int h = rows ? depth : length;
            Grid grid = makeGrid(w, h, [&](int, int) { return point(); });
            for (int i = 0; i < length; ++i) {
                const Vec3& p = shared[static_cast<std::size_t>(reversed ? length - 1 - i : i)];
                const int far = side % 2 == 0 ? 0 : depth - 1;
                (rows ? grid.at(i, far) : grid.at(far, i)).position = p;
            }
            return grid;
        };
        std::vector<std::set<Key>> edges;
        for (int patch = 0; patch < 2; ++patch) {
            const int side = static_cast<int>(random() % 4);
            const Grid grid = patchWithEdge(random() % 2 == 0, side, 3 + 2 * static_cast<int>(random() % 2));
            const PatchMesh mesh = grid.mesh();
            // The border vertices that the shared curve makes: nearer to it than rounding.
            std::set<Key> border;
            for (const auto& [from, to] : borderOf(mesh)) border.insert(from);
            std::set<Key> onEdge;
            for (const Key& k : border) {
                const Vec3 p(std::get<0>(k), std::get<1>(k), std::get<2>(k));
                for (std::size_t s = 0; s + 2 < shared.size(); s += 2)
                    for (int n = 1; n <= 32; ++n)
                        for (int i = 0; i <= n; ++i)
                            if (glm::length(curve(shared[s], shared[s + 1], shared[s + 2],
                                                  static_cast<float>(i) / static_cast<float>(n)) -
                                            p) < 1e-3F)
                                onEdge.insert(k);
            }
            edges.push_back(std::move(onEdge));
        }
        EXPECT_EQ(edges[0], edges[1]) << "round " << round;
        const std::set<Key> ends = {key(shared.front()), key(shared.back())};
        EXPECT_GE(edges[0].size(), ends.size());
    }
}
