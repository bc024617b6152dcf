// The estimate cache three ways: a map by position as in the paper (pi-engine, fig 5.10), a hash map by position, and
// receivers by index. One iteration is one frame in which every triangle of the refined level is drawn, three corners
// each, as the paper draws them. The estimate itself is left out: a position is copied, so that what is left is the
// cache. `estimates` says how many a frame makes; the maps make fewer than there are receivers, because they give
// vertices of different normals the same light.

#include "pie/scene/receivers.h"
#include "tests/bench/bench_level.h"

#include <benchmark/benchmark.h>

#include <cstdint>
#include <functional>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

namespace pie::bench {
namespace {

using Estimate = std::pair<Vec3, int>; ///< irradiance, and the frame it was made in

struct Before {
    bool operator()(const Vec3& a, const Vec3& b) const {
        if (a.x != b.x) return a.x < b.x;
        return a.y != b.y ? a.y < b.y : a.z < b.z;
    }
};
struct Hash {
    std::size_t operator()(const Vec3& p) const {
        const std::hash<float> hash;
        return (hash(p.x) * 31 + hash(p.y)) * 31 + hash(p.z);
    }
};

template <class Cache> void byPosition(benchmark::State& state) {
    const scene::Mesh& mesh = benchMesh();
    Cache cache;
    int frame = 0;
    std::size_t made = 0;
    const auto draw = [&] {
        ++frame;
        Vec3 sum(0.0F);
        for (const scene::MeshTriangle& triangle : mesh.triangles)
            for (const std::uint32_t v : triangle.vertices) {
                Estimate& estimate = cache[mesh.vertices[v].position];
                if (estimate.second < frame) {
                    estimate = {mesh.vertices[v].position, frame};
                    ++made;
                }
                sum += estimate.first;
            }
        benchmark::DoNotOptimize(sum);
    };
    draw(); // fills the cache; later frames find every key
    made = 0;
    for ([[maybe_unused]] auto _ : state) draw();
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(3 * mesh.triangles.size()));
    state.counters["estimates"] = static_cast<double>(made) / static_cast<double>(state.iterations());
}

void mapByPosition(benchmark::State& state) { byPosition<std::map<Vec3, Estimate, Before>>(state); }
void hashMapByPosition(benchmark::State& state) { byPosition<std::unordered_map<Vec3, Estimate, Hash>>(state); }

void receiverByIndex(benchmark::State& state) {
    const scene::Mesh& mesh = benchMesh();
    const scene::Receivers receivers = scene::makeReceivers(mesh, benchLevel());
    std::vector<Estimate> cache(receivers.points.size());
    int frame = 0;
    std::size_t made = 0;
    for ([[maybe_unused]] auto _ : state) {
        ++frame;
        Vec3 sum(0.0F);
        for (const scene::MeshTriangle& triangle : mesh.triangles)
            for (const std::uint32_t v : triangle.vertices) {
                const std::uint32_t r = receivers.ofVertex[v];
                if (r == scene::noReceiver) continue;
                Estimate& estimate = cache[r];
                if (estimate.second < frame) {
                    estimate = {receivers.points[r].position, frame};
                    ++made;
                }
                sum += estimate.first;
            }
        benchmark::DoNotOptimize(sum);
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(3 * mesh.triangles.size()));
    state.counters["estimates"] = static_cast<double>(made) / static_cast<double>(state.iterations());
}

BENCHMARK(mapByPosition)->Unit(benchmark::kMillisecond);
BENCHMARK(hashMapByPosition)->Unit(benchmark::kMillisecond);
BENCHMARK(receiverByIndex)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace pie::bench

BENCHMARK_MAIN();
