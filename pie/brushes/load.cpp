#include "pie/brushes/load.h"

#include "pie/brushes/compile.h"
#include "pie/core/clock.h"
#include "pie/level/names.h"

namespace pie::brushes {
namespace {

Result<level::Level> loadMap(std::span<const std::byte> bytes, level::Location location,
                             const level::LoadOptions& options) {
    std::string name = location.files.origin(location.name);
    if (name.empty()) name = location.name;
    auto start = Clock::now();
    const Result<MapText> map =
        parseMap(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()), name);
    if (!map) return map.error();
    level::LevelRecords records;
    records.dialect = "map text";
    records.warnings = map->problems;
    records.times.emplace_back("parse", millisecondsSince(start));
    start = Clock::now();
    records.shaders = level::ShaderLibrary::load(location.files);
    records.times.emplace_back("shaders", millisecondsSince(start));
    Result<CompiledMap> compiled = compileMap(*map, name, location.files, records.shaders);
    if (!compiled) return compiled.error();
    records.warnings.insert(records.warnings.end(), compiled->warnings.begin(), compiled->warnings.end());
    records.times.insert(records.times.end(), compiled->times.begin(), compiled->times.end());
    records.bsp = std::move(compiled->bsp);
    return level::makeLevel(std::move(records), std::move(location), options);
}

} // namespace

Result<level::Level> loadLevel(level::Location location, const level::LoadOptions& options) {
    if (!level::endsWithNoCase(location.name, ".map")) return level::loadLevel(std::move(location), options);
    const Result<level::Bytes> bytes = location.files.read(location.name);
    if (!bytes) return bytes.error();
    return loadMap(*bytes, std::move(location), options);
}

Result<level::Level> loadLevel(std::span<const std::byte> bytes, level::Location location,
                               const level::LoadOptions& options) {
    if (!level::endsWithNoCase(location.name, ".map")) return level::loadLevel(bytes, std::move(location), options);
    return loadMap(bytes, std::move(location), options);
}

} // namespace pie::brushes
