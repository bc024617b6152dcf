#pragma once
// First hit and occlusion against a Scene. Three of a kind with the same answers: brute force (the judge), the level's
// own BSP tree (the paper's), Embree (the fast one). Batched: one virtual call for many rays. Safe to call from several
// threads at once.

#include "pie/core/vec.h"
#include "pie/level/level.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string_view>

namespace pie::intersect {

struct Ray {
    Vec3 origin{0.0F};
    float tMin = 0.0F;
    Vec3 direction{0.0F}; ///< unit length
    float tMax = std::numeric_limits<float>::infinity();
};

inline constexpr std::uint32_t noTriangle = 0xffffffffU;

struct Hit {
    std::uint32_t triangle = noTriangle; ///< Scene::triangles
    float t = std::numeric_limits<float>::infinity();
    float u = 0, v = 0; ///< barycentric weights of corners 1 and 2
    [[nodiscard]] bool found() const { return triangle != noTriangle; }
};

class Intersector {
public:
    virtual ~Intersector() = default;
    /// Nearest hit with tMin <= t < tMax, of any triangle, from either side; of several at the same distance the
    /// triangle with the lowest number (on a shared edge, either one). Rays with a non-finite or zero direction hit
    /// nothing; a negative tMin counts as 0. The answer to a ray does not depend on the others of the batch, but the
    /// time does: Embree's kind takes rays in streams, and a thousand or more at once cost half of what single ones do.
    virtual void closest(std::span<const Ray> rays, std::span<Hit> hits) const = 0;
    /// blocked[i] = 1 when any Opaque triangle lies on the ray. Filter and Sky triangles do not block here.
    virtual void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const = 0;
    [[nodiscard]] virtual std::string_view name() const = 0;
    [[nodiscard]] virtual std::size_t bytes() const = 0; ///< memory held
};

enum class Kind : std::uint8_t { BruteForce, Bsp, Embree };
/// The intersector keeps a reference to `scene`; `tree` is used by Bsp only (an empty tree: one is built by halving).
[[nodiscard]] std::unique_ptr<Intersector> makeIntersector(Kind kind, const scene::Scene& scene,
                                                           const level::Tree& tree);

/// Light that gets through along each ray: 0 behind Opaque triangles, the product of `Scene::transmittance` over Filter
/// triangles crossed, 1 on a free way. Sky triangles end nothing. Costs one occlusion ray where the scene has no Filter
/// triangle.
void transmittance(const Intersector& intersector, const scene::Scene& scene, std::span<const Ray> rays,
                   std::span<Rgb> through);

} // namespace pie::intersect
