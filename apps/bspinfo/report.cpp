#include "apps/bspinfo/report.h"

#include "pie/brushes/load.h"
#include "pie/lights/light_set.h"
#include "pie/scene/scene.h"

#include <chrono>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace bspinfo {
namespace {

using Json = nlohmann::ordered_json;
using pie::level::Level;
using pie::level::LoadStatistics;

/// Names every stage as it ends.
class StopWatch {
public:
    explicit StopWatch(std::vector<pie::level::StageTime>& times) : times_(times) {}
    void stage(const std::string& name) {
        const auto now = Clock::now();
        times_.emplace_back(name, std::chrono::duration<double, std::milli>(now - last_).count());
        last_ = now;
    }
    void skip() { last_ = Clock::now(); }

private:
    using Clock = std::chrono::steady_clock;
    std::vector<pie::level::StageTime>& times_;
    Clock::time_point last_ = Clock::now();
};

std::vector<std::pair<std::string, std::size_t>> lightCounts(const pie::lights::ImportedLights& lights) {
    return {{"point", lights.points}, {"sphere", lights.spheres}, {"spot", lights.spots},
            {"area", lights.areas},   {"sun", lights.suns},       {"sky", lights.skies}};
}

std::size_t foundTextures(const Level& level) {
    std::size_t found = 0;
    for (const pie::level::Texture& texture : level.textures) found += texture.path.empty() ? 0 : 1;
    return found;
}

std::size_t externalLightmaps(const Level& level) {
    std::size_t external = 0;
    for (const pie::level::Lightmap& lightmap : level.lightmaps) external += lightmap.external ? 1 : 0;
    return external;
}

double total(const std::vector<pie::level::StageTime>& times) {
    double sum = 0;
    for (const auto& [stage, milliseconds] : times) sum += milliseconds;
    return sum;
}

Json array(const pie::Vec3& v) { return Json::array({v.x, v.y, v.z}); }

std::string point(const pie::Vec3& v) { return fmt::format("({:g} {:g} {:g})", v.x, v.y, v.z); }

/// "label     first" and the rest below it, indented alike.
void section(std::string& page, std::string_view label, const std::vector<std::string>& lines) {
    constexpr int labelWidth = 10;
    for (const std::string& line : lines) {
        page += fmt::format("{:<{}}{}\n", label, labelWidth, line);
        label = {};
    }
}

std::string listed(const std::vector<std::pair<std::string, std::size_t>>& pairs) {
    std::vector<std::string> words;
    words.reserve(pairs.size());
    for (const auto& [name, value] : pairs) words.push_back(fmt::format("{} {}", name, value));
    return fmt::format("{}", fmt::join(words, ", "));
}

std::vector<std::string> timeLines(const Report& report) {
    std::vector<std::string> words;
    for (const auto& [stage, milliseconds] : report.times)
        words.push_back(fmt::format("{} {:.1f}", stage, milliseconds));
    return {fmt::format("{:.1f} ms: {}", total(report.times), fmt::join(words, ", "))};
}

std::vector<std::string> textureLines(const Report& report) {
    const std::vector<std::string>& missing = report.level.statistics.missingTextures;
    std::vector<std::string> lines{fmt::format("{} found, {} missing", foundTextures(report.level), missing.size())};
    for (const std::string& name : missing) lines.push_back("missing: " + name);
    return lines;
}

std::vector<std::string> lightLines(const Report& report) {
    std::vector<std::string> lines{report.lights.summary()};
    for (const auto& [kind, power] : report.powerOfKind)
        lines.push_back(fmt::format("{}: {:.4g} {:.4g} {:.4g} watts", kind, power.x, power.y, power.z));
    return lines;
}

} // namespace

pie::Result<Report> inspect(const std::string& level, const std::filesystem::path& game,
                            const std::vector<std::filesystem::path>& textures) {
    Report report;
    StopWatch watch(report.times);
    pie::Result<pie::level::Location> location = pie::level::locate(level, game, textures);
    if (!location) return location.error();
    watch.stage("find");
    pie::Result<Level> loaded = pie::brushes::loadLevel(std::move(*location));
    if (!loaded) return loaded.error();
    report.level = std::move(*loaded);
    for (const pie::level::StageTime& stage : report.level.statistics.times) report.times.push_back(stage);
    watch.skip();
    const auto scene = std::make_shared<const pie::scene::Scene>(pie::scene::makeScene(report.level));
    watch.stage("scene");
    report.lights = pie::lights::importLights(report.level, *scene);
    const pie::lights::LightSet set(report.lights.lights, scene);
    for (const pie::lights::Light& light : set.lights())
        report.powerOfKind[std::string(pie::lights::kindName(light))] +=
            pie::lights::power(light, *scene, set.portals());
    watch.stage("lights");
    return report;
}

std::string text(const Report& report) {
    const Level& level = report.level;
    const LoadStatistics& s = level.statistics;
    std::string page;
    section(page, "level", {level.name, level.file});
    section(page, "dialect", {s.dialect});
    section(page, "lumps", {listed(s.lumps)});
    section(page, "faces",
            {fmt::format("{}: {} polygons, {} patches, {} models, {} flares",
                         s.polygons + s.patches + s.meshes + s.flares, s.polygons, s.patches, s.meshes, s.flares)});
    section(page, "drawn",
            {fmt::format("{} triangles, {:.0f} square units, {} to {}", s.drawnTriangles, s.drawnArea,
                         point(s.drawnBounds.lower), point(s.drawnBounds.upper))});
    section(page, "lightmaps",
            {fmt::format("{}, of them {} beside the level", level.lightmaps.size(), externalLightmaps(level))});
    section(page, "lights", lightLines(report));
    section(page, "textures", textureLines(report));
    section(page, "warnings", s.warnings);
    section(page, "", report.lights.warnings);
    section(page, "time", timeLines(report));
    return page;
}

std::string json(const Report& report) {
    const Level& level = report.level;
    const LoadStatistics& s = level.statistics;
    Json root;
    root["level"] = level.name;
    root["file"] = level.file;
    root["dialect"] = s.dialect;
    for (const auto& [name, count] : s.lumps) root["lumps"][name] = count;
    root["faces"] = {{"polygons", s.polygons}, {"patches", s.patches}, {"models", s.meshes}, {"flares", s.flares}};
    root["drawn"] = {{"triangles", s.drawnTriangles},
                     {"area", s.drawnArea},
                     {"bounds", {array(s.drawnBounds.lower), array(s.drawnBounds.upper)}}};
    root["lightmaps"] = {{"count", level.lightmaps.size()}, {"external", externalLightmaps(level)}};
    Json& lights = root["lights"];
    lights["summary"] = report.lights.summary();
    lights["sources"] = report.lights.sources;
    lights["fallback"] = report.lights.fallback;
    for (const auto& [kind, count] : lightCounts(report.lights)) lights["count"][kind] = count;
    lights["power_watts"] = Json::object();
    for (const auto& [kind, power] : report.powerOfKind) lights["power_watts"][kind] = array(power);
    Json& textures = root["textures"];
    textures["found"] = Json::object();
    for (const pie::level::Texture& texture : level.textures)
        if (!texture.path.empty()) textures["found"][texture.name] = texture.path;
    textures["missing"] = s.missingTextures;
    root["warnings"] = s.warnings;
    for (const std::string& warning : report.lights.warnings) root["warnings"].push_back(warning);
    for (const auto& [stage, milliseconds] : report.times) root["milliseconds"][stage] = milliseconds;
    root["milliseconds"]["total"] = total(report.times);
    // Names in levels need not be UTF-8.
    return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace bspinfo
