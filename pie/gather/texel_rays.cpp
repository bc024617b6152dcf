#include "pie/gather/texel_rays.h"

#include "pie/gather/numbers.h"
#include "pie/sampling/directions.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pie::gather {
namespace {

using intersect::Hit;
using intersect::Ray;

std::uint64_t mixed(std::uint64_t x) {
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31U);
}

/// Of position and normal, so that the number of the receiver does not matter.
std::uint64_t seedOf(const scene::Receiver& receiver, std::uint64_t seed) {
    std::uint64_t x = seed + 0x9e3779b97f4a7c15ULL;
    for (const Vec3& v : {receiver.position, receiver.normal})
        for (const float f : {v.x, v.y, v.z})
            x = mixed(x ^ std::bit_cast<std::uint32_t>(f + 0.0F)) + 0x9e3779b97f4a7c15ULL;
    return x;
}

float unit(std::uint64_t bits) { return static_cast<float>(bits >> 40U) * 0x1p-24F; }

/// Every other bit of x.
std::uint32_t compact(std::uint32_t x) {
    x &= 0x55555555U;
    x = (x | x >> 1U) & 0x33333333U;
    x = (x | x >> 2U) & 0x0f0f0f0fU;
    x = (x | x >> 4U) & 0x00ff00ffU;
    return (x | x >> 8U) & 0x0000ffffU;
}

} // namespace

TexelRays::TexelRays(const scene::Scene& scene, const intersect::Intersector& intersector, const SurfaceTexels& texels,
                     const scene::Receivers& receivers, float offset, std::uint64_t seed)
    : scene_(scene), intersector_(intersector), texels_(texels), receivers_(receivers), offset_(offset), seed_(seed),
      filters_(scene.has(scene::Interaction::Filter)) {}

std::size_t TexelRays::count(std::uint32_t receiver, unsigned n) const {
    return receivers_.points[receiver].twoSided ? 2 * std::size_t{n} : n;
}

void TexelRays::shoot(std::span<const std::uint32_t> which, unsigned n, std::vector<TexelHit>& hits) const {
    const unsigned strata = std::max(1U, n / 2);
    // Strata on Morton's curve: consecutive rays stay close, which is what packets want.
    const auto bits = static_cast<unsigned>(std::bit_width(strata) - 1);
    const auto columns = static_cast<float>(1U << ((bits + 1) / 2));
    const auto rows = static_cast<float>(1U << (bits / 2));
    std::vector<Ray> rays;
    for (const std::uint32_t number : which) {
        const scene::Receiver& receiver = receivers_.points[number];
        const std::uint64_t seed = seedOf(receiver, seed_);
        for (const float side : {1.0F, -1.0F}) {
            if (side < 0.0F && !receiver.twoSided) break;
            const Frame frame(side * receiver.normal);
            for (unsigned i = 0; i < 2 * strata; ++i) {
                const std::uint64_t random =
                    mixed(seed + (2 * std::uint64_t{i} + (side < 0.0F ? 1 : 0)) * 0x9e3779b97f4a7c15ULL);
                const unsigned stratum = i / 2;
                const Vec2 u((static_cast<float>(compact(stratum)) + unit(random)) / columns,
                             (static_cast<float>(compact(stratum >> 1U)) + unit(random << 24U)) / rows);
                Ray ray;
                ray.origin = receiver.inset + offset_ * frame.normal;
                ray.direction = frame.toWorld(sampling::cosineHemisphere(glm::min(u, Vec2(0x1.fffffep-1F))));
                rays.push_back(ray);
            }
        }
    }
    const std::size_t first = hits.size();
    hits.resize(first + rays.size());
    trace(rays, std::span(hits).subspan(first));
}

void TexelRays::trace(std::vector<Ray>& rays, std::span<TexelHit> hits) const {
    std::vector<Hit> found(rays.size());
    std::vector<std::uint32_t> number(rays.size());
    for (std::uint32_t i = 0; i < rays.size(); ++i) number[i] = i;
    for (int crossing = 0; crossing < mostCrossings && !rays.empty(); ++crossing) {
        found.resize(rays.size());
        intersector_.closest(rays, found);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Hit& hit = found[i];
            if (!hit.found()) continue;
            const scene::Material& material = scene_.material(hit.triangle);
            if (material.interaction == scene::Interaction::Sky) continue;
            if (filters_ && material.interaction == scene::Interaction::Filter) {
                // By roulette, as the photons do: what passes goes on, what does not meets the surface.
                const std::uint64_t random =
                    mixed(std::bit_cast<std::uint32_t>(hit.t) * 0x9e3779b97f4a7c15ULL + hit.triangle);
                if (unit(random) < meanChannel(scene_.transmittance(hit.triangle, hit.u, hit.v))) {
                    rays[kept] = rays[i];
                    rays[kept].tMin = std::nextafter(hit.t * (1 + 1e-5F), std::numeric_limits<float>::max());
                    number[kept++] = number[i];
                    continue;
                }
            }
            const bool back = glm::dot(scene_.normals[hit.triangle], rays[i].direction) > 0.0F;
            if (back && !material.twoSided) continue;
            TexelHit& out = hits[number[i]];
            out.point = rays[i].origin + hit.t * rays[i].direction;
            out.distance = hit.t;
            out.texel = texels_.find(hit.triangle, back, out.point);
        }
        rays.resize(kept);
        if (!filters_) break;
    }
}

} // namespace pie::gather
