#pragma once
// Levels and meshes made by hand for the tests of pie/scene, and an independent judge of T-junctions.

#include "pie/level/level.h"
#include "pie/scene/mesh.h"

#include <cstddef>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace pie::test {

/// A picture of one colour.
[[nodiscard]] std::shared_ptr<level::Image> picture(int width, int height, const Rgba8& colour);

/// Builds levels surface by surface.
class LevelMaker {
public:
    level::Level level;

    LevelMaker();
    /// A shader with a lightmap stage and, when an image is given, a picture of the shader's name. Returns its number.
    std::uint32_t shader(const std::string& name, std::shared_ptr<const level::Image> image = nullptr);
    /// A surface of counter-clockwise corners, fanned from the first. Returns its number.
    std::uint32_t polygon(std::uint32_t shader, const std::vector<Vec3>& corners, std::uint32_t model = 0);
    /// The inside of an axis-aligned box, six polygons.
    void room(std::uint32_t shader, const Vec3& lower, const Vec3& upper);
};

/// One triangle soup as a mesh of surface 0, three vertices per triangle, flat normals.
[[nodiscard]] scene::Mesh soup(const std::vector<Vec3>& corners);
/// A square floor cut into rectangles at random again and again, two triangles each: T-junctions everywhere.
/// `snapped`: cuts on whole units.
[[nodiscard]] scene::Mesh cutFloor(std::mt19937& random, int cuts, float size, bool snapped = true);

/// Pairs (edge, vertex) with the vertex in the interior of the edge: nearer than `tolerance` and than a hundredth of
/// the edge, and that far from both ends; not counted are vertices farther off than a quarter of the width of a sliver
/// on the edge (its neighbours), and those that would turn a triangle over. Every edge against every vertex.
[[nodiscard]] std::size_t countTJunctions(const scene::Mesh& mesh, double tolerance = 0.01);
/// The same, for large meshes: vertices sorted along one axis.
[[nodiscard]] std::size_t countTJunctionsSorted(const scene::Mesh& mesh, double tolerance = 0.01);

[[nodiscard]] double areaOf(const scene::Mesh& mesh);
[[nodiscard]] double longestEdgeOf(const scene::Mesh& mesh);
/// Welded edges that do not have exactly two triangles.
[[nodiscard]] std::size_t openEdges(const scene::Mesh& mesh);

} // namespace pie::test
