// What loading costs between the file and the first frame: scene, mesh, refinement, receivers, cells.

#include "pie/core/parallel.h"
#include "pie/scene/cells.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"
#include "tests/bench/bench_level.h"

#include <benchmark/benchmark.h>

namespace pie::bench {
namespace {

void buildScene(benchmark::State& state) {
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(scene::makeScene(benchLevel()));
}
void buildMesh(benchmark::State& state) {
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(scene::makeMesh(benchLevel()));
}

void refineBy(benchmark::State& state, const scene::RefineOptions& options) {
    const scene::Mesh coarse = scene::makeMesh(benchLevel());
    std::size_t triangles = 0;
    for ([[maybe_unused]] auto _ : state) {
        state.PauseTiming();
        scene::Mesh mesh = coarse;
        state.ResumeTiming();
        scene::refine(mesh, options);
        triangles = mesh.triangles.size();
    }
    state.counters["from"] = static_cast<double>(coarse.triangles.size());
    state.counters["to"] = static_cast<double>(triangles);
}

/// Argument: longest edge in units.
void refineToEdge(benchmark::State& state) {
    scene::RefineOptions options;
    options.maxEdge = static_cast<float>(state.range(0));
    refineBy(state, options);
}
/// Argument: splits.
void refineBySplits(benchmark::State& state) {
    scene::RefineOptions options;
    options.maxSplits = static_cast<std::size_t>(state.range(0));
    refineBy(state, options);
}

void closeTJunctions(benchmark::State& state) {
    const scene::Mesh coarse = scene::makeMesh(benchLevel());
    std::size_t closed = 0;
    for ([[maybe_unused]] auto _ : state) {
        state.PauseTiming();
        scene::Mesh mesh = coarse;
        state.ResumeTiming();
        closed = scene::closeTJunctions(mesh);
    }
    state.counters["closed"] = static_cast<double>(closed);
}

void buildReceivers(benchmark::State& state) {
    const scene::Mesh& mesh = benchMesh();
    std::size_t count = 0;
    for ([[maybe_unused]] auto _ : state) count = scene::makeReceivers(mesh, benchLevel()).points.size();
    state.counters["receivers"] = static_cast<double>(count);
}
void buildCells(benchmark::State& state) {
    const scene::Mesh& mesh = benchMesh();
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(scene::makeCells(mesh, benchLevel()));
}

BENCHMARK(buildScene)->Unit(benchmark::kMillisecond);
BENCHMARK(buildMesh)->Unit(benchmark::kMillisecond);
BENCHMARK(closeTJunctions)->Unit(benchmark::kMillisecond);
BENCHMARK(refineToEdge)->Arg(192)->Arg(96)->Arg(64)->Arg(48)->Arg(32)->Unit(benchmark::kMillisecond);
BENCHMARK(refineBySplits)->Arg(10'000)->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(buildReceivers)->Unit(benchmark::kMillisecond);
BENCHMARK(buildCells)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace pie::bench

int main(int count, char** arguments) {
    pie::setThreads(1); // processor time of one thread: what else the machine does hardly shows
    benchmark::Initialize(&count, arguments);
    if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 1;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
