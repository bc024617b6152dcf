#pragma once
// Scenes and rays for the tests of pie/intersect, and how two intersectors are compared.

#include "pie/intersect/intersector.h"
#include "pie/scene/scene.h"

#include <cstddef>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace pie::test {

inline constexpr intersect::Kind allKinds[] = {intersect::Kind::BruteForce, intersect::Kind::Bsp,
                                               intersect::Kind::Embree};

[[nodiscard]] scene::Material material(scene::Interaction interaction);
/// All triangles of one material; without materials, Opaque.
[[nodiscard]] scene::Scene sceneOf(const std::vector<Vec3>& corners, const std::vector<std::uint32_t>& materials = {},
                                   const std::vector<scene::Material>& kinds = {});
/// Corners of the inside of a box, twelve triangles.
[[nodiscard]] std::vector<Vec3> boxCorners(const Vec3& lower, const Vec3& upper);
/// A closed room with pillars and boxes in it, none of whose faces overlap, and the planes a level compiler would put
/// through it.
struct Furnished {
    scene::Scene scene;
    level::Tree tree;
};
[[nodiscard]] Furnished furnishedRoom();

[[nodiscard]] Vec3 randomDirection(std::mt19937& random);
/// From points in the scene's bounds, in all directions.
[[nodiscard]] std::vector<intersect::Ray> randomRays(const scene::Scene& scene, std::size_t count, unsigned seed);
/// Packets of neighbours: a common origin, directions a few degrees apart.
[[nodiscard]] std::vector<intersect::Ray> coherentRays(const scene::Scene& scene, std::size_t count, unsigned seed);

[[nodiscard]] std::vector<intersect::Hit> closest(const intersect::Intersector& intersector,
                                                  std::span<const intersect::Ray> rays);
[[nodiscard]] std::vector<std::uint8_t> occluded(const intersect::Intersector& intersector,
                                                 std::span<const intersect::Ray> rays);

struct Agreement {
    std::size_t rays = 0, same = 0;
    std::size_t ties = 0;  ///< another triangle at the same distance (1e-4 relative): a shared edge, or an overlap
    std::size_t edges = 0; ///< different distances, and one of the hits is on the edge of its triangle
    std::size_t wrong = 0;
    [[nodiscard]] std::string text() const;
};
[[nodiscard]] Agreement compare(std::span<const intersect::Hit> a, std::span<const intersect::Hit> b);

} // namespace pie::test
