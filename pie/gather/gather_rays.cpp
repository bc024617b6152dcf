#include "pie/gather/gather_rays.h"

#include "pie/gather/numbers.h"
#include "pie/sampling/directions.h"

#include <bit>
#include <cmath>
#include <utility>

namespace pie::gather {
namespace {

using intersect::Hit;
using intersect::Ray;

/// As shadow rays: a unit in a level of usual size; at 10⁷ units the next float is a unit away.
float offsetFor(const scene::Scene& scene) {
    if (scene.bounds.empty()) return 1.0F;
    const Vec3 farthest = glm::max(glm::abs(scene.bounds.lower), glm::abs(scene.bounds.upper));
    return std::max(std::min(1.0F, glm::length(scene.bounds.size()) / 4096.0F), 1e-6F * maxChannel(farthest));
}

/// Of position and normal, so that a receiver's rays do not depend on its number.
std::uint64_t keyOf(const scene::Receiver& receiver, std::uint64_t seed) {
    std::uint64_t key = seed ^ 0x9e3779b97f4a7c15U;
    for (const float x : {receiver.position.x, receiver.position.y, receiver.position.z, receiver.normal.x,
                          receiver.normal.y, receiver.normal.z}) {
        key ^= std::bit_cast<std::uint32_t>(x);
        key *= 0xff51afd7ed558ccdU;
        key ^= key >> 29U;
    }
    return key;
}

/// Relative change of what a hit at offset `to` gives, per unit that the receiver moves along its surface: the surface
/// that was met stays, its solid angle and its cosine change (after Annen, Kautz, Durand and Seidel 2004). What hides
/// and what is hidden is taken to stay as well. At grazing hits, where this grows without bound, it is bounded.
Vec3 growthOf(const Vec3& to, const Vec3& receiverNormal, const Vec3& hitNormal) {
    constexpr float leastCosine = 0.1F;
    const float square = glm::dot(to, to);
    if (!(square > 0.0F)) return Vec3(0.0F);
    const float facing = std::max(-glm::dot(hitNormal, to), leastCosine * std::sqrt(square));
    const Vec3 growth = 4.0F / square * to + hitNormal / facing;
    return growth - glm::dot(growth, receiverNormal) * receiverNormal;
}

float wrap(float x) { return std::min(x - std::floor(x), 0x1.fffffep-1F); }

} // namespace

/// Rays under way together.
struct GatherRays::Batch {
    struct Path {
        std::uint32_t bundle;
        std::uint8_t group;
        Rgb factor;        ///< of the light that leaves what is met
        Vec3 growth{0.0F}; ///< of a second gather's, from its first hit
        std::uint64_t key;
    };
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<Path> paths;

    void clear() {
        rays.clear();
        paths.clear();
    }
};

GatherRays::GatherRays(const scene::Scene& scene, const intersect::Intersector& intersector,
                       const FinalGatherOptions& options, Direct direct)
    : scene_(scene), intersector_(intersector), options_(options), direct_(std::move(direct)), halton_(options.seed),
      offset_(offsetFor(scene)) {}

Vec3 GatherRays::litNormal(std::uint32_t triangle, bool back) const {
    return back ? -scene_.normals[triangle] : scene_.normals[triangle];
}

scene::Receiver GatherRays::pointOf(const Bundle::Term& term) const {
    return {term.position, litNormal(term.triangle, term.back), term.position, false};
}

void GatherRays::addHemisphere(Batch& batch, std::uint32_t bundle, const Vec3& origin, const Vec3& normal,
                               std::uint64_t key, unsigned count, const Rgb& factor, const Vec3& growth,
                               int group) const {
    const Frame frame(normal);
    const Vec2 shift(sampling::hash01(key, 1), sampling::hash01(key, 2));
    for (unsigned i = 0; i < count; ++i) {
        const Vec2 u(wrap(halton_(i, 0) + shift.x), wrap(halton_(i, 1) + shift.y));
        batch.rays.push_back({origin, 0.0F, frame.toWorld(sampling::cosineHemisphere(u))});
        const auto own = static_cast<std::uint8_t>(group < 0 ? i % Bundle::groups : static_cast<unsigned>(group));
        batch.paths.push_back({bundle, own, factor / static_cast<float>(count), growth, key + i});
    }
}

/// First hits that are not filters passed through: each ray meets the filter or, by a draw, what is behind it.
void GatherRays::trace(Batch& batch) const {
    batch.hits.assign(batch.rays.size(), {});
    intersector_.closest(batch.rays, batch.hits);
    rays_ += batch.rays.size();
    if (!scene_.has(scene::Interaction::Filter)) return;
    std::vector<std::size_t> passing;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    for (int crossing = 0; crossing < mostCrossings; ++crossing) {
        passing.clear();
        rays.clear();
        for (std::size_t i = 0; i < batch.rays.size(); ++i) {
            const Hit& hit = batch.hits[i];
            if (!hit.found() || scene_.material(hit.triangle).interaction != scene::Interaction::Filter ||
                !(hit.t >= batch.rays[i].tMin))
                continue;
            const Rgb share = glm::clamp(scene_.transmittance(hit.triangle, hit.u, hit.v), 0.0F, 1.0F);
            const float chance = meanChannel(share);
            const bool passes =
                sampling::hash01(batch.paths[i].key, 16 + static_cast<std::uint64_t>(crossing)) < chance;
            batch.paths[i].factor *= passes ? share / chance : (1.0F - share) / (1.0F - chance);
            batch.rays[i].tMin = std::nextafter(hit.t * (1 + 1e-6F), std::numeric_limits<float>::infinity());
            if (!passes) continue; // stays: its hit lies in front of the new tMin, so it is not asked again
            passing.push_back(i);
            rays.push_back(batch.rays[i]);
        }
        if (passing.empty()) return;
        hits.assign(rays.size(), {});
        intersector_.closest(rays, hits);
        rays_ += rays.size();
        for (std::size_t i = 0; i < passing.size(); ++i) batch.hits[passing[i]] = hits[i];
    }
}

void GatherRays::shoot(std::span<const scene::Receiver> receivers, std::span<Bundle> bundles) const {
    Batch batch;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        bundles[i] = {};
        const scene::Receiver& at = receivers[i];
        for (const float side : {1.0F, -1.0F}) {
            if (side < 0.0F && !at.twoSided) continue;
            const std::uint64_t key = keyOf(at, options_.seed) ^ (side < 0.0F ? 0x5bd1e995U : 0U);
            addHemisphere(batch, static_cast<std::uint32_t>(i), at.inset + side * offset_ * at.normal, side * at.normal,
                          key, options_.samples, Rgb(1.0F), Vec3(0.0F), -1);
            bundles[i].rays += options_.samples;
        }
    }
    trace(batch);

    Batch second;
    scene::Receivers near;
    std::vector<Batch::Path> nearPaths;
    const auto meet = [&](const Batch& from, std::size_t i, bool first) {
        const Hit& hit = from.hits[i];
        const Batch::Path& path = from.paths[i];
        const Ray& ray = from.rays[i];
        if (!hit.found()) return;
        Bundle& bundle = bundles[path.bundle];
        if (first) bundle.inverseDistances += 1 / std::max(1e-6, static_cast<double>(hit.t));
        const scene::Material& material = scene_.material(hit.triangle);
        if (material.interaction == scene::Interaction::Sky) return;
        const float cosine = -glm::dot(scene_.normals[hit.triangle], ray.direction);
        const bool back = cosine < 0.0F;
        if (cosine == 0.0F || (back && !material.twoSided)) return;
        const Rgb factor = path.factor * material.reflectance;
        if (!(maxChannel(factor) > 0.0F)) return;
        const Vec3 position = ray.origin + hit.t * ray.direction;
        const Vec3 normal = litNormal(hit.triangle, back);
        const Vec3 growth =
            first ? growthOf(hit.t * ray.direction, receivers[path.bundle].normal, normal) : path.growth;
        if (!first || !(hit.t < options_.secondaryDistance) || options_.secondarySamples == 0) {
            bundle.terms.push_back({position, hit.triangle, factor, growth, back, path.group});
            return;
        }
        const float lift = std::min(offset_, 0.5F * hit.t * std::abs(cosine));
        near.points.push_back({position, normal, position, false});
        nearPaths.push_back({path.bundle, path.group, factor, growth, path.key});
        addHemisphere(second, path.bundle, position + lift * normal, normal, path.key * 0x9e3779b97f4a7c15U,
                      options_.secondarySamples, factor, growth, path.group);
    };
    for (std::size_t i = 0; i < batch.rays.size(); ++i) meet(batch, i, true);
    if (near.points.empty()) return;
    std::vector<Rgb> direct(near.points.size());
    direct_(near, direct);
    for (std::size_t i = 0; i < near.points.size(); ++i) {
        const Rgb light = nearPaths[i].factor * direct[i];
        Bundle& bundle = bundles[nearPaths[i].bundle];
        bundle.base[nearPaths[i].group] += light;
        for (int axis = 0; axis < 3; ++axis)
            bundle.baseGradient[static_cast<std::size_t>(axis)] += light * nearPaths[i].growth[axis];
    }
    trace(second);
    for (std::size_t i = 0; i < second.rays.size(); ++i) meet(second, i, false);
}

} // namespace pie::gather
