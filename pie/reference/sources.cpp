#include "pie/reference/sources.h"

#include "pie/core/parallel.h"
#include "pie/reference/visibility.h"
#include "pie/sampling/directions.h"
#include "pie/sampling/halton.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <variant>

namespace pie::reference {
namespace {

using lights::AreaLight;
using lights::SkyLight;

/// Share of draws that go by Sources::chances(): bounds what a source that was thought dark can weigh.
constexpr double blindShare = 0.1;
/// Sources below this share of a choice are left to those draws.
constexpr double smallestShare = 1e-4;
/// Regions along the longest side of the scene.
constexpr float regions = 20;
/// Sample points per region and side, and sides of a normal.
constexpr std::size_t samplesPerBin = 4;
constexpr std::size_t sides = 6;
/// Weight of a source that no sample point saw, against one that all saw.
constexpr double unseen = 0.1;
constexpr double belowOne = 1.0 - 1e-12;

double meanAbsolute(const Rgb& c) { return double{meanChannel(glm::abs(c))}; }

std::vector<double> sums(std::span<const double> weights) {
    std::vector<double> result(weights.size());
    std::partial_sum(weights.begin(), weights.end(), result.begin());
    const double total = result.empty() ? 0.0 : result.back();
    for (double& r : result) r = total > 0 ? r / total : 1.0;
    if (!result.empty()) result.back() = 1.0;
    return result;
}

std::size_t find(std::span<const double> cumulative, double u) {
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end(), std::min(u, belowOne));
    return std::min(static_cast<std::size_t>(found - cumulative.begin()), cumulative.size() - 1);
}

std::size_t sideOf(const Vec3& normal) {
    const Vec3 size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return 2 * static_cast<std::size_t>(axis) + (normal[axis] < 0.0F ? 1 : 0);
}

} // namespace

Sources::Sources(std::span<const lights::Light> lights, const scene::Scene& scene)
    : lights_(lights.begin(), lights.end()) {
    const lights::SkyPortals portals = lights::skyPortals(scene);
    std::vector<double> weights;
    for (const lights::Light& light : lights_) {
        const double watts = meanAbsolute(lights::power(light, scene, portals));
        // What has no power lights nothing; what is not finite lights nothing either, see LightSet.
        if (!(watts > 0.0) || !std::isfinite(watts)) continue;
        Source source;
        source.light = &light;
        source.sharp = lights::sampleCount(light) == 1;
        if (const auto* area = std::get_if<AreaLight>(&light)) {
            Box box;
            for (const Vec3& corner : area->corners) box.extend(corner);
            source.centre = box.centre();
            source.extent = 0.5F * glm::length(box.size());
        }
        const auto* sky = std::get_if<SkyLight>(&light);
        const std::size_t directions = sky != nullptr ? sky->towards.size() : 1;
        for (std::size_t d = 0; d < directions; ++d) {
            const auto count = static_cast<float>(directions);
            if (sky != nullptr) {
                source.sky = {(static_cast<float>(d) + 0.5F) / count, 1.0F / count};
                source.sharp = true;
            }
            sources_.push_back(source);
            weights.push_back(watts / static_cast<double>(directions));
        }
    }
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    const auto count = static_cast<double>(weights.size());
    for (const double weight : weights) chances_.push_back(0.9 * weight / total + 0.1 / count);
}

lights::Illumination Sources::sample(std::size_t source, const Point& point, const Vec2& u) const {
    const Source& s = sources_[source];
    if (s.sky.x < 0.0F) return lights::illuminate(*s.light, point.position, point.normal, false, u);
    auto way = lights::illuminate(*s.light, point.position, point.normal, false, {s.sky.x, 0.5F});
    way.irradiance *= s.sky.y;
    return way;
}

double Sources::guess(std::size_t source, const Point& point) const {
    const Source& s = sources_[source];
    const auto* area = std::get_if<AreaLight>(s.light);
    if (area == nullptr) {
        const double exact = meanAbsolute(sample(source, point, Vec2(0.5F)).irradiance);
        if (s.sharp) return exact;
        // The middle of a soft source may be dark where its rim is not.
        const Vec3 towards = sample(source, point, Vec2(0.25F)).towards;
        return std::max(exact, meanAbsolute(sample(source, {point.position, towards}, Vec2(0.25F)).irradiance) * 0.1);
    }
    const Vec3 to = s.centre - point.position;
    const float squared = std::max(glm::dot(to, to), 0.25F * s.extent * s.extent);
    const float distance = std::sqrt(squared);
    const float height = glm::dot(to, point.normal) + s.extent;
    float before = -glm::dot(to, area->normal);
    before = area->twoSided ? std::abs(before) : before;
    if (!(height > 0.0F) || !(before > 0.0F)) return 0.0;
    const double share = area->area / (std::numbers::pi * double{squared}) * std::min(1.0, double{height / distance}) *
                         std::min(1.0, double{(before + 0.1F * s.extent) / distance});
    return meanAbsolute(area->radiosity) * std::min(1.0, share);
}

Vec3 Sources::end(std::size_t source, const Point& point, const lights::Illumination& way, float offset) const {
    const Vec3 at = point.position + way.distance * way.towards;
    const auto* area = std::get_if<AreaLight>(sources_[source].light);
    if (area == nullptr) return at - std::min(offset, 0.5F * way.distance) * way.towards;
    return at + (glm::dot(area->normal, way.towards) > 0.0F ? -offset : offset) * area->normal;
}

Choice::Choice(std::span<const double> weights) {
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    if (!(total > 0.0) || !std::isfinite(total)) return;
    std::vector<double> kept;
    for (std::uint32_t i = 0; i < weights.size(); ++i)
        if (weights[i] > smallestShare * total) {
            numbers_.push_back(i);
            kept.push_back(weights[i]);
        }
    cumulative_ = sums(kept);
}

Choice::Drawn Choice::draw(std::span<const double> cumulativeOfAll, double u) const {
    const double blind = numbers_.empty() ? 1.0 : blindShare;
    Drawn drawn;
    const auto share = [&](std::size_t k) { return cumulative_[k] - (k > 0 ? cumulative_[k - 1] : 0.0); };
    double named = 0;
    if (u < blind) {
        drawn.source = static_cast<std::uint32_t>(find(cumulativeOfAll, u / blind));
        const auto found = std::lower_bound(numbers_.begin(), numbers_.end(), drawn.source);
        if (found != numbers_.end() && *found == drawn.source)
            named = share(static_cast<std::size_t>(found - numbers_.begin()));
    } else {
        const std::size_t k = find(cumulative_, (u - blind) / (1.0 - blind));
        drawn.source = numbers_[k];
        named = share(k);
    }
    drawn.chance =
        blind * (cumulativeOfAll[drawn.source] - (drawn.source > 0 ? cumulativeOfAll[drawn.source - 1] : 0.0)) +
        (1.0 - blind) * named;
    return drawn;
}

ChoiceMap::ChoiceMap(const scene::Scene& scene, const Sources& sources, const intersect::Intersector& intersector,
                     std::uint64_t seed)
    : cumulative_(sums(sources.chances())) {
    if (sources.size() < 2 || scene.bounds.empty()) {
        choiceOf_.assign(sides, 0);
        choices_.resize(1);
        return;
    }
    lower_ = scene.bounds.lower;
    const Vec3 size = scene.bounds.size();
    cell_ = std::max(maxChannel(size) / regions, std::numeric_limits<float>::min());
    cells_ = glm::ivec3(glm::clamp(glm::floor(size / cell_), 0.0F, regions)) + 1;
    const auto bins = static_cast<std::size_t>(cells_.x) * static_cast<std::size_t>(cells_.y) *
                      static_cast<std::size_t>(cells_.z) * sides;

    // Points on surfaces, in proportion to area, a few for every bin that has any.
    std::vector<double> areas;
    for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
        const bool reflects = scene.material(t).interaction != scene::Interaction::Sky;
        const Vec3 across =
            glm::cross(scene.corner(t, 1) - scene.corner(t, 0), scene.corner(t, 2) - scene.corner(t, 0));
        areas.push_back(reflects && scene.normals[t] != Vec3(0.0F) ? double{glm::length(across)} : 0.0);
    }
    const std::vector<double> cumulative = sums(areas);
    std::vector<std::vector<Point>> points(bins);
    const sampling::Halton halton(seed);
    for (std::uint64_t i = 0; i < 16 * bins && !cumulative.empty(); ++i) {
        const std::size_t t = find(cumulative, double{halton(i, 0)});
        const Vec2 w = sampling::uniformTriangle({halton(i, 1), halton(i, 2)});
        const Vec3 a = scene.corner(t, 0);
        const bool turned = scene.material(t).twoSided && (i & 1U) != 0;
        Point point{a + w.x * (scene.corner(t, 1) - a) + w.y * (scene.corner(t, 2) - a),
                    turned ? -scene.normals[t] : scene.normals[t]};
        std::vector<Point>& bin = points[binOf(point)];
        point.position += offsetAt(scene, point.position) * point.normal;
        if (bin.size() < samplesPerBin) bin.push_back(point);
    }

    choiceOf_.assign(bins, 0);
    choices_.resize(1);
    for (std::size_t b = 0; b < bins; ++b)
        if (!points[b].empty()) {
            choiceOf_[b] = static_cast<std::uint32_t>(choices_.size());
            choices_.emplace_back();
        }
    parallelChunks(bins, 16, [&](std::size_t begin, std::size_t end) {
        std::vector<double> weights(sources.size());
        std::vector<double> guesses(sources.size());
        for (std::size_t b = begin; b < end; ++b) {
            if (points[b].empty()) continue;
            std::fill(weights.begin(), weights.end(), 0.0);
            for (const Point& point : points[b]) {
                double total = 0;
                for (std::size_t s = 0; s < sources.size(); ++s) {
                    const double guess = sources.guess(s, point);
                    guesses[s] = std::isfinite(guess) ? guess : 0.0;
                    total += guesses[s];
                }
                ShadowRays shadows;
                std::vector<std::size_t> asked;
                for (std::size_t s = 0; s < sources.size(); ++s) {
                    weights[s] += unseen * guesses[s];
                    if (guesses[s] <= 1e-3 * total) continue;
                    const auto way = sources.sample(
                        s, point, {sampling::hash01(s + (b << 20U), seed), sampling::hash01(seed, s + (b << 20U))});
                    if (!(meanAbsolute(way.irradiance) > 0.0)) continue;
                    intersect::Ray ray{point.position, 0.0F, way.towards};
                    if (!way.needsSky) ray.tMax = way.distance * (1.0F - 1e-3F);
                    if (!way.needsSky && !(ray.tMax < 1e15F)) continue;
                    asked.push_back(s);
                    shadows.rays.push_back(ray);
                    shadows.toSky.push_back(way.needsSky ? 1 : 0);
                }
                trace(intersector, scene, shadows);
                for (std::size_t k = 0; k < asked.size(); ++k)
                    weights[asked[k]] += guesses[asked[k]] * meanAbsolute(shadows.through[k]);
            }
            choices_[choiceOf_[b]] = Choice(weights);
        }
    });
}

std::size_t ChoiceMap::binOf(const Point& point) const {
    const Vec3 place = (point.position - lower_) / cell_;
    const glm::ivec3 cell(glm::clamp(place, Vec3(0.0F), Vec3(cells_) - 1.0F));
    const std::int64_t row = std::int64_t{cell.z} * cells_.y + cell.y;
    return static_cast<std::size_t>(row * cells_.x + cell.x) * sides + sideOf(point.normal);
}

Choice::Drawn ChoiceMap::draw(const Point& point, double u) const {
    if (choices_.size() == 1) return choices_[0].draw(cumulative_, u);
    return choices_[choiceOf_[binOf(point)]].draw(cumulative_, u);
}

} // namespace pie::reference
