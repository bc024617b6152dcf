#include "apps/piebench/machine.h"
#include "apps/piebench/paper.h"
#include "apps/piebench/stop.h"
#include "pie/core/clock.h"
#include "pie/core/parallel.h"
#include "pie/engine/options.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

namespace piebench {
namespace {

using pie::engine::Settings;

constexpr std::size_t sizes = 7;
constexpr std::array<std::size_t, sizes> columns{400, 800, 1600, 3200, 6400, 12'800, 25'600}; // photons; also triangles
/// Table 6.1: frames a second, a row per number of triangles.
constexpr std::array<std::array<int, sizes>, sizes> paper61{{{460, 298, 179, 101, 52, 26, 12},
                                                             {344, 243, 156, 90, 49, 25, 12},
                                                             {225, 172, 124, 78, 45, 24, 11},
                                                             {124, 105, 83, 58, 37, 21, 10},
                                                             {63, 56, 49, 38, 27, 17, 9},
                                                             {30, 28, 26, 22, 17, 12, 8},
                                                             {15, 14, 13, 11, 10, 8, 5}}};
constexpr std::size_t accumulated61 = 10;

/// Table 6.2: accumulation frames, frames a second, seconds until all photons are new.
struct Row62 {
    std::size_t frames;
    double rate, renewal;
};
constexpr std::array<Row62, 7> paper62{{{1, 0.63, 1.59},
                                        {2, 1.24, 1.61},
                                        {4, 2.41, 1.66},
                                        {8, 4.52, 1.77},
                                        {16, 8.25, 1.94},
                                        {32, 12.51, 2.56},
                                        {64, 18.01, 3.56}}};

constexpr std::array<Estimator, 2> measured{Estimator::Nearest, Estimator::Gather};

/// Slope of log y over log x, least squares.
double exponent(const std::vector<std::pair<double, double>>& points) {
    double x = 0;
    double y = 0;
    for (const auto& [a, b] : points) {
        x += std::log(a) / static_cast<double>(points.size());
        y += std::log(b) / static_cast<double>(points.size());
    }
    double xy = 0;
    double xx = 0;
    for (const auto& [a, b] : points) {
        xy += (std::log(a) - x) * (std::log(b) - y);
        xx += (std::log(a) - x) * (std::log(a) - x);
    }
    return xx > 0 ? xy / xx : 0;
}

Json head(const char* command, const std::string& level, const Settings& settings) {
    Json report{{"program", "piebench"}, {"command", command}, {"level", level}, {"machine", machineJson()}};
    report["threads"] = pie::threads();
    report["time"] = pie::threads() == 1 ? "processor" : "wall clock";
    report["settings"] = Json::array();
    for (const std::string& line : settings.effective()) report["settings"].push_back(line);
    return report;
}

void show(const char* what, std::size_t done, std::size_t all) {
    if (isatty(STDERR_FILENO) != 0)
        fmt::print(stderr, "\rpiebench: {}, {} of {}{}", what, done, all, done == all ? "\n" : "");
}

void headText(fmt::memory_buffer& text, const Json& report) {
    const Json& machine = report["machine"];
    fmt::format_to(std::back_inserter(text),
                   "{}; {}, {} cores, {} thread(s), {} time, load {:.2f} before and {:.2f} after\n",
                   report["level"].get<std::string>(), machine["processor"].get<std::string>(),
                   number(machine["cores"]), number(report["threads"]), report["time"].get<std::string>(),
                   number(machine["load"][0]), number(report["load_after"][0]));
}

} // namespace

Settings paperSettings(const Settings& settings) {
    Settings own = settings;
    // Closing T-junctions would add a third to the triangles of the small level.
    if (settings.origin("t_junction_tolerance") == pie::engine::Source::Default) own.tJunctionTolerance = 0;
    if (settings.origin("direct_light") == pie::engine::Source::Default)
        own.directLight = pie::engine::DirectLight::Photons;
    return settingsFor(Estimator::Nearest, own);
}

std::unique_ptr<Frames> pacedFrames(Estimator estimator, const Subject& subject, const Settings& settings,
                                    std::uint64_t photons, std::size_t accumulation) {
    const Settings own = estimator == Estimator::Gather ? settingsFor(estimator, settings) : paperSettings(settings);
    const pie::lights::LightSet lights(subject.of->lights, subject.of->scene);
    const pie::photons::TracerOptions tracing = pie::engine::tracerOptions(own, lights);
    const PhotonCount count = valueOr(photonsFor(photons, accumulation, *subject.of, tracing));
    return makeFrames(estimator, subject, own, tracing, {count.emitted / accumulation, accumulation});
}

Stages paced(Frames& frames, std::size_t accumulation, double seconds) {
    constexpr std::size_t least = 5;
    for (std::size_t i = 0; i < accumulation; ++i) frames.next();
    std::vector<Stages> all;
    const auto start = pie::Clock::now();
    while (all.size() < least || pie::millisecondsSince(start) < 1e3 * seconds) all.push_back(frames.next());
    Stages result;
    for (double Stages::*stage :
         {&Stages::trace, &Stages::build, &Stages::estimate, &Stages::upload, &Stages::total, &Stages::processor}) {
        std::vector<double> values;
        for (const Stages& one : all) values.push_back(one.*stage);
        result.*stage = median(std::move(values));
    }
    return result;
}

double frameMs(const Stages& stages) { return pie::threads() == 1 ? stages.processor : stages.total; }

Json table61(const PaperOptions& options, const Settings& settings) {
    const Settings paper = paperSettings(settings);
    const LoadedLevel level = valueOr(load(options.level.empty() ? bundledLevel("small") : options.level, paper));
    Json report = head("table61", level.name, settings);
    report["accumulation_frames"] = accumulated61;
    Json cells = Json::array();
    std::array<std::vector<std::pair<double, double>>, measured.size()> ours;
    std::vector<std::pair<double, double>> theirs;
    const auto within = static_cast<std::size_t>(
        std::count_if(columns.begin(), columns.end(), [&](std::size_t size) { return size <= options.most; }));
    for (std::size_t row = 0; row < within; ++row) {
        const Subject subject = valueOr(refined(level, columns[row], paper), Misused);
        for (std::size_t column = 0; column < within; ++column) {
            show("table 6.1", cells.size(), within * within);
            const int rate = paper61[row][column];
            Json cell{{"triangles", subject.triangles},
                      {"receivers", subject.receivers.points.size()},
                      {"photons", columns[column]},
                      {"paper_fps", rate}};
            theirs.emplace_back(columns[row] + columns[column], 1.0 / rate);
            for (std::size_t i = 0; i < measured.size(); ++i) {
                const auto frames = pacedFrames(measured[i], subject, settings, columns[column], accumulated61);
                const double milliseconds = frameMs(paced(*frames, accumulated61, options.seconds));
                const std::string which(name(measured[i]));
                cell[which + "_ms"] = rounded(milliseconds);
                cell[which + "_fps"] = rounded(1e3 / milliseconds);
                ours[i].emplace_back(subject.receivers.points.size() + columns[column], milliseconds);
            }
            cells.push_back(std::move(cell));
        }
    }
    show("table 6.1", cells.size(), within * within);
    report["cells"] = std::move(cells);
    report["exponents"] = {{"paper", rounded(exponent(theirs))}};
    report["targets"] = Json::array();
    for (std::size_t i = 0; i < measured.size(); ++i) {
        const double found = rounded(exponent(ours[i]));
        report["exponents"][std::string(name(measured[i]))] = found;
        report["targets"].push_back({{"what", fmt::format("exponent of {}", name(measured[i]))},
                                     {"value", found},
                                     {"at_most", 1.05},
                                     {"met", found <= 1.05}});
    }
    report["load_after"] = load();
    return report;
}

std::string table61Text(const Json& report) {
    fmt::memory_buffer text;
    const auto to = std::back_inserter(text);
    headText(text, report);
    fmt::format_to(to,
                   "Frames a second, {} accumulation frames: the paper's, nearest, gather\n\n| triangles \\ photons |",
                   number(report["accumulation_frames"]));
    const Json& cells = report["cells"];
    for (const Json& cell : cells)
        if (cell["triangles"] == cells[0]["triangles"]) fmt::format_to(to, " {} |", number(cell["photons"]));
    fmt::format_to(to, "\n|---|");
    for (const Json& cell : cells)
        if (cell["triangles"] == cells[0]["triangles"]) fmt::format_to(to, "---|");
    Json last;
    for (const Json& cell : cells) {
        if (cell["triangles"] != last) fmt::format_to(to, "\n| {} |", number(cell["triangles"]));
        last = cell["triangles"];
        fmt::format_to(to, " {}, {:.0f}, {:.0f} |", number(cell["paper_fps"]), number(cell["nearest_fps"]),
                       number(cell["gather_fps"]));
    }
    fmt::format_to(to, "\n\nTime of a frame grows with photons + receivers to the power of:");
    for (const auto& [which, value] : report["exponents"].items())
        fmt::format_to(to, " {} {:.2f}", which, number(value));
    fmt::format_to(to, " (the paper's: with photons + triangles); wanted at most 1.05\n");
    return fmt::to_string(text);
}

Json table62(const PaperOptions& options, const Settings& settings) {
    const Settings paper = paperSettings(settings);
    const LoadedLevel level = valueOr(load(options.level.empty() ? bundledLevel("normal") : options.level, paper));
    const Subject subject = valueOr(
        refined(level, options.triangles == 0 ? level.mesh.triangles.size() : options.triangles, paper), Misused);
    Json report = head("table62", level.name, settings);
    report["triangles"] = subject.triangles;
    report["receivers"] = subject.receivers.points.size();
    report["photons"] = options.photons;
    Json rows = Json::array();
    for (const Row62& row : paper62) {
        show("table 6.2", rows.size(), paper62.size());
        Json one{{"accumulation_frames", row.frames}, {"paper_fps", row.rate}, {"paper_renewal_s", row.renewal}};
        for (const Estimator estimator : measured) {
            const auto frames = pacedFrames(estimator, subject, settings, options.photons, row.frames);
            const double milliseconds = frameMs(paced(*frames, row.frames, options.seconds));
            const std::string which(name(estimator));
            one[which + "_fps"] = rounded(1e3 / milliseconds);
            one[which + "_renewal_s"] = rounded(1e-3 * milliseconds * static_cast<double>(row.frames));
        }
        rows.push_back(std::move(one));
    }
    show("table 6.2", rows.size(), paper62.size());
    report["rows"] = std::move(rows);
    report["load_after"] = load();
    return report;
}

std::string table62Text(const Json& report) {
    fmt::memory_buffer text;
    const auto to = std::back_inserter(text);
    headText(text, report);
    fmt::format_to(
        to,
        "{} photons in all, {} triangles, {} receivers\n\n| accumulation frames | paper, frames a second | "
        "nearest | gather | paper, seconds to renew all photons | nearest | gather |\n|---|---|---|---|---|---|---|\n",
        number(report["photons"]), number(report["triangles"]), number(report["receivers"]));
    for (const Json& row : report["rows"])
        fmt::format_to(to, "| {} | {} | {:.0f} | {:.0f} | {} | {:.3g} | {:.3g} |\n", number(row["accumulation_frames"]),
                       number(row["paper_fps"]), number(row["nearest_fps"]), number(row["gather_fps"]),
                       number(row["paper_renewal_s"]), number(row["nearest_renewal_s"]),
                       number(row["gather_renewal_s"]));
    return fmt::to_string(text);
}

} // namespace piebench
