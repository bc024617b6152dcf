// How well the distributions of directions do, three ways; prints CSV.
//
//   distribution_bench spread [largest count]     discrepancy of directions on hemisphere and sphere
//   distribution_bench light [largest count]      irradiance in scenes with closed forms, against photons
//   distribution_bench rays                       roulette against splitting, at equal rays
//   distribution_bench time                       nanoseconds a photon's path, over Halton's
//
// `spread`: spherical caps (of the cosine law on the hemisphere): rms over 256 caps, and 8 frames of 4 seeds, of the
// share of directions in a cap off its exact value. `light`: relative rms error over patches and over 8 frames, of
//   plane   direct light on a plane under a point light, 64 patches: Φ cos³θ / (4 π h²)
//   sphere  all light in a sphere furnace of reflectance 0.5 with the lamp off its middle, 64 patches, where what is
//           reflected has one irradiance everywhere, Φ ρ / (4 π R² (1 − ρ)), and what is direct a formula
//   cube    indirect light in a cube furnace, 96 patches, against 16 million photons
//   lamps   the same in a room lit by 24 area lights of different power

#include "pie/core/parallel.h"
#include "pie/photons/tracer.h"
#include "tests/lights/rooms.h"
#include "tests/sampling/distributions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <functional>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

namespace {

using pie::Rgb;
using pie::Vec2;
using pie::Vec3;
using pie::photons::Photon;
using pie::photons::TracerOptions;
using pie::sampling::Distribution;
using pie::test::allDistributions;
using pie::test::distributionName;

constexpr double pi = std::numbers::pi;
constexpr std::uint64_t seeds = 4;
constexpr std::uint64_t framesPerSeed = 2;

// spread

struct Cap {
    Vec3 axis{0.0F};
    float cosine = 1;
    double share = 0;
};
/// On the hemisphere all of a cap is above the horizon: its projection is an ellipse, of area π sin² × cosine.
std::vector<Cap> makeCaps(bool hemisphere) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit;
    std::vector<Cap> caps(256);
    for (Cap& cap : caps) {
        const double half = (5 + 40 * unit(random)) * pi / 180;
        const double turn = 2 * pi * unit(random);
        const double lowest = hemisphere ? std::sin(half) : -1.0;
        const double z = lowest + (1 - lowest) * unit(random);
        const double ring = std::sqrt(1 - z * z);
        cap.axis = Vec3(ring * std::cos(turn), ring * std::sin(turn), z);
        cap.cosine = static_cast<float>(std::cos(half));
        cap.share = hemisphere ? std::sin(half) * std::sin(half) * z : 0.5 * (1 - std::cos(half));
    }
    return caps;
}

void spread(std::size_t largest) {
    fmt::print("domain,distribution,count,error\n");
    for (const bool hemisphere : {true, false}) {
        const std::vector<Cap> caps = makeCaps(hemisphere);
        for (const Distribution distribution : allDistributions)
            for (std::size_t count = 25; count <= largest; count *= 2) {
                double sum = 0;
                std::vector<Vec3> directions(count);
                std::vector<float> x(count);
                std::vector<float> y(count);
                for (std::uint64_t seed = 1; seed <= seeds; ++seed)
                    for (std::uint64_t frame = 0; frame < framesPerSeed; ++frame) {
                        const auto sequence = pie::sampling::makeSequence(distribution, {seed, count, 1});
                        // A reflection on the hemisphere, emission on the sphere.
                        if (hemisphere) {
                            std::visit(
                                [&](const auto& s) {
                                    for (std::size_t i = 0; i < count; ++i)
                                        directions[i] = pie::sampling::cosine(s, frame * count + i, 5);
                                },
                                sequence);
                        } else {
                            pie::sampling::fillDirections(sequence, frame * count, 1, x, y);
                            for (std::size_t i = 0; i < count; ++i)
                                directions[i] = pie::sampling::uniformSphere({x[i], y[i]});
                        }
                        for (const Cap& cap : caps) {
                            std::size_t inside = 0;
                            for (const Vec3& direction : directions)
                                inside += glm::dot(direction, cap.axis) >= cap.cosine ? 1 : 0;
                            sum += std::pow(static_cast<double>(inside) / static_cast<double>(count) - cap.share, 2);
                        }
                    }
                fmt::print("{},{},{},{:.6g}\n", hemisphere ? "hemisphere" : "sphere", distributionName(distribution),
                           count, std::sqrt(sum / static_cast<double>(seeds * framesPerSeed * caps.size())));
            }
    }
}

// light

/// A scene, which patch of it a photon lies on, and what the patches hold in truth.
struct Bench {
    std::string_view name;
    std::shared_ptr<const pie::scene::Scene> scene;
    pie::lights::LightSet lights;
    std::unique_ptr<pie::intersect::Intersector> intersector;
    TracerOptions options;
    std::size_t patches = 0;
    std::function<std::size_t(const Vec3&)> patchOf; ///< `patches` for none
    std::vector<double> flux;                        ///< of each patch, watts

    void prepare(std::vector<pie::lights::Light> list) {
        lights = pie::lights::LightSet(std::move(list), scene);
        intersector = pie::intersect::makeIntersector(pie::intersect::Kind::Embree, *scene, {});
    }
    pie::photons::TraceCounts trace(const TracerOptions& how, std::uint64_t first, std::uint64_t count,
                                    std::vector<double>& found) const {
        std::vector<Photon> photons;
        const auto counts = pie::photons::PhotonTracer(*scene, lights, *intersector, how).trace(first, count, photons);
        found.assign(patches + 1, 0.0);
        for (const Photon& photon : photons) found[patchOf(photon.position)] += static_cast<double>(photon.flux.x);
        return counts;
    }
    /// Where there is no formula: photons enough.
    void makeReference() {
        constexpr std::uint64_t chunk = 1'000'000;
        constexpr std::uint64_t chunks = 16;
        TracerOptions how = options;
        how.seed = 1000;
        flux.assign(patches, 0.0);
        std::vector<double> found;
        for (std::uint64_t i = 0; i < chunks; ++i) {
            trace(how, i * chunk, chunk, found);
            for (std::size_t k = 0; k < patches; ++k) flux[k] += found[k] / chunks;
        }
    }
};

pie::lights::PointLight lamp(const Vec3& position) {
    pie::lights::PointLight light{position, Rgb(1000.0F), {}};
    light.falloff.minDistance = 0;
    return light;
}

Bench plane() {
    Bench bench;
    bench.name = "plane";
    pie::test::RoomBuilder room;
    const auto black = room.material(pie::test::opaque(Rgb(0.0F)));
    constexpr float half = 256;
    room.quad({-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}, black);
    bench.scene = room.build();
    bench.options.storeDirectLight = true;
    bench.options.recursionDepth = 0;
    bench.patches = 64;
    bench.patchOf = [](const Vec3& p) {
        const auto cell = [](float x) {
            return std::min<std::size_t>(7, static_cast<std::size_t>(std::max(0.0F, (x + half) / 64)));
        };
        return 8 * cell(p.y) + cell(p.x);
    };
    constexpr double height = 200;
    bench.prepare({lamp({30, -20, height})});
    constexpr int steps = 64;
    for (int i = 0; i < 64; ++i) {
        double sum = 0;
        for (int k = 0; k < steps * steps; ++k) {
            const double x = -half + 64.0 * (i % 8) + 64.0 * (k % steps + 0.5) / steps - 30;
            const double y = -half + 64.0 * (i / 8) + 64.0 * (k / steps + 0.5) / steps + 20;
            const double d2 = x * x + y * y + height * height;
            const double cosine = height / std::sqrt(d2);
            sum += 1000.0 * cosine * cosine * cosine / (4 * pi * height * height); // Φ cos³ / (4 π h²)
        }
        bench.flux.push_back(sum * 64 * 64 / (steps * steps));
    }
    return bench;
}

/// Equal patches of the sphere: 8 bands of height by 8 sectors.
Bench sphere() {
    Bench bench;
    bench.name = "sphere";
    constexpr float radius = 256;
    constexpr double rho = 0.5;
    pie::test::RoomBuilder room;
    const auto grey = room.material(pie::test::opaque(Rgb(static_cast<float>(rho))));
    constexpr int rows = 96;
    constexpr int columns = 192;
    const auto at = [&](int i, int k) {
        const double theta = pi * i / rows;
        const double phi = 2 * pi * (k % columns) / columns;
        return Vec3(radius * std::sin(theta) * std::cos(phi), radius * std::sin(theta) * std::sin(phi),
                    radius * std::cos(theta));
    };
    for (int i = 0; i < rows; ++i)
        for (int k = 0; k < columns; ++k) {
            // Seen from inside.
            if (i > 0) room.triangle(at(i, k), at(i, k + 1), at(i + 1, k), grey);
            if (i == 0)
                room.triangle(at(0, 0), at(1, k + 1), at(1, k), grey);
            else if (i + 1 < rows)
                room.triangle(at(i, k + 1), at(i + 1, k + 1), at(i + 1, k), grey);
        }
    bench.scene = room.build();
    bench.options.storeDirectLight = true;
    bench.options.recursionDepth = 60;
    bench.patches = 64;
    const auto band = [](double z) { return std::clamp(static_cast<int>((1 - z) * 4), 0, 7); };
    bench.patchOf = [=](const Vec3& p) {
        const double turn = std::atan2(p.y, p.x) / (2 * pi) + 0.5;
        return static_cast<std::size_t>(8 * band(p.z / glm::length(p)) + std::clamp(static_cast<int>(8 * turn), 0, 7));
    };
    const Vec3 at0(60, 40, -50);
    bench.prepare({lamp(at0)});
    constexpr double watts = 1000;
    constexpr int steps = 100;
    for (int i = 0; i < 64; ++i) {
        double direct = 0;
        for (int k = 0; k < steps * steps; ++k) {
            const double z = 1 - (i / 8 + (k / steps + 0.5) / steps) / 4;
            const double turn = 2 * pi * ((i % 8 + (k % steps + 0.5) / steps) / 8 - 0.5);
            const double ring = std::sqrt(1 - z * z);
            const glm::dvec3 p = double{radius} * glm::dvec3(ring * std::cos(turn), ring * std::sin(turn), z);
            const glm::dvec3 way = p - glm::dvec3(at0);
            direct += glm::dot(way, p) / radius / std::pow(glm::length(way), 3); // cosine over squared distance
        }
        const double area = 4 * pi * double{radius} * radius / 64;
        bench.flux.push_back(watts / (4 * pi) * direct * area / (steps * steps) + watts * rho / (1 - rho) / 64);
    }
    return bench;
}

std::size_t boxPatch(const Vec3& p, const Vec3& size) {
    int axis = 0;
    const Vec3 off = glm::abs(p / size - 0.5F);
    for (int i = 1; i < 3; ++i)
        if (off[i] > off[axis]) axis = i;
    const auto cell = [&](int i) {
        return std::min<std::size_t>(3, static_cast<std::size_t>(std::max(0.0F, 4 * p[i % 3] / size[i % 3])));
    };
    const auto wall = static_cast<std::size_t>(2 * axis) + (p[axis] > 0.5F * size[axis] ? 1 : 0);
    return (wall * 4 + cell(axis + 1)) * 4 + cell(axis + 2);
}

Bench cube(std::string_view name, bool lamps, unsigned depth) {
    Bench bench;
    bench.name = name;
    constexpr float side = 512;
    pie::test::RoomBuilder room;
    const auto grey = room.material(pie::test::opaque(Rgb(0.5F)));
    room.inside(Vec3(0.0F), Vec3(side), {grey, grey, grey, grey, grey, grey});
    bench.scene = room.build();
    bench.patches = 96;
    bench.options.recursionDepth = depth;
    bench.patchOf = [](const Vec3& p) { return boxPatch(p, Vec3(side)); };
    std::vector<pie::lights::Light> list;
    if (lamps) {
        for (int i = 0; i < 24; ++i) {
            const float x = 40 + 80.0F * static_cast<float>(i % 6);
            const float y = 60 + 110.0F * static_cast<float>(i / 6);
            list.emplace_back(
                pie::lights::makeAreaLight({{x, y, 500}, {x, y + 30, 500}, {x + 30, y + 30, 500}, {x + 30, y, 500}},
                                           Rgb(1.0F + static_cast<float>(i * i % 11))));
        }
    } else {
        list.emplace_back(lamp({150, 300, 230}));
    }
    bench.prepare(std::move(list));
    bench.makeReference();
    return bench;
}

double error(const Bench& bench, TracerOptions how, std::uint64_t count, double& rays) {
    double squares = 0;
    rays = 0;
    std::vector<double> found;
    constexpr double repetitions = seeds * framesPerSeed;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed)
        for (std::uint64_t frame = 0; frame < framesPerSeed; ++frame) {
            how.seed = seed;
            how.photonsPerFrame = count;
            rays += static_cast<double>(bench.trace(how, frame * count, count, found).rays) / repetitions;
            for (std::size_t i = 0; i < bench.patches; ++i)
                squares += std::pow(found[i] / bench.flux[i] - 1, 2) / static_cast<double>(bench.patches) / repetitions;
        }
    return std::sqrt(squares);
}

/// What the light draws from, what reflections draw from.
using Pair = std::pair<Distribution, Distribution>;

std::vector<Pair> pairs() {
    std::vector<Pair> all;
    for (const Distribution distribution : allDistributions) all.emplace_back(distribution, distribution);
    all.emplace_back(Distribution::Spiral, Distribution::Stratified); // the paper's choice
    all.emplace_back(Distribution::Spiral, Distribution::Halton);
    return all;
}

void light(std::uint64_t largest) {
    fmt::print("scene,distribution,photons,rays,error\n");
    const Bench benches[]{plane(), sphere(), cube("cube", false, 8), cube("lamps", true, 8)};
    for (const Bench& bench : benches)
        for (const auto& [emission, reflection] : pairs())
            for (std::uint64_t count = 1000; count <= largest; count *= 2) {
                TracerOptions how = bench.options;
                how.lightDistribution = emission;
                how.diffuseDistribution = reflection;
                double rays = 0;
                const double off = error(bench, how, count, rays);
                const std::string name = emission == reflection
                                             ? distributionName(emission)
                                             : distributionName(emission) + "+" + distributionName(reflection);
                fmt::print("{},{},{},{:.0f},{:.6g}\n", bench.name, name, count, rays, off);
                std::fflush(stdout);
            }
}

// rays

void equalRays() {
    fmt::print("depth,scattering,photons,rays,error\n");
    for (const unsigned depth : {1U, 8U}) {
        const Bench bench = cube("cube", false, depth);
        const auto line = [&](const std::string& name, const TracerOptions& how, std::uint64_t count) {
            double rays = 0;
            const double off = error(bench, how, count, rays);
            fmt::print("{},{},{},{:.0f},{:.6g}\n", depth, name, count, rays, off);
        };
        for (std::uint64_t count = 1000; count <= 256'000; count *= 2) line("roulette", bench.options, count);
        for (const unsigned children : {2U, 4U, 36U}) {
            TracerOptions how = bench.options;
            how.scattering = TracerOptions::Scattering::Splitting;
            how.diffuseReflections = children;
            // Rays of a photon: 1 + n + n² … up to the bound, then as many at every depth.
            double paths = 1;
            double perPhoton = 1;
            for (unsigned i = 0; i < depth; ++i)
                perPhoton += paths = paths * children <= pie::photons::maxPathsPerPhoton ? paths * children : paths;
            for (std::uint64_t count = 1; count <= 256'000; count *= 2) {
                const double rays = perPhoton * static_cast<double>(count);
                if (rays >= 2000 && rays <= 800'000) line(fmt::format("split_{}", children), how, count);
            }
        }
    }
}

// time

double seconds() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Emission and the directions and roulette of three reflections; rounds alternate, the least time counts.
void time() {
    constexpr std::size_t count = 20'000;
    constexpr int rounds = 25;
    std::vector<double> least(allDistributions.size(), 1e9);
    std::vector<float> x(count);
    std::vector<float> y(count);
    float sink = 0;
    std::vector<pie::sampling::Sequence> sequences;
    for (const Distribution distribution : allDistributions)
        sequences.push_back(pie::sampling::makeSequence(distribution, {1, count, 1}));
    for (int round = 0; round < rounds; ++round)
        for (std::size_t k = 0; k < sequences.size(); ++k) {
            const double begin = seconds();
            pie::sampling::fill(sequences[k], 0, 0, x);
            sink += x[count / 2];
            pie::sampling::fillPairs(sequences[k], 0, 3, x, y);
            sink += x[count / 2];
            pie::sampling::fillDirections(sequences[k], 0, 1, x, y);
            for (std::size_t i = 0; i < count; ++i) sink += pie::sampling::uniformSphere({x[i], y[i]}).x;
            std::visit(
                [&](const auto& s) {
                    for (unsigned d = 5; d < 14; d += 3)
                        for (std::size_t i = 0; i < count; ++i) sink += pie::sampling::cosine(s, i, d).x + s(i, d + 2);
                },
                sequences[k]);
            least[k] = std::min(least[k], seconds() - begin);
        }
    fmt::print("distribution,nanoseconds,over_halton\n");
    for (std::size_t k = 0; k < least.size(); ++k)
        fmt::print("{},{:.1f},{:.3f}\n", distributionName(allDistributions.at(k)), 1e9 * least[k] / count,
                   least[k] / least[0]);
    if (!(sink < 1e30F)) std::abort(); // keeps the work
}

} // namespace

int main(int argumentCount, char** arguments) try {
    const std::string_view wanted = argumentCount > 1 ? arguments[1] : "";
    const auto largest = [&](std::uint64_t usual) {
        return argumentCount > 2 ? std::strtoull(arguments[2], nullptr, 10) : usual;
    };
    pie::setThreads(1);
    if (wanted == "spread")
        spread(largest(25'600));
    else if (wanted == "light")
        light(largest(128'000));
    else if (wanted == "rays")
        equalRays();
    else if (wanted == "time")
        time();
    else
        return fmt::print(stderr, "distribution_bench spread|light|rays|time\n"), 1;
    return 0;
} catch (const std::exception& problem) {
    return fmt::print(stderr, "{}\n", problem.what()), 1;
}
