#include "pie/reference/batch.h"

#include "pie/sampling/directions.h"

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace pie::reference {
namespace {

using intersect::Hit;
using intersect::Ray;

/// Dimensions: two for the first direction; for light at the receiver and at every reflection three, then for going on
/// three more. Beyond `even` they are plain random numbers: bases are then too large for a batch to fill.
constexpr unsigned even = 32;
constexpr unsigned perBounce = 6;
constexpr std::uint32_t mostCrossings = 256; ///< then a filter counts as opaque, as for photons
constexpr std::uint32_t certainBounces = 64; ///< beyond, every path may end, whatever surfaces reflect
constexpr float smallestCosine = 1.0F / 64;
constexpr unsigned pilotRays = 8; ///< per soft light of a receiver, for choosing among them

struct Path {
    Point at; ///< where it is, and the side it looks to
    glm::dvec3 weight{1.0};
    std::uint32_t index = 0;
    std::uint32_t bounce = 0;
    std::uint32_t crossings = 0;
    std::uint32_t last = intersect::noTriangle; ///< filter crossed last
    std::uint32_t from = intersect::noTriangle; ///< triangle it was reflected by last
};

/// Ray to a sample of a source; false: it gives nothing. What is farther away than squares of floats can say lights
/// nothing, as with photons.
bool rayTo(const Shared& shared, std::size_t source, const Point& point, const lights::Illumination& way, Ray& ray) {
    constexpr float farthest = 1e15F;
    if (way.irradiance == Rgb(0.0F)) return false;
    ray = {point.position, 0.0F, way.towards};
    if (way.needsSky) return true;
    if (!(way.distance < farthest)) return false;
    const Vec3 to = shared.sources->end(source, point, way, offsetAt(*shared.scene, point.position)) - ray.origin;
    ray.tMax = glm::length(to);
    if (!(ray.tMax > 0.0F && ray.tMax < farthest)) return false;
    ray.direction = to / ray.tMax;
    return true;
}

class Batch {
public:
    Batch(const Shared& shared, const Start& start, std::uint64_t number)
        : shared_(shared), start_(start), seed_(mix(start.address, number)) {
        for (unsigned d = 0; d < even; ++d) shifts_[d] = double{sampling::hash01(seed_, d)};
    }

    glm::dvec3 run() {
        std::vector<Path> paths(pathsPerBatch);
        for (std::uint32_t i = 0; i < paths.size(); ++i) {
            paths[i].at = start_.point;
            paths[i].index = i;
        }
        if (start_.anySoft)
            for (const Path& path : paths) askSoft(path);
        if (shared_.options.recursionDepth == 0) paths.clear();
        std::vector<Ray> rays;
        rays.reserve(paths.size());
        for (Path& path : paths) rays.push_back(leave(path));
        while (!paths.empty()) {
            std::vector<Path> nextPaths;
            std::vector<Ray> nextRays;
            std::vector<Hit> hits(rays.size());
            shared_.intersector.closest(rays, hits);
            for (std::size_t i = 0; i < paths.size(); ++i)
                if (meet(paths[i], rays[i], hits[i])) {
                    nextPaths.push_back(paths[i]);
                    nextRays.push_back(rays[i]);
                }
            paths.swap(nextPaths);
            rays.swap(nextRays);
        }
        collect();
        return sum_ / static_cast<double>(pathsPerBatch);
    }

private:
    [[nodiscard]] double random(const Path& path, unsigned dimension) const {
        if (dimension >= even) return double{sampling::hash01(seed_ + path.index, dimension)};
        const double u = double{shared_.halton(path.index, dimension)} + shifts_[dimension];
        return u < 1.0 ? u : u - 1.0;
    }
    [[nodiscard]] Vec2 random2(const Path& path, unsigned dimension) const {
        return glm::min(Vec2(random(path, dimension), random(path, dimension + 1)), Vec2(0x1.fffffep-1F));
    }
    static unsigned dimensionOf(const Path& path) { return 2 + 3 + perBounce * (path.bounce - 1); }

    /// A ray from where the path is into a direction of its hemisphere.
    Ray leave(Path& path) const {
        const unsigned dimension = path.bounce == 0 ? 0 : dimensionOf(path) + 3;
        const Vec3 local = sampling::cosineHemisphere(random2(path, dimension));
        path.crossings = 0;
        path.last = intersect::noTriangle;
        return {path.at.position, 0.0F, Frame(path.at.normal).toWorld(local)};
    }

    /// Whether the path goes on, with `ray` as its next one.
    bool meet(Path& path, Ray& ray, const Hit& hit) {
        if (!hit.found()) return false;
        const scene::Scene& scene = *shared_.scene;
        if (hit.triangle == path.from && path.crossings < mostCrossings) { // a plane cannot meet what left it: rounding
            ray.tMin = behind(hit.t, true);
            ++path.crossings;
            return true;
        }
        const scene::Material& material = scene.material(hit.triangle);
        if (material.interaction == scene::Interaction::Sky) return false;
        if (material.interaction == scene::Interaction::Filter && path.crossings < mostCrossings && passes(path, hit)) {
            ray.tMin = behind(hit.t, hit.triangle == path.last);
            path.last = hit.triangle;
            ++path.crossings;
            return true;
        }
        const Vec3 front = scene.normals[hit.triangle];
        float cosine = -glm::dot(front, ray.direction);
        const bool turned = cosine < 0.0F && material.twoSided;
        cosine = turned ? -cosine : cosine;
        if (!(cosine > 0.0F)) return false;
        path.weight *= glm::dvec3(glm::clamp(material.reflectance, 0.0F, 1.0F));
        ++path.bounce;
        if (!(std::max({path.weight.x, path.weight.y, path.weight.z}) > 0.0)) return false;
        // Back along the way, which is free: in narrow corners the normal leads outside.
        const float back = std::min(hit.t, offsetAt(scene, ray.origin) / std::max(cosine, smallestCosine));
        path.at = {ray.origin + (hit.t - back) * ray.direction, turned ? -front : front};
        path.from = hit.triangle;
        askAny(path);
        return survives(path, ray);
    }

    bool survives(Path& path, Ray& ray) {
        if (path.bounce >= shared_.options.recursionDepth) return false;
        double chance = std::min(1.0, 2.0 * std::max({path.weight.x, path.weight.y, path.weight.z}));
        if (path.bounce >= certainBounces) chance = std::min(chance, 0.95);
        if (random(path, dimensionOf(path) + 5) >= chance) return false;
        path.weight /= chance;
        ray = leave(path);
        return true;
    }

    /// Through a filter, or met by it: the weight becomes that of what happens.
    bool passes(Path& path, const Hit& hit) const {
        if (hit.triangle == path.last) return true; // rounding brought it back
        const glm::dvec3 share(glm::clamp(shared_.scene->transmittance(hit.triangle, hit.u, hit.v), 0.0F, 1.0F));
        const glm::dvec3 through = path.weight * share;
        const double whole = path.weight.x + path.weight.y + path.weight.z;
        const double chance = whole > 0 ? std::min(1.0, (through.x + through.y + through.z) / whole) : 0.0;
        const std::uint64_t where = (std::uint64_t{path.bounce} << 32U) ^ path.crossings;
        const bool passed = double{sampling::hash01(mix(seed_, path.index), where)} < chance;
        path.weight = passed ? through / chance : (path.weight - through) / (1.0 - chance);
        return passed;
    }

    /// Light with extent at the receiver.
    void askSoft(const Path& path) { ask(path, start_.soft.draw(shared_.map->cumulative(), random(path, 2)), 3); }
    /// Any light, at a reflection.
    void askAny(const Path& path) {
        if (shared_.sources->size() == 0) return;
        const unsigned dimension = dimensionOf(path);
        const double u = shared_.sources->size() > 1 ? random(path, dimension) : 0.0;
        ask(path, shared_.map->draw(path.at, u), dimension + 1);
    }
    void ask(const Path& path, const Choice::Drawn& drawn, unsigned dimension) {
        // Sharp lights of a receiver have been taken already.
        if (path.bounce == 0 && shared_.sources->sharp(drawn.source)) return;
        const auto way = shared_.sources->sample(drawn.source, path.at, random2(path, dimension));
        Ray ray;
        if (!rayTo(shared_, drawn.source, path.at, way, ray)) return;
        shadows_.rays.push_back(ray);
        shadows_.toSky.push_back(way.needsSky ? 1 : 0);
        light_.push_back(path.weight * glm::dvec3(way.irradiance) / drawn.chance);
        if (shadows_.rays.size() >= 2048) collect();
    }

    void collect() {
        trace(shared_.intersector, *shared_.scene, shadows_);
        for (std::size_t i = 0; i < light_.size(); ++i) sum_ += light_[i] * glm::dvec3(shadows_.through[i]);
        shadows_.clear();
        light_.clear();
    }

    const Shared& shared_;
    const Start& start_;
    std::uint64_t seed_;
    std::array<double, even> shifts_{};
    ShadowRays shadows_;
    std::vector<glm::dvec3> light_;
    glm::dvec3 sum_{0.0};
};

} // namespace

std::uint64_t mix(std::uint64_t a, std::uint64_t b) {
    std::uint64_t z = (a ^ (b + 0x9e3779b97f4a7c15ULL + (a << 6U) + (a >> 2U))) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 30U)) * 0x94d049bb133111ebULL;
    z = (z ^ (z >> 27U)) * 0xbf58476d1ce4e5b9ULL;
    return z ^ (z >> 31U);
}

Start makeStart(const Shared& shared, const Vec3& position, const Vec3& normal, std::uint64_t address) {
    Start start;
    start.point = {position + shared.lift * normal, normal};
    start.address = address;
    std::vector<double> weights(shared.sources->size(), 0.0);
    ShadowRays shadows;
    std::vector<std::uint32_t> source;
    std::vector<glm::dvec3> light;
    for (std::uint32_t s = 0; s < shared.sources->size(); ++s) {
        const bool sharp = shared.sources->sharp(s);
        const unsigned rays = sharp ? 1 : pilotRays;
        double largest = sharp ? 0.0 : shared.sources->guess(s, start.point);
        for (unsigned k = 0; k < rays; ++k) {
            const Vec2 u(sampling::hash01(mix(address, s), 2ULL * k), sampling::hash01(mix(address, s), 2ULL * k + 1));
            const auto way = shared.sources->sample(s, start.point, sharp ? Vec2(0.5F) : u);
            Ray ray;
            if (!rayTo(shared, s, start.point, way, ray)) continue;
            largest = std::max(largest, double{meanChannel(glm::abs(way.irradiance))});
            shadows.rays.push_back(ray);
            shadows.toSky.push_back(way.needsSky ? 1 : 0);
            source.push_back(s);
            light.push_back(glm::dvec3(way.irradiance) / static_cast<double>(rays));
        }
        if (!sharp && largest > 0.0) {
            weights[s] = 0.1 * largest; // seen by no pilot ray is not dark
            start.anySoft = true;
        }
    }
    trace(shared.intersector, *shared.scene, shadows);
    for (std::size_t i = 0; i < source.size(); ++i) {
        const glm::dvec3 arrived = light[i] * glm::dvec3(shadows.through[i]);
        if (shared.sources->sharp(source[i]))
            start.sharp += arrived;
        else
            weights[source[i]] += std::abs(arrived.x + arrived.y + arrived.z) / 3.0;
    }
    start.soft = Choice(weights);
    return start;
}

glm::dvec3 traceBatch(const Shared& shared, const Start& start, std::uint64_t batch) {
    return Batch(shared, start, batch).run();
}

} // namespace pie::reference
