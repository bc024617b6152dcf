// Error of what photons say in a closed cube with a lamp in its middle, where the answer is known.
//
//   furnace_bench trace       error of indirect light on patches of the walls, by photons, depth and kind of scattering
//   furnace_bench profile     direct light from photons along the middle of a wall: mean and deviation over 32 frames
//   furnace_bench count       error of direct light from photons at vertices, by photons in an estimate
//
// Prints CSV. The lamp is a point, so direct light has a formula. Indirect light has one for its mean only; patch by
// patch its reference is 8 million photons of 60 reflections, averaged over the patches that the cube's symmetry makes
// equal.

#include "pie/gather/nearest_photons.h"
#include "pie/photons/tracer.h"
#include "tests/gather/scenes.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

namespace {

using pie::Rgb;
using pie::Vec3;
using pie::photons::Photon;
using pie::photons::TracerOptions;

constexpr float side = 512;
constexpr float rho = 0.5F;
constexpr float watts = 1e6F;
constexpr std::size_t across = 8; ///< patches along a wall
constexpr std::size_t patchCount = 6 * across * across;

struct Cube {
    std::shared_ptr<const pie::scene::Scene> scene;
    std::unique_ptr<pie::intersect::Intersector> intersector;
    pie::lights::LightSet lights;

    Cube() {
        pie::gather::test::SceneBuilder builder;
        builder.grey(rho);
        builder.room(Vec3(0.0F), Vec3(side));
        scene = builder.make();
        intersector = pie::intersect::makeIntersector(pie::intersect::Kind::Embree, *scene, {});
        pie::lights::PointLight lamp;
        lamp.position = Vec3(0.5F * side);
        lamp.power = Rgb(watts);
        lamp.falloff.minDistance = 0;
        lights = pie::lights::LightSet({lamp}, scene);
    }
    pie::photons::TraceCounts trace(const TracerOptions& options, std::uint64_t first, std::uint64_t count,
                                    std::vector<Photon>& photons) const {
        photons.clear();
        return pie::photons::PhotonTracer(*scene, lights, *intersector, options).trace(first, count, photons);
    }
};

/// Mean irradiance of every patch; walls in the order -x +x -y +y -z +z.
using Patches = std::array<double, patchCount>;

void add(const std::vector<Photon>& photons, Patches& patches) {
    constexpr double area = double{side} * side / (across * across);
    for (const Photon& photon : photons) {
        int axis = 0;
        const Vec3 off = glm::abs(photon.position - 0.5F * side);
        for (int i = 1; i < 3; ++i)
            if (off[i] > off[axis]) axis = i;
        const auto cell = [&](int i) {
            const float along = std::clamp(photon.position[i % 3] / side, 0.0F, 1.0F);
            return std::min<std::size_t>(static_cast<std::size_t>(along * across), across - 1);
        };
        const std::size_t wall = 2 * static_cast<std::size_t>(axis) + (photon.position[axis] > 0.5F * side ? 1 : 0);
        patches.at((wall * across + cell(axis + 1)) * across + cell(axis + 2)) +=
            static_cast<double>(photon.flux.x) / area;
    }
}

/// Each patch becomes the mean of its images under the symmetry of the cube.
void symmetrise(Patches& patches) {
    const auto kind = [](std::size_t patch) {
        std::size_t u = patch / across % across;
        std::size_t v = patch % across;
        u = std::min(u, across - 1 - u);
        v = std::min(v, across - 1 - v);
        return std::min(u, v) * across + std::max(u, v);
    };
    Patches sums{};
    Patches counts{};
    for (std::size_t i = 0; i < patchCount; ++i) {
        sums.at(kind(i)) += patches.at(i);
        ++counts.at(kind(i));
    }
    for (std::size_t i = 0; i < patchCount; ++i) patches.at(i) = sums.at(kind(i)) / counts.at(kind(i));
}

Patches reference(const Cube& cube) {
    constexpr std::uint64_t chunk = 1'000'000;
    constexpr std::uint64_t chunks = 8;
    TracerOptions options;
    options.recursionDepth = 60;
    options.seed = 7;
    Patches patches{};
    std::vector<Photon> photons;
    for (std::uint64_t i = 0; i < chunks; ++i) {
        cube.trace(options, i * chunk, chunk, photons);
        add(photons, patches);
    }
    for (double& patch : patches) patch /= chunks;
    symmetrise(patches);
    double mean = 0;
    for (const double patch : patches) mean += patch / patchCount;
    constexpr double exact = watts / (6.0 * side * side) * rho / (1 - rho);
    fmt::print(stderr, "mean of the reference over the exact mean: {:.5f}\n", mean / exact);
    return patches;
}

void traceError() {
    const Cube cube;
    const Patches truth = reference(cube);
    const auto line = [&](std::string_view name, const TracerOptions& options, std::uint64_t count) {
        constexpr std::uint64_t frames = 8;
        double squares = 0;
        std::uint64_t rays = 0;
        std::uint64_t stored = 0;
        std::vector<Photon> photons;
        for (std::uint64_t frame = 0; frame < frames; ++frame) {
            rays += cube.trace(options, frame * count, count, photons).rays;
            stored += photons.size();
            Patches patches{};
            add(photons, patches);
            for (std::size_t i = 0; i < patchCount; ++i)
                squares += std::pow(patches.at(i) / truth.at(i) - 1, 2) / static_cast<double>(frames * patchCount);
        }
        fmt::print("{},{},{:.0f},{:.0f},{:.6g}\n", name, count, static_cast<double>(rays) / frames,
                   static_cast<double>(stored) / frames, std::sqrt(squares));
    };
    fmt::print("tracing,photons,rays,stored,error\n");
    for (const unsigned depth : {2U, 4U, 8U}) {
        TracerOptions options;
        options.recursionDepth = depth;
        for (std::uint64_t count = 1000; count <= 1'024'000; count *= 2)
            line(fmt::format("roulette_{}", depth), options, count);
    }
    TracerOptions split;
    split.scattering = TracerOptions::Scattering::Splitting;
    for (std::uint64_t count = 1; count <= 256; count *= 2) line("split_8", split, count);
}

double exactDirect(const Vec3& point) {
    const Vec3 to = point - 0.5F * side;
    return double{watts} * 0.5 * double{side} / (4 * std::numbers::pi * std::pow(double{glm::length(to)}, 3));
}

/// Irradiance of the receivers from the photons of one frame.
std::vector<Rgb> estimate(const Cube& cube, const pie::scene::Receivers& receivers, std::uint64_t frame,
                          std::size_t count, bool trueArea) {
    constexpr std::uint64_t perFrame = 10'000;
    TracerOptions options;
    options.storeDirectLight = true;
    options.recursionDepth = 0;
    std::vector<Photon> photons;
    cube.trace(options, frame * perFrame, perFrame, photons);
    pie::maps::RealtimeMap map;
    map.replaceOldest(std::move(photons));
    map.rebuild();
    pie::gather::NearestOptions nearest;
    nearest.maxCount = count;
    const std::vector<std::uint32_t> which = pie::gather::test::all(receivers);
    std::vector<Rgb> irradiance(which.size());
    if (trueArea) {
        const pie::gather::TrueArea area(*cube.scene, pie::gather::Kernel::Epanechnikov, nearest.slice,
                                         nearest.maxRadius);
        const pie::gather::AreaTable table(area, receivers);
        pie::gather::NearestPhotons(*cube.scene, receivers, map, nearest, area, table).estimate(which, irradiance);
    } else {
        pie::gather::NearestPhotons(*cube.scene, receivers, map, nearest).estimate(which, irradiance);
    }
    return irradiance;
}

constexpr std::array estimators{"nearest", "true_area"};

void profile() {
    constexpr int steps = 64;
    constexpr int frames = 32;
    const Cube cube;
    pie::scene::Receivers receivers;
    for (int i = 0; i <= steps; ++i)
        receivers.points.push_back(pie::gather::test::receiverAt(
            {0.5F * side * (1.0F + static_cast<float>(i) / steps), 0.5F * side, 0.0F}, {0.0F, 0.0F, 1.0F}));
    fmt::print("estimator,units_from_edge,exact,mean,deviation\n");
    for (const std::string_view name : estimators) {
        std::vector<double> sums(receivers.points.size());
        std::vector<double> squares(receivers.points.size());
        for (int frame = 0; frame < frames; ++frame) {
            const std::vector<Rgb> found =
                estimate(cube, receivers, static_cast<std::uint64_t>(frame), 100, name == "true_area");
            for (std::size_t i = 0; i < found.size(); ++i) {
                sums[i] += double{found[i].x} / frames;
                squares[i] += std::pow(double{found[i].x}, 2) / frames;
            }
        }
        for (std::size_t i = 0; i < sums.size(); ++i)
            fmt::print("{},{},{:.5g},{:.5g},{:.5g}\n", name, side - receivers.points[i].position.x,
                       exactDirect(receivers.points[i].position), sums[i],
                       std::sqrt(std::max(0.0, squares[i] - sums[i] * sums[i])));
    }
}

/// Vertices of one wall, 64 units apart, as refinement leaves them: on its edges, in its corners and inside.
void countError() {
    constexpr int cells = 8;
    constexpr int frames = 16;
    const Cube cube;
    pie::scene::Receivers receivers;
    double mean = 0;
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x) {
            const Vec3 point(static_cast<float>(x) * side / cells, static_cast<float>(y) * side / cells, 0.0F);
            receivers.points.push_back(pie::gather::test::receiverAt(point, {0.0F, 0.0F, 1.0F}));
            mean += exactDirect(point) / ((cells + 1) * (cells + 1));
        }
    fmt::print("estimator,count,error\n");
    for (const std::string_view name : estimators)
        for (const std::size_t count : {5U, 10U, 20U, 35U, 50U, 70U, 100U, 140U, 200U, 300U, 400U, 600U, 800U}) {
            double squares = 0;
            for (int frame = 0; frame < frames; ++frame) {
                const std::vector<Rgb> found =
                    estimate(cube, receivers, static_cast<std::uint64_t>(frame), count, name == "true_area");
                for (std::size_t i = 0; i < found.size(); ++i)
                    squares += std::pow((double{found[i].x} - exactDirect(receivers.points[i].position)) / mean, 2);
            }
            fmt::print("{},{},{:.5g}\n", name, count,
                       std::sqrt(squares / static_cast<double>(receivers.points.size() * frames)));
        }
}

} // namespace

int main(int argumentCount, char** arguments) {
    const std::string_view wanted = argumentCount > 1 ? arguments[1] : "";
    if (wanted == "trace")
        traceError();
    else if (wanted == "profile")
        profile();
    else if (wanted == "count")
        countError();
    else
        return fmt::print(stderr, "furnace_bench trace|profile|count\n"), 1;
    return 0;
}
