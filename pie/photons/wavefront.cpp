#include "pie/photons/wavefront.h"
#include "pie/sampling/directions.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <utility>

namespace pie::photons {
namespace {

using intersect::Hit;
using intersect::Ray;

constexpr unsigned dimensionsPerBounce = 3;
constexpr std::size_t prefetchDistance = 8; // hits
constexpr std::size_t keptRays = 1U << 20U; // memory a thread keeps between chunks
constexpr std::uint32_t maxCrossings = 256; // then a filter surface counts as opaque: every path ends
constexpr float farthestOrigin = 1e15F;     // a light beyond it, or nowhere, lights nothing: t² must stay finite
constexpr float smallestCosine = 1.0F / 64; // bounds the step back at grazing hits

void book(double (&sum)[3], const Rgb& flux) {
    sum[0] += static_cast<double>(flux.x);
    sum[1] += static_cast<double>(flux.y);
    sum[2] += static_cast<double>(flux.z);
}
/// What a photon had less what it goes on with.
void bookLoss(double (&sum)[3], const Rgb& before, const Rgb& after) {
    sum[0] += static_cast<double>(before.x) - static_cast<double>(after.x);
    sum[1] += static_cast<double>(before.y) - static_cast<double>(after.y);
    sum[2] += static_cast<double>(before.z) - static_cast<double>(after.z);
}

/// False as well where a coordinate is not a number.
bool withinReach(const Vec3& p) {
    return std::abs(p.x) < farthestOrigin && std::abs(p.y) < farthestOrigin && std::abs(p.z) < farthestOrigin;
}

} // namespace

Surroundings::Surroundings(const scene::Scene& scene) : reach(lights::largestCoordinate(scene.bounds, Vec3(0.0F))) {
    faces.reserve(scene.triangles.size());
    for (std::size_t i = 0; i < scene.triangles.size(); ++i)
        faces.push_back({scene.normals[i], scene.triangles[i].material});
    matter.reserve(scene.materials.size());
    for (const scene::Material& m : scene.materials)
        matter.push_back({glm::clamp(m.reflectance, 0.0F, 1.0F), m.interaction, m.twoSided});
}

/// What a step reads and what it leaves for the next. One per thread, so that its memory is asked for once.
struct Wavefront::Step {
    WavefrontResult* result = nullptr;
    std::uint64_t first = 0;
    std::vector<lights::Emission> emissions;
    std::vector<Path> paths, nextPaths;
    std::vector<Ray> rays, nextRays;
    std::vector<Hit> hits;
    /// Reflections that have no direction yet: ray of `nextRays`, normal there, and the numbers of the direction.
    std::vector<std::uint32_t> turning;
    std::vector<Vec3> normals;
    std::vector<float> x, y, z;
};

void WavefrontResult::writeTo(Photon* out, std::uint32_t firstId) {
    places.assign(indices + 1, 0);
    for (const std::uint32_t i : owner) ++places[i + 1];
    for (std::size_t i = 0; i < indices; ++i) places[i + 1] += places[i];
    for (std::size_t i = 0; i < photons.size(); ++i) {
        const std::uint32_t to = places[owner[i]]++;
        out[to] = photons[i];
        out[to].id = firstId + to;
    }
}

std::uint32_t splitChildren(const TracerOptions& options) {
    return std::clamp(options.diffuseReflections, 1U, maxPathsPerPhoton);
}

Wavefront::Wavefront(const scene::Scene& scene, const lights::LightSet& lights,
                     const intersect::Intersector& intersector, const TracerOptions& options,
                     const sampling::Sequence& emission, const sampling::Sequence& reflection,
                     const Surroundings& surroundings, std::uint64_t total)
    : scene_(scene), lights_(lights), intersector_(intersector), options_(options), emission_(emission),
      reflection_(reflection), surroundings_(surroundings),
      perPhoton_(static_cast<float>(1.0 / static_cast<double>(std::max<std::uint64_t>(1, total)))) {
    if (options.scattering != TracerOptions::Scattering::Splitting) return;
    const std::uint32_t wanted = splitChildren(options);
    std::uint32_t paths = 1;
    while (wanted > 1 && splits_ < options.recursionDepth && paths * wanted <= maxPathsPerPhoton)
        branches_[splits_++] = {wanted, paths *= wanted};
}

void Wavefront::run(std::uint64_t first, std::size_t count, WavefrontResult& result) const {
    static thread_local Step kept;
    Step step = std::move(kept); // taken out, in case an intersector starts another chunk on this thread meanwhile
    step.result = &result;
    step.first = first;
    result.indices = count;
    result.counts = {};
    result.photons.clear();
    result.owner.clear();
    result.photons.reserve(count);
    result.owner.reserve(count);
    emit(step, first, count);
    std::visit([&](const auto& numbers) { advance(step, numbers); }, reflection_);
    result.counts.stored = result.photons.size();
    if (step.rays.capacity() <= keptRays) kept = std::move(step);
}

template <class Numbers> void Wavefront::advance(Step& step, const Numbers& numbers) const {
    while (!step.rays.empty()) {
        step.hits.resize(step.rays.size());
        intersector_.closest(step.rays, step.hits);
        step.result->counts.rays += step.rays.size();
        step.nextPaths.clear();
        step.nextRays.clear();
        for (std::size_t i = 0; i < step.rays.size(); ++i) {
            const std::size_t soon = std::min(i + prefetchDistance, step.rays.size() - 1);
            if (step.hits[soon].found()) __builtin_prefetch(&surroundings_.faces[step.hits[soon].triangle]);
            meet(step, step.paths[i], step.rays[i], step.hits[i], numbers);
        }
        turn(step);
        step.paths.swap(step.nextPaths);
        step.rays.swap(step.nextRays);
    }
}

void Wavefront::emit(Step& step, std::uint64_t first, std::size_t count) const {
    TraceCounts& counts = step.result->counts;
    step.paths.clear();
    step.rays.clear();
    step.emissions.resize(count);
    lights_.emit(emission_, first, step.emissions);
    for (std::size_t i = 0; i < count; ++i) {
        const lights::Emission& emission = step.emissions[i];
        Path path;
        path.flux = emission.flux * perPhoton_;
        path.owner = static_cast<std::uint32_t>(i);
        book(counts.emittedFlux, path.flux);
        if (path.flux == Rgb(0.0F)) { // of a muted light
            ++counts.absorbed;
            continue;
        }
        if (!withinReach(emission.origin)) {
            ++counts.escaped;
            book(counts.escapedFlux, path.flux);
            continue;
        }
        // What stands in free space may by chance lie on a surface: hits within rounding of it do not count.
        const float tMin = emission.falloff != nullptr ? offsetAt(emission.origin) : 0.0F;
        step.rays.push_back({emission.origin, tMin, emission.direction});
        step.paths.push_back(path);
    }
    counts.emitted = count;
}

float Wavefront::offsetAt(const Vec3& origin) const {
    return lights::surfaceOffset(std::max(surroundings_.reach, maxChannel(glm::abs(origin))));
}

template <class Numbers>
void Wavefront::meet(Step& step, Path& path, const Ray& ray, const Hit& hit, const Numbers& numbers) const {
    TraceCounts& counts = step.result->counts;
    static constexpr Surroundings::Face nothing{};
    static constexpr Surroundings::Matter open{Rgb(0.0F), scene::Interaction::Sky, false};
    const Surroundings::Face& face = hit.found() ? surroundings_.faces[hit.triangle] : nothing;
    const Surroundings::Matter& matter = hit.found() ? surroundings_.matter[face.material] : open;
    if (matter.interaction == scene::Interaction::Sky) {
        ++counts.escaped;
        book(counts.escapedFlux, path.flux);
        return;
    }
    // A plane cannot meet a ray that left it: rounding.
    if (hit.triangle == path.from && path.crossings < maxCrossings) return goOn(step, path, ray, hit.t, 1e-4F);
    if (matter.interaction == scene::Interaction::Filter && path.crossings < maxCrossings && passes(step, path, hit)) {
        ++counts.filtered;
        // From just behind it: a wall may stand there. Rounding that brings the filter back is the case above.
        path.from = hit.triangle;
        return goOn(step, path, ray, hit.t, 1e-6F);
    }

    float cosine = -glm::dot(face.normal, ray.direction);
    if (path.bounce == 0) {
        const Rgb before = path.flux;
        path.flux *= lights::arrivalFactor(step.emissions[path.owner], hit.t, std::abs(cosine));
        bookLoss(counts.absorbedFlux, before, path.flux);
    }
    const bool turned = cosine < 0.0F && matter.twoSided;
    const Vec3 normal = turned ? -face.normal : face.normal;
    cosine = turned ? -cosine : cosine;
    if (!(cosine > 0.0F)) {
        ++counts.absorbed;
        ++counts.backHits;
        book(counts.absorbedFlux, path.flux);
        return;
    }
    if (path.bounce > 0 || options_.storeDirectLight) {
        Photon& photon = step.result->photons.emplace_back();
        photon.position = ray.origin + hit.t * ray.direction;
        photon.direction = ray.direction;
        photon.flux = path.flux;
        photon.triangle = hit.triangle;
        photon.bounce = static_cast<std::uint8_t>(std::min(path.bounce, 255U));
        step.result->owner.push_back(path.owner);
    }
    path.from = hit.triangle;
    const float back = std::min(hit.t, offsetAt(ray.origin) / std::max(cosine, smallestCosine)); // fig 5.4
    reflect(step, path, normal, ray.origin + (hit.t - back) * ray.direction, matter.reflectance, numbers);
}

bool Wavefront::passes(Step& step, Path& path, const Hit& hit) const {
    const Rgb share = glm::clamp(scene_.transmittance(hit.triangle, hit.u, hit.v), 0.0F, 1.0F);
    const Rgb through = path.flux * share;
    const float whole = meanChannel(glm::abs(path.flux));
    const float chance = whole > 0.0F ? std::min(1.0F, meanChannel(glm::abs(through)) / whole) : 0.0F;
    const std::uint64_t where =
        (std::uint64_t{path.branch} << 40U) ^ (std::uint64_t{path.bounce} << 16U) ^ path.crossings;
    const bool passed = sampling::hash01((step.first + path.owner) ^ (options_.seed << 32U), where) < chance;
    const Rgb before = path.flux;
    if (passed)
        path.flux = through / chance;
    else if (chance > 0.0F)
        path.flux = (path.flux - through) / (1.0F - chance);
    bookLoss(step.result->counts.absorbedFlux, before, path.flux);
    return passed;
}

void Wavefront::goOn(Step& step, Path path, const Ray& ray, float t, float share) const {
    ++path.crossings;
    Ray next = ray;
    next.tMin = std::nextafter(t + share * t, std::numeric_limits<float>::infinity());
    step.nextRays.push_back(next);
    step.nextPaths.push_back(path);
}

template <class Numbers>
void Wavefront::reflect(Step& step, const Path& path, const Vec3& normal, const Vec3& origin, const Rgb& reflectance,
                        const Numbers& numbers) const {
    TraceCounts& counts = step.result->counts;
    const Rgb reflected = path.flux * reflectance;
    const float largest = maxChannel(glm::abs(reflected));
    if (!(largest > 0.0F)) {
        ++counts.absorbed;
        book(counts.absorbedFlux, path.flux);
        return;
    }
    if (path.bounce >= options_.recursionDepth) {
        ++counts.cut;
        book(counts.cutFlux, reflected);
        bookLoss(counts.absorbedFlux, path.flux, reflected);
        return;
    }
    const unsigned dimension = lights::LightSet::dimensions + dimensionsPerBounce * path.bounce;
    const std::uint64_t index = step.first + path.owner;
    Path next = path;
    next.crossings = 0;
    ++next.bounce;

    if (options_.scattering == TracerOptions::Scattering::Splitting) {
        const std::uint32_t children = path.bounce < splits_ ? branches_[path.bounce].children : 1;
        const auto directions = sampling::fan(numbers, index, dimension, path.branch, children);
        const Frame surface(normal);
        next.flux = reflected / static_cast<float>(children);
        for (std::uint32_t j = 0; j < children; ++j) {
            next.branch = path.branch * children + j;
            send(step, next, surface, origin, directions(j));
        }
        for (int c = 0; c < 3; ++c)
            counts.absorbedFlux[c] += static_cast<double>(path.flux[c]) - static_cast<double>(next.flux[c]) * children;
        return;
    }
    next.flux = reflected;
    if (path.bounce > 0 || options_.storeDirectLight) {
        const float chance = largest / maxChannel(glm::abs(path.flux));
        if (numbers(index, dimension + 2) >= chance) {
            ++counts.absorbed;
            book(counts.absorbedFlux, path.flux);
            return;
        }
        next.flux = reflected / chance;
    }
    bookLoss(counts.absorbedFlux, path.flux, next.flux);
    if constexpr (Numbers::polar || std::same_as<Numbers, sampling::Rejection>) {
        send(step, next, Frame(normal), origin, sampling::cosine(numbers, index, dimension));
    } else {
        const Vec2 u = numbers.pair(index, dimension);
        step.turning.push_back(static_cast<std::uint32_t>(step.nextRays.size()));
        step.normals.push_back(normal);
        step.x.push_back(u.x);
        step.y.push_back(u.y);
        step.nextRays.push_back({origin, 0.0F, Vec3(0.0F)});
        step.nextPaths.push_back(next);
    }
}

void Wavefront::turn(Step& step) {
    step.z.resize(step.x.size());
    sampling::cosineHemispheres(step.x, step.y, step.z);
    for (std::size_t i = 0; i < step.turning.size(); ++i)
        step.nextRays[step.turning[i]].direction = Frame(step.normals[i]).toWorld({step.x[i], step.y[i], step.z[i]});
    step.turning.clear();
    step.normals.clear();
    step.x.clear();
    step.y.clear();
}

void Wavefront::send(Step& step, const Path& path, const Frame& surface, const Vec3& origin, const Vec3& direction) {
    step.nextRays.push_back({origin, 0.0F, surface.toWorld(direction)});
    step.nextPaths.push_back(path);
}

} // namespace pie::photons
