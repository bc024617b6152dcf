#include "pie/level/assemble.h"
#include "pie/level/level.h"
#include "pie/level/names.h"

#include <chrono>

namespace pie::level {
namespace {

/// Notes how long each stage of a load took.
class StageClock {
public:
    explicit StageClock(LoadStatistics& statistics) : statistics_(&statistics) {}
    void done(const char* stage) {
        const auto now = std::chrono::steady_clock::now();
        statistics_->times.emplace_back(stage, std::chrono::duration<double, std::milli>(now - last_).count());
        last_ = now;
    }

private:
    LoadStatistics* statistics_;
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void countLumps(const Bsp& bsp, LoadStatistics& statistics) {
    const std::array<std::size_t, lumpCount> counts = {
        bsp.entities.size(),       bsp.shaders.size(),    bsp.planes.size(),      bsp.nodes.size(),
        bsp.leaves.size(),         bsp.leafFaces.size(),  bsp.leafBrushes.size(), bsp.models.size(),
        bsp.brushes.size(),        bsp.brushSides.size(), bsp.vertices.size(),    bsp.meshVertices.size(),
        bsp.effects.size(),        bsp.faces.size(),      bsp.lightmaps.size(),   bsp.lightVolumes.size(),
        bsp.visibility.bits.size()};
    for (int i = 0; i < lumpCount; ++i)
        statistics.lumps.emplace_back(lumpName(static_cast<Lump>(i)), counts.at(static_cast<std::size_t>(i)));
}

/// "oa_dm1" of "maps/oa_dm1.bsp".
std::string stem(const std::string& name) {
    const std::size_t slash = name.rfind('/');
    return std::string(withoutExtension(slash == std::string::npos ? name : name.substr(slash + 1)));
}

/// Where the level was found, for messages.
std::string nameOf(const Location& location) {
    std::string name = location.files.origin(location.name);
    return name.empty() ? location.name : name;
}

void reportDefects(Level& level, const Bsp& bsp, const ShaderLibrary& shaders) {
    std::vector<std::string>& warnings = level.statistics.warnings;
    for (const std::string& warning : level.files->warnings()) warnings.push_back(warning);
    for (const std::string& warning : shaders.warnings()) warnings.push_back(warning);
    for (const Shader& shader : level.shaders)
        for (const std::string& defect : shader.defects) warnings.push_back(defect);
    if (bsp.nonFiniteLightmapCoordinates != 0)
        warnings.push_back(level.file + ": " + std::to_string(bsp.nonFiniteLightmapCoordinates) +
                           " vertices have coordinates or normals that are not finite; they count as 0");
}

} // namespace

Result<Level> loadLevel(Location location, const LoadOptions& options) {
    LoadStatistics reading;
    StageClock clock(reading);
    const Result<Bytes> bytes = location.files.read(location.name);
    if (!bytes) return bytes.error();
    clock.done("file");
    Result<Level> level = loadLevel(*bytes, std::move(location), options);
    if (level) level->statistics.times.insert(level->statistics.times.begin(), reading.times.front());
    return level;
}

Result<Level> loadLevel(std::span<const std::byte> bytes, Location location, const LoadOptions& options) {
    LoadStatistics reading;
    StageClock clock(reading);
    Result<Bsp> bsp = readBsp(bytes, nameOf(location));
    if (!bsp) return bsp.error();
    LevelRecords records{std::move(*bsp), {}, dialect(bytes), {}, {}};
    clock.done("parse");
    records.shaders = ShaderLibrary::load(location.files);
    clock.done("shaders");
    records.times = reading.times;
    return makeLevel(std::move(records), std::move(location), options);
}

Result<Level> makeLevel(LevelRecords records, Location location, const LoadOptions& options) {
    Level level;
    level.statistics.dialect = std::move(records.dialect);
    level.statistics.warnings = std::move(records.warnings);
    level.statistics.times = std::move(records.times);
    StageClock clock(level.statistics);
    level.name = stem(location.name);
    level.file = nameOf(location);
    level.files = std::make_shared<const Vfs>(std::move(location.files));

    countLumps(records.bsp, level.statistics);
    if (const std::optional<Error> error = addEntities(level, records.bsp, location.name)) return *error;
    addTree(level, records.bsp);
    addModels(level, records.bsp);
    addFogs(level, records.bsp, records.shaders);

    const AssemblyInput input{records.bsp, records.shaders, options};
    if (const std::optional<Error> error = addSurfaces(level, input)) return *error;
    addLightmaps(level, input);
    addDrawnStatistics(level);
    clock.done("surfaces");

    addTextures(level, options);
    reportDefects(level, records.bsp, records.shaders);
    clock.done("images");
    return level;
}

} // namespace pie::level
