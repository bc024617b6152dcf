// CPU milliseconds from .map text to the records of a level, by stage, the least of some runs with one thread:
//     brushes_bench LEVEL.map [RUNS]
// doc/scripts/map-times --write makes levels of any size.

#include "pie/brushes/compile.h"
#include "pie/core/parallel.h"
#include "pie/level/level.h"
#include "tests/bench/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>
#include <string>

int main(int argc, char** argv) {
    using namespace pie;
    if (argc < 2) {
        fmt::print(stderr, "usage: brushes_bench LEVEL.map [RUNS]\n");
        return 2;
    }
    setThreads(1);
    const int runs = argc > 2 ? std::atoi(argv[2]) : 5;
    const Result<level::Location> location = level::locate(argv[1], {}, {});
    if (!location) return 1;
    const Result<level::Bytes> bytes = location->files.read(location->name);
    if (!bytes) return 1;
    const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    const level::ShaderLibrary shaders = level::ShaderLibrary::load(location->files);
    double parse = std::numeric_limits<double>::max();
    double compile = parse;
    std::vector<level::StageTime> stages;
    for (int i = 0; i < runs; ++i) {
        const double start = processorMilliseconds();
        const Result<brushes::MapText> map = brushes::parseMap(text, argv[1]);
        if (!map) return 1;
        const double parsed = processorMilliseconds();
        const Result<brushes::CompiledMap> compiled = brushes::compileMap(*map, argv[1], location->files, shaders);
        if (!compiled) return 1;
        parse = std::min(parse, parsed - start);
        compile = std::min(compile, processorMilliseconds() - parsed);
        if (stages.empty()) stages = compiled->times;
        for (std::size_t s = 0; s < stages.size(); ++s)
            stages[s].second = std::min(stages[s].second, compiled->times[s].second);
    }
    fmt::print("parse {:.1f}, compile {:.1f}, both {:.1f} ms of CPU; by the clock:", parse, compile, parse + compile);
    for (const auto& [name, milliseconds] : stages) fmt::print(" {} {:.1f}", name, milliseconds);
    fmt::print("\n");
    return 0;
}
