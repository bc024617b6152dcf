// Rays a second of the three intersectors on a shipped level, one thread. `bounce`: from the level's surfaces in all
// directions of their front, as after a diffuse reflection, no two alike. `emit`: from one point, neighbours together,
// as a sorted emission would be. Items are rays.

#include "pie/intersect/intersector.h"
#include "pie/scene/receivers.h"
#include "tests/bench/bench_level.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <vector>

namespace pie::bench {
namespace {

using intersect::Hit;
using intersect::Kind;
using intersect::Ray;

constexpr std::size_t rayCount = 1U << 17U;
constexpr std::size_t batch = 4096;

const scene::Scene& benchScene() {
    static const scene::Scene scene = scene::makeScene(benchLevel());
    return scene;
}

const intersect::Intersector& intersector(Kind kind) {
    static std::array<std::unique_ptr<intersect::Intersector>, 3> made;
    auto& one = made.at(static_cast<std::size_t>(kind));
    if (!one) one = intersect::makeIntersector(kind, benchScene(), benchLevel().tree);
    return *one;
}

std::vector<Ray> bounceRays() {
    const scene::Mesh mesh = scene::makeMesh(benchLevel());
    const scene::Receivers receivers = scene::makeReceivers(mesh, benchLevel());
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    std::vector<Ray> rays(rayCount);
    for (Ray& ray : rays) {
        const scene::Receiver& from = receivers.points[random() % receivers.points.size()];
        ray.origin = from.inset + from.normal;
        ray.direction = glm::normalize(Vec3(normal(random), normal(random), normal(random)));
        if (glm::dot(ray.direction, from.normal) < 0.0F) ray.direction = -ray.direction;
    }
    return rays;
}

/// Squares of four by four directions after one another.
std::vector<Ray> emitRays() {
    const Vec3 eye = benchLevel().firstView().eye;
    std::vector<Ray> rays(rayCount);
    constexpr std::size_t across = 128; // squares of 4 × 4 in a row; 64 rows
    for (std::size_t i = 0; i < rayCount; ++i) {
        const std::size_t square = i / 16;
        const std::size_t column = square % across * 4 + i % 4;
        const std::size_t row = square / across * 4 + i % 16 / 4;
        const float u = (static_cast<float>(column) + 0.5F) / (4 * across);
        const float w = (static_cast<float>(row) + 0.5F) / 256;
        const float z = 1 - 2 * w;
        const float ring = std::sqrt(1 - z * z);
        const float turn = u * 6.2831853F;
        rays[i] = {eye, 0, {ring * std::cos(turn), ring * std::sin(turn), z}};
    }
    return rays;
}

const std::vector<Ray>& raysOf(bool emit) {
    static const std::vector<Ray> bounce = bounceRays();
    static const std::vector<Ray> emitted = emitRays();
    return emit ? emitted : bounce;
}

void closest(benchmark::State& state, Kind kind, bool emit) {
    const intersect::Intersector& one = intersector(kind);
    const std::span<const Ray> rays = raysOf(emit);
    // Brute force would take minutes for all of them.
    const std::size_t count = kind == Kind::BruteForce ? 256 : rays.size();
    std::vector<Hit> hits(batch);
    for ([[maybe_unused]] auto _ : state)
        for (std::size_t i = 0; i < count; i += batch) {
            const std::size_t some = std::min(batch, count - i);
            one.closest(rays.subspan(i, some), std::span(hits).first(some));
        }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
    state.counters["bytes"] = static_cast<double>(one.bytes());
}

void occluded(benchmark::State& state, Kind kind, bool emit) {
    const intersect::Intersector& one = intersector(kind);
    const std::span<const Ray> rays = raysOf(emit);
    const std::size_t count = kind == Kind::BruteForce ? 256 : rays.size();
    std::vector<std::uint8_t> blocked(batch);
    for ([[maybe_unused]] auto _ : state)
        for (std::size_t i = 0; i < count; i += batch) {
            const std::size_t some = std::min(batch, count - i);
            one.occluded(rays.subspan(i, some), std::span(blocked).first(some));
        }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}

void build(benchmark::State& state, Kind kind) {
    for ([[maybe_unused]] auto _ : state)
        benchmark::DoNotOptimize(intersect::makeIntersector(kind, benchScene(), benchLevel().tree));
    state.counters["triangles"] = static_cast<double>(benchScene().triangles.size());
}

BENCHMARK_CAPTURE(build, bsp, Kind::Bsp)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(build, embree, Kind::Embree)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(closest, bruteForce_bounce, Kind::BruteForce, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(closest, bsp_bounce, Kind::Bsp, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(closest, embree_bounce, Kind::Embree, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(closest, bsp_emit, Kind::Bsp, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(closest, embree_emit, Kind::Embree, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(occluded, bruteForce_bounce, Kind::BruteForce, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(occluded, bsp_bounce, Kind::Bsp, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(occluded, embree_bounce, Kind::Embree, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(occluded, bsp_emit, Kind::Bsp, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(occluded, embree_emit, Kind::Embree, true)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace pie::bench

BENCHMARK_MAIN();
