// Shadow rays against accuracy of direct light in shipped levels, for values of direct_samples and direct_tolerance.
// About 400 vertices of the drawn mesh, spread over the level; the reference tests every light with all its samples.
//
//   direct_bench [level …]       prints CSV: per level and setting, rays per receiver, processor time, and mean
//                                absolute error in U
//
// With --refine: how far light interpolated between vertices is from light at the point itself, by the longest edge of
// the mesh. The same light on both sides, 64 samples a lamp, so that what differs is the mesh. The points are spread
// over the drawn surfaces in proportion to area.
//
//   direct_bench --refine [level …]       prints CSV: per level and max_edge, receivers, milliseconds of processor time
//                                         for mesh and receivers, mean and 95th percentile of the error in U
//
// With --refine-by-light: the same where edges are split by light (refine_by = light, max_edge = 64), by refine_error,
// beside meshes split by length.
//
//   direct_bench --refine-by-light [level …]     prints CSV: as --refine, and which of the two
//
// With --noise: how honest the standard errors that come with direct light are, where there is more than 1 U.
//
//   direct_bench --noise [level …]        prints CSV: per level and setting, root mean square of the error and of the
//                                         standard error in U, and the share of errors within one standard error

#include "pie/core/parallel.h"
#include "pie/engine/refine_by_light.h"
#include "pie/gather/direct.h"
#include "pie/lights/import.h"
#include "pie/scene/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace {

using pie::Rgb;
using pie::Vec3;
using pie::gather::DirectLight;
using pie::gather::DirectOptions;
using pie::scene::Mesh;
using pie::scene::Receiver;
using pie::scene::Receivers;

struct Lit {
    pie::level::Level level;
    std::shared_ptr<const pie::scene::Scene> scene;
    std::unique_ptr<pie::intersect::Intersector> intersector;
    pie::lights::LightSet lights;

    explicit Lit(const std::string& name) : level(load(name)) {
        scene = std::make_shared<const pie::scene::Scene>(pie::scene::makeScene(level));
        intersector = makeIntersector(pie::intersect::Kind::Embree, *scene, level.tree);
        lights = pie::lights::LightSet(pie::lights::importLights(level, *scene).lights, scene);
    }
    static pie::level::Level load(const std::string& name) {
        auto location = pie::level::locate(name, "/usr/share/games/openarena/baseoa");
        if (!location) fail(location.error());
        auto level = pie::level::loadLevel(*std::move(location));
        if (!level) fail(level.error());
        return *std::move(level);
    }
    [[noreturn]] static void fail(const pie::Error& error) {
        fmt::print(stderr, "direct_bench: {}\n", error.message());
        std::exit(1);
    }
    /// Light at all of them; `rays`, when given, receives how many shadow rays it took.
    [[nodiscard]] std::vector<Rgb> light(const Receivers& receivers, const DirectOptions& options,
                                         std::uint64_t* rays = nullptr, std::vector<float>* variance = nullptr) const {
        std::vector<std::uint32_t> which(receivers.points.size());
        std::iota(which.begin(), which.end(), 0U);
        std::vector<Rgb> irradiance(which.size());
        const DirectLight direct(*scene, lights, *intersector, receivers, options);
        std::vector<float> variances(which.size());
        direct.estimate(which, irradiance, variances);
        if (variance != nullptr) *variance = variances;
        if (rays != nullptr) *rays = direct.raysTraced();
        return irradiance;
    }
    /// The drawn mesh as the engine makes it.
    [[nodiscard]] Mesh mesh(float maxEdge) const {
        Mesh mesh = pie::scene::makeMesh(level);
        pie::scene::RefineOptions options;
        options.maxEdge = maxEdge;
        pie::scene::refine(mesh, options);
        return mesh;
    }
};

double milliseconds(std::clock_t since) {
    return 1e3 * static_cast<double>(std::clock() - since) / double{CLOCKS_PER_SEC};
}

/// Mean channel, in U.
double brightness(const Rgb& light) { return double{pie::meanChannel(light)}; }

/// Receivers of the drawn mesh, about `count`, spread over the level.
Receivers someReceivers(const Lit& lit, std::size_t count) {
    const Receivers all = makeReceivers(lit.mesh(64), lit.level);
    Receivers some;
    const std::size_t step = std::max<std::size_t>(1, all.points.size() / count);
    for (std::size_t i = step / 2; i < all.points.size(); i += step) some.points.push_back(all.points[i]);
    return some;
}

void errorAgainstNoise(const std::string& name) {
    const Lit lit(name);
    const Receivers some = someReceivers(lit, 400);
    DirectOptions exhaustive;
    exhaustive.exhaustive = true;
    exhaustive.seed = 1;
    exhaustive.softness = 4;
    const std::vector<Rgb> truth = lit.light(some, exhaustive);
    for (const unsigned samples : {4U, 16U, 64U})
        for (const float tolerance : {0.25F, 2.0F, 8.0F}) {
            DirectOptions options;
            options.softSamples = samples;
            options.absoluteTolerance = tolerance;
            std::vector<float> variance;
            const std::vector<Rgb> light = lit.light(some, options, nullptr, &variance);
            double error = 0;
            double said = 0;
            double within = 0;
            double count = 0;
            double exact = 0;
            for (std::size_t i = 0; i < light.size(); ++i) {
                if (brightness(truth[i]) < 1) continue;
                const double off = std::abs(brightness(light[i]) - brightness(truth[i]));
                ++count;
                error += off * off;
                said += double{variance[i]};
                if (off < 1e-4 * brightness(truth[i])) ++exact;
                if (off <= std::sqrt(double{variance[i]}) + 1e-4 * brightness(truth[i])) ++within;
            }
            fmt::print("{},{},{},{:.0f},{:.4f},{:.4f},{:.3f},{:.3f}\n", name, samples, tolerance, count,
                       std::sqrt(error / count), std::sqrt(said / count), within / count, exact / count);
        }
}

void raysAgainstError(const std::string& name) {
    pie::setThreads(1);
    const Lit lit(name);
    const Receivers some = someReceivers(lit, 400);
    const auto count = static_cast<double>(some.points.size());

    DirectOptions exhaustive;
    exhaustive.exhaustive = true;
    exhaustive.seed = 1;
    std::uint64_t rays = 0;
    const std::vector<Rgb> truth = lit.light(some, exhaustive, &rays);
    double mean = 0;
    for (const Rgb& light : truth) mean += brightness(light) / count;
    const auto line = [&](unsigned samples, float tolerance) {
        DirectOptions options;
        options.softSamples = samples;
        options.absoluteTolerance = tolerance;
        std::uint64_t fewer = 0;
        std::vector<Rgb> light;
        double time = std::numeric_limits<double>::max(); // the fastest of three
        for (int round = 0; round < 3; ++round) {
            const std::clock_t start = std::clock();
            light = lit.light(some, options, &fewer);
            time = std::min(time, milliseconds(start));
        }
        double error = 0;
        for (std::size_t i = 0; i < light.size(); ++i)
            error += std::abs(brightness(light[i]) - brightness(truth[i])) / count;
        fmt::print("{},{},{},{},{:.1f},{:.1f},{:.1f},{:.3f},{:.4f}\n", name, lit.lights.lights().size(), samples,
                   tolerance, static_cast<double>(fewer) / count, static_cast<double>(rays) / count, time, mean, error);
    };
    for (const unsigned samples : {1U, 2U, 4U, 8U, 16U, 32U, 64U, 128U, 256U}) line(samples, 0.25F);
    for (const unsigned samples : {8U, 64U})
        for (const float tolerance : {0.01F, 0.05F, 0.1F, 0.5F, 1.0F, 2.0F, 4.0F, 8.0F}) line(samples, tolerance);
}

/// Points of the mesh in proportion to area, each with the vertices of its triangle and its place among them.
struct Probe {
    std::array<std::uint32_t, 3> corners{};
    std::array<float, 3> weights{};
};

std::vector<Probe> spread(const Mesh& mesh, const Receivers& receivers, std::size_t count) {
    std::vector<double> areas; // 0 for what is not lit
    for (const pie::scene::MeshTriangle& triangle : mesh.triangles) {
        const auto corner = [&](std::size_t i) { return mesh.vertices[triangle.vertices.at(i)].position; };
        const bool lit = std::none_of(triangle.vertices.begin(), triangle.vertices.end(),
                                      [&](std::uint32_t v) { return receivers.ofVertex[v] == pie::scene::noReceiver; });
        areas.push_back(lit ? double{glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)))} : 0.0);
    }
    std::mt19937 random(1);
    std::discrete_distribution<std::size_t> choose(areas.begin(), areas.end());
    std::uniform_real_distribution<float> unit;
    std::vector<Probe> probes(count);
    for (Probe& probe : probes) {
        probe.corners = mesh.triangles[choose(random)].vertices;
        const float root = std::sqrt(unit(random));
        const float across = unit(random);
        probe.weights = {1 - root, root * (1 - across), root * across};
    }
    return probes;
}

/// Prints the rest of a line.
template <class MakeMesh> void errorOf(const Lit& lit, const MakeMesh& makeMesh) {
    const std::clock_t start = std::clock();
    const Mesh mesh = makeMesh();
    const Receivers receivers = makeReceivers(mesh, lit.level);
    const double time = milliseconds(start);
    const std::vector<Probe> probes = spread(mesh, receivers, 4000);
    Receivers asked; // per probe its corners, then the point itself
    for (const Probe& probe : probes) {
        Receiver point;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t vertex = probe.corners.at(i);
            asked.points.push_back(receivers.points[receivers.ofVertex[vertex]]);
            point.position += probe.weights.at(i) * mesh.vertices[vertex].position;
            point.normal += probe.weights.at(i) * asked.points.back().normal;
            point.twoSided = asked.points.back().twoSided;
        }
        point.normal = glm::normalize(point.normal);
        point.inset = point.position;
        asked.points.push_back(point);
    }
    const std::vector<Rgb> light = lit.light(asked, {});
    std::vector<double> errors;
    for (std::size_t p = 0; p < probes.size(); ++p) {
        double drawn = 0;
        for (std::size_t i = 0; i < 3; ++i) drawn += double{probes[p].weights.at(i)} * brightness(light[4 * p + i]);
        errors.push_back(std::abs(drawn - brightness(light[4 * p + 3])));
    }
    std::sort(errors.begin(), errors.end());
    const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
    fmt::print("{},{:.1f},{:.4f},{:.4f}\n", receivers.points.size(), time, mean, errors[errors.size() * 95 / 100]);
}

void edgeAgainstError(const std::string& name) {
    pie::setThreads(1);
    const Lit lit(name);
    for (const float maxEdge : {256.0F, 181.0F, 128.0F, 91.0F, 64.0F, 45.0F, 32.0F, 23.0F, 16.0F}) {
        fmt::print("{},{},", name, maxEdge);
        errorOf(lit, [&] { return lit.mesh(maxEdge); });
    }
}

void lightAgainstLength(const std::string& name) {
    pie::setThreads(1);
    const Lit lit(name);
    for (const float maxEdge : {128.0F, 64.0F, 32.0F}) {
        fmt::print("{},length,{},", name, maxEdge);
        errorOf(lit, [&] { return lit.mesh(maxEdge); });
    }
    for (const float error : {32.0F, 8.0F, 2.0F}) {
        fmt::print("{},light,{},", name, error);
        errorOf(lit, [&] {
            pie::engine::Settings settings;
            settings.refineError = error;
            Mesh mesh = pie::scene::makeMesh(lit.level);
            pie::engine::refineByLight(mesh, lit.level, *lit.scene, lit.lights, *lit.intersector,
                                       pie::engine::adaptOptions(settings));
            return mesh;
        });
    }
}

} // namespace

int main(int argumentCount, char** arguments) {
    std::vector<std::string> levels(arguments + 1, arguments + argumentCount);
    const std::string mode = levels.empty() || levels.front().rfind("--", 0) != 0 ? "" : levels.front();
    if (!mode.empty()) levels.erase(levels.begin());
    if (levels.empty()) levels = {"kaos2"};
    fmt::print("{}\n", mode == "--refine"            ? "level,max_edge,receivers,milliseconds,error,error95"
                       : mode == "--refine-by-light" ? "level,by,limit,receivers,milliseconds,error,error95"
                       : mode == "--noise"
                           ? "level,samples,tolerance,receivers,error,standard_error,within_one,exact"
                           : "level,lights,samples,tolerance,rays,rays_exhaustive,milliseconds,mean,error");
    for (const std::string& level : levels)
        if (mode == "--refine")
            edgeAgainstError(level);
        else if (mode == "--refine-by-light")
            lightAgainstLength(level);
        else if (mode == "--noise")
            errorAgainstNoise(level);
        else
            raysAgainstError(level);
    return 0;
}
