#include "pie/gather/texel_rays.h"

#include "pie/gather/numbers.h"
#include "pie/sampling/directions.h"
#include "pie/sampling/hash.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

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
                     const BrightTexels& bright, const scene::Receivers& receivers, float offset, std::uint64_t seed)
    : scene_(scene), intersector_(intersector), texels_(texels), bright_(bright), receivers_(receivers),
      offset_(offset), seed_(seed), filters_(scene.has(scene::Interaction::Filter)) {}

std::size_t TexelRays::count(std::uint32_t receiver, unsigned n) const {
    return (receivers_.points[receiver].twoSided ? 2 * std::size_t{n} : n) + aimed(n);
}

void TexelRays::addHemisphere(const scene::Receiver& receiver, unsigned n, std::vector<Ray>& rays) const {
    const unsigned strata = std::max(1U, n / 2);
    // Strata on Morton's curve: consecutive rays stay close, which is what packets want.
    const auto bits = static_cast<unsigned>(std::bit_width(strata) - 1);
    const auto columns = static_cast<float>(1U << ((bits + 1) / 2));
    const auto rows = static_cast<float>(1U << (bits / 2));
    const std::uint64_t seed = seedOf(receiver, seed_);
    for (const float side : {1.0F, -1.0F}) {
        if (side < 0.0F && !receiver.twoSided) break;
        const Frame frame(side * receiver.normal);
        for (unsigned i = 0; i < 2 * strata; ++i) {
            const std::uint64_t random =
                mixed(seed + (2 * std::uint64_t{i} + (side < 0.0F ? 1 : 0)) * 0x9e3779b97f4a7c15ULL);
            const unsigned stratum = i / 2;
            const Vec2 u((static_cast<float>(compact(stratum)) + sampling::toUnit(random)) / columns,
                         (static_cast<float>(compact(stratum >> 1U)) + sampling::toUnit(random << 24U)) / rows);
            Ray ray;
            ray.origin = receiver.inset + offset_ * frame.normal;
            ray.direction = frame.toWorld(sampling::cosineHemisphere(glm::min(u, Vec2(sampling::belowOne))));
            rays.push_back(ray);
        }
    }
}

float TexelRays::addAimed(const scene::Receiver& receiver, unsigned count, std::vector<float>& sums,
                          std::vector<Ray>& rays, std::vector<Target>& targets) const {
    const float all = bright_.chances(receiver, sums);
    const std::uint64_t seed = mixed(seedOf(receiver, seed_) ^ 0x616b6d656421ULL);
    const unsigned strata = count / 2;
    for (unsigned i = 0; i < count; ++i) {
        Ray& ray = rays.emplace_back();
        ray.origin = receiver.inset + offset_ * receiver.normal;
        ray.direction = receiver.normal;
        ray.tMax = 0.0F; // until it has a target
        Target& target = targets.emplace_back();
        if (!(all > 0.0F)) continue;
        const std::uint64_t random = mixed(seed + i * 0x9e3779b97f4a7c15ULL);
        const unsigned stratum = i / 2;
        const float wanted =
            (static_cast<float>(stratum) + sampling::toUnit(random)) / static_cast<float>(strata) * all;
        const auto found = std::upper_bound(sums.begin(), sums.end(), wanted);
        const auto number = std::min<std::size_t>(static_cast<std::size_t>(found - sums.begin()), sums.size() - 1);
        const std::uint32_t texel = bright_.texel(number);
        const unsigned points = texels_.pointsPerTexel();
        const auto which =
            std::min(points - 1, static_cast<unsigned>(sampling::toUnit(random << 24U) * static_cast<float>(points)));
        const Vec3 point = texels_.points().points[std::size_t{texel} * points + which].position;
        const float side = glm::dot(receiver.normal, point - receiver.inset) < 0.0F ? -1.0F : 1.0F;
        if (side < 0.0F && !receiver.twoSided) continue;
        ray.origin = receiver.inset + side * offset_ * receiver.normal;
        const Vec3 to = point - ray.origin;
        const float distance = glm::length(to);
        // A texel in the receiver's own plane lies below where rays start: no ray of the hemisphere gets there.
        if (!(distance > 0.0F && side * glm::dot(receiver.normal, to) > 0.0F)) continue;
        ray.direction = to / distance;
        ray.tMax = std::numeric_limits<float>::infinity();
        target = {texel, point};
    }
    return all;
}

/// Hemisphere rays come first. A place x of a bright texel is met by n rays of density g and by m of density p, both
/// per area of the texel: each counts g / (n g + m p), which for the others is 1/n.
void TexelRays::weigh(const scene::Receiver& receiver, unsigned n, float chances, std::span<TexelHit> hits,
                      std::span<const Target> targets) const {
    const auto rays = static_cast<float>(n);
    const auto m = static_cast<float>(targets.size());
    const std::size_t first = hits.size() - targets.size();
    for (std::size_t i = 0; i < hits.size(); ++i) {
        TexelHit& hit = hits[i];
        if (hit.texel == SurfaceTexels::none) continue;
        hit.weight = 1 / rays;
        if (i >= first) {
            // Something else of the texel may be met before the place that was aimed at.
            const Target& target = targets[i - first];
            const Vec3 off = hit.point - target.point;
            const float size = 1e-3F * texels_.edge() + offset_;
            if (hit.texel != target.texel || glm::dot(off, off) > size * size) {
                hit.texel = SurfaceTexels::none;
                continue;
            }
        }
        const float chance = m > 0.0F && chances > 0.0F ? bright_.chance(receiver, hit.texel) : 0.0F;
        if (!(chance > 0.0F)) continue;
        const float here = std::abs(glm::dot(receiver.normal, hit.direction));
        const float g = here * hit.cosine / (std::numbers::pi_v<float> * hit.distance * hit.distance);
        const float p = chance / (chances * texels_.texels()[hit.texel].area);
        hit.weight = g / (rays * g + m * p);
        if (!(hit.weight >= 0.0F)) hit.weight = 0.0F;
    }
}

void TexelRays::shoot(std::span<const std::uint32_t> which, unsigned n, std::vector<TexelHit>& hits) const {
    const unsigned m = aimed(n);
    std::vector<Ray> rays;
    std::vector<Target> targets;
    std::vector<float> chances;
    std::vector<float> sums;
    for (const std::uint32_t number : which) {
        addHemisphere(receivers_.points[number], n, rays);
        chances.push_back(m > 0 ? addAimed(receivers_.points[number], m, sums, rays, targets) : 0.0F);
    }
    const std::size_t first = hits.size();
    hits.resize(first + rays.size());
    trace(rays, std::span(hits).subspan(first));
    std::size_t at = first;
    for (std::size_t i = 0; i < which.size(); ++i) {
        const std::size_t size = count(which[i], n);
        weigh(receivers_.points[which[i]], n, chances[i], std::span(hits).subspan(at, size),
              std::span(targets).subspan(i * m, m));
        at += size;
    }
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
                if (sampling::toUnit(random) < meanChannel(scene_.transmittance(hit.triangle, hit.u, hit.v))) {
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
            out.direction = rays[i].direction;
            out.cosine = std::abs(glm::dot(scene_.normals[hit.triangle], rays[i].direction));
            out.texel = texels_.find(hit.triangle, back, out.point);
        }
        rays.resize(kept);
        if (!filters_) break;
    }
}

} // namespace pie::gather
