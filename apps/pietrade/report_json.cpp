#include "apps/pietrade/report.h"

#include <nlohmann/json.hpp>

#include <cmath>

namespace pietrade {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json entry(const Findings& found, const Measurement& m) {
    Json json{
        {"settings", m.settings}, {"stage", m.stage}, {"options", options(found, m)}, {"command", command(found, m)}};
    for (const Column& column : columns()) json[std::string(column.name)] = number(m.*column.value);
    return json;
}

Json choices(const Findings& found, const std::vector<Advice>& all) {
    Json list = Json::array();
    for (const auto& [limit, choice] : all)
        list.push_back({{"limit", limit}, {"settings", choice ? Json(found.measurements[*choice].settings) : Json()}});
    return list;
}

Json names(const Findings& found, const std::vector<std::size_t>& which) {
    Json list = Json::array();
    for (const std::size_t i : which) list.push_back(found.measurements[i].settings);
    return list;
}

} // namespace

std::string reportJson(const Findings& found, const Analysis& analysis) {
    Json identity;
    for (const auto& [name, value] : found.identity) identity[name] = value;
    Json measurements = Json::array();
    for (const Measurement& m : found.measurements) measurements.push_back(entry(found, m));
    Json sweeps = Json::array();
    for (const Sweep& s : found.sweeps)
        sweeps.push_back({{"key", s.key}, {"with", s.with}, {"values", s.values}, {"settings", s.settings}});
    const Json report{{"complete", found.complete},
                      {"planned", found.planned},
                      {"why", found.why},
                      {"made_of", identity},
                      {"level", found.level},
                      {"lights", found.lights},
                      {"load_ms", number(found.loadMs)},
                      {"points", found.points},
                      {"vertices", found.vertices},
                      {"reference_stderr", number(found.truthDeviation)},
                      {"measurements", measurements},
                      {"sweeps", sweeps},
                      {"front_frame", names(found, analysis.frames)},
                      {"front_picture", names(found, analysis.pictures)},
                      {"near", analysis.near},
                      {"by_frame_ms", choices(found, analysis.byFrame)},
                      {"by_error", choices(found, analysis.byError)},
                      {"advice", advice(found, analysis)}};
    return report.dump(1) + '\n';
}

} // namespace pietrade
