#pragma once
// The makers behind makeIntersector, one per kind. Not for use outside pie/intersect.

#include "pie/intersect/intersector.h"

namespace pie::intersect {

[[nodiscard]] std::unique_ptr<Intersector> makeBruteForce(const scene::Scene& scene);
[[nodiscard]] std::unique_ptr<Intersector> makeBspTree(const scene::Scene& scene, const level::Tree& tree);
/// `streams`: nearest hits by WideTree, where the processor can. Without, Embree alone.
[[nodiscard]] std::unique_ptr<Intersector> makeEmbree(const scene::Scene& scene, bool streams = true);

[[nodiscard]] inline bool isOpaque(const scene::Scene& scene, std::size_t triangle) {
    return scene.material(triangle).interaction == scene::Interaction::Opaque;
}

} // namespace pie::intersect
