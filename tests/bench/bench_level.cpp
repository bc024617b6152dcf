#include "tests/bench/bench_level.h"

#include <cstdlib>
#include <fmt/format.h>

namespace pie::bench {
namespace {

[[noreturn]] void give(const Error& error) {
    fmt::print(stderr, "bench: {}\n", error.message());
    std::exit(1);
}

level::Level load() {
    const char* const wanted = std::getenv("PIE_BENCH_LEVEL");
    Result<level::Location> location =
        level::locate(wanted != nullptr ? wanted : "ctf_inyard", "/usr/share/games/openarena/baseoa");
    if (!location) give(location.error());
    level::LoadOptions options;
    options.images = false;
    Result<level::Level> level = level::loadLevel(std::move(*location), options);
    if (!level) give(level.error());
    return std::move(*level);
}

scene::Mesh refined() {
    scene::Mesh mesh = scene::makeMesh(benchLevel());
    scene::RefineOptions options;
    options.maxEdge = 48;
    scene::refine(mesh, options);
    return mesh;
}

} // namespace

const level::Level& benchLevel() {
    static const level::Level level = load();
    return level;
}

const scene::Mesh& benchMesh() {
    static const scene::Mesh mesh = refined();
    return mesh;
}

} // namespace pie::bench
