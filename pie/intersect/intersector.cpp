#include "pie/intersect/intersector.h"

#include "pie/intersect/intersectors.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pie::intersect {
namespace {

constexpr std::size_t blockSize = 256;
/// Filter surfaces that a ray may cross. What comes after so many layers is dark for any picture that filters at all.
constexpr int mostLayers = 64;

/// Rays of one block that still travel, and whose they are.
struct Travellers {
    std::array<Ray, blockSize> rays;
    std::array<Hit, blockSize> hits;
    std::array<std::size_t, blockSize> owner{};
    std::array<std::uint32_t, blockSize> last{}; ///< triangle crossed last
    std::size_t count = 0;

    void add(const Ray& ray, std::size_t whose, std::uint32_t crossed) {
        rays[count] = ray;
        owner[count] = whose;
        last[count] = crossed;
        ++count;
    }
};

/// Just beyond a crossing, so that it is not met again: rounding of t grows with t and with the distance of the
/// triangle from the origin of space, so a triangle that comes back is stepped over more widely.
float beyond(float t, bool again) {
    const float relative = again ? 1e-4F : 1e-6F;
    return std::nextafter(t + t * relative, std::numeric_limits<float>::infinity());
}

/// Crosses one Filter or Sky triangle with every traveller; those with light and way left travel on.
void crossOnce(const Intersector& intersector, const scene::Scene& scene, Travellers& travellers,
               std::span<Rgb> through) {
    intersector.closest(std::span(travellers.rays).first(travellers.count),
                        std::span(travellers.hits).first(travellers.count));
    const std::size_t count = travellers.count;
    travellers.count = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Hit hit = travellers.hits[i];
        if (!hit.found()) continue;
        const std::size_t whose = travellers.owner[i];
        const bool again = hit.triangle == travellers.last[i];
        if (!again) through[whose] *= scene.transmittance(hit.triangle, hit.u, hit.v);
        Ray ray = travellers.rays[i];
        ray.tMin = beyond(hit.t, again);
        if (maxChannel(through[whose]) > 0.0F && ray.tMin < ray.tMax) travellers.add(ray, whose, hit.triangle);
    }
}

void transmitBlock(const Intersector& intersector, const scene::Scene& scene, bool filters, std::span<const Ray> rays,
                   std::span<Rgb> through) {
    std::array<std::uint8_t, blockSize> blocked{};
    intersector.occluded(rays, std::span(blocked).first(rays.size()));
    for (std::size_t i = 0; i < rays.size(); ++i) through[i] = Rgb(blocked[i] != 0 ? 0.0F : 1.0F);
    if (!filters) return;
    Travellers travellers;
    for (std::size_t i = 0; i < rays.size(); ++i)
        if (blocked[i] == 0) travellers.add(rays[i], i, noTriangle);
    for (int layer = 0; layer < mostLayers && travellers.count > 0; ++layer)
        crossOnce(intersector, scene, travellers, through);
    for (std::size_t i = 0; i < travellers.count; ++i) through[travellers.owner[i]] = Rgb(0.0F);
}

} // namespace

std::unique_ptr<Intersector> makeIntersector(Kind kind, const scene::Scene& scene, const level::Tree& tree) {
    switch (kind) {
    case Kind::BruteForce: return makeBruteForce(scene);
    case Kind::Bsp: return makeBspTree(scene, tree);
    case Kind::Embree: return makeEmbree(scene);
    }
    return makeEmbree(scene);
}

void transmittance(const Intersector& intersector, const scene::Scene& scene, std::span<const Ray> rays,
                   std::span<Rgb> through) {
    const bool filters = scene.has(scene::Interaction::Filter);
    for (std::size_t begin = 0; begin < rays.size(); begin += blockSize) {
        const std::size_t count = std::min(blockSize, rays.size() - begin);
        transmitBlock(intersector, scene, filters, rays.subspan(begin, count), through.subspan(begin, count));
    }
}

} // namespace pie::intersect
