#include "apps/pietrade/arguments.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <sstream>

namespace pietrade {
namespace {

struct Raw {
    std::vector<std::string> settings;
    std::string camera, time = "wall";
    std::optional<std::size_t> points, random, frames;
    std::optional<double> target;
};

void describe(CLI::App& app, Arguments& a, Raw& raw) {
    app.footer(
        "Examples:\n"
        "  pietrade maps/mine.bsp\n"
        "  pietrade maps/mine.map --out mine-report --set max_edge=32 --time-limit 20\n"
        "  pietrade --set game=/usr/share/games/openarena/baseoa oa_dm1 --quick\n\n"
        "The folder gets report.html to read, report.json, measurements.csv and reference.csv. Ctrl-C ends it with a\n"
        "report of what there is; the same command again measures what is missing.\n"
        "A setting given by --set holds for everything that is measured, and is not varied.\n"
        "Exit status: 0 all is measured, 1 something cannot be read or written, or the folder is of another level,\n"
        "2 wrong arguments, 3 ended early: the report is there and says what is missing.");
    app.add_option("LEVEL", a.level, "a .bsp or .map (on disk, inside a pk3, or by name with --set game=FOLDER)")
        ->required();
    app.add_option("--out", a.out, "folder of the report; made when missing")->capture_default_str();
    app.add_option("--set", raw.settings, "KEY=VALUE, any setting of the engine (doc/settings.md); may be repeated")
        ->take_all();
    app.add_option("--points", raw.points,
                   "vertices and points of surfaces compared with the reference, each (300; quick: 60)")
        ->check(CLI::Range(2, 1'000'000));
    app.add_option("--random", raw.random,
                   "random settings beside the sweeps; half as many again near the best (24; quick: 6)")
        ->check(CLI::Range(0, 100'000));
    app.add_option("--frames", raw.frames, "frames of photons a setting gets, at most (1000; quick: 24)")
        ->check(CLI::Range(1, 1'000'000));
    app.add_option("--target", raw.target, "standard error of the reference at a point, relative (0.02; quick: 0.05)")
        ->check(CLI::Range(1e-4, 0.5));
    app.add_option("--most-paths", a.mostPaths, "paths of the reference a point, at most")
        ->check(CLI::Range(64, 1 << 26))
        ->capture_default_str();
    app.add_option("--try", a.tried, "\"KEY=VALUE KEY=VALUE\", settings to measure besides; may be repeated")
        ->take_all();
    app.add_flag("--no-sweeps", a.noSweeps, "only the default, what --try names, and --random settings");
    app.add_option("--camera", raw.camera, "\"x y z yaw pitch\", units and degrees (default: first player start)");
    app.add_flag("--everything", a.everything, "draw the whole level, not what a camera sees");
    app.add_option("--time", raw.time, "wall, or processor: of all threads together, for machines that do other things")
        ->check(CLI::IsMember({"wall", "processor"}))
        ->capture_default_str();
    app.add_option("--time-limit", a.minutes, "minutes after which no further setting is begun")
        ->check(CLI::PositiveNumber);
    app.add_flag("--quick", a.quick, "fewer values, points and frames: a first look");
    app.add_flag("--quiet", a.quiet, "errors alone");
}

Camera parseCamera(const std::string& text) {
    std::istringstream stream(text);
    Camera c;
    std::string rest;
    if (!(stream >> c.eye.x >> c.eye.y >> c.eye.z >> c.yaw >> c.pitch) || (stream >> rest))
        throw Stop{fmt::format("--camera \"{}\" is not five numbers: x y z yaw pitch", text), Misused};
    return c;
}

} // namespace

Arguments parseArguments(int argc, const char* const* argv) {
    Arguments a;
    Raw raw;
    CLI::App app{
        "What speed costs in accuracy on a level of your own: measures settings against a path-traced reference "
        "and writes a report."};
    describe(app, a, raw);
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& asked) {
        app.exit(asked);
        throw Stop{"", Done};
    } catch (const CLI::ParseError& error) {
        throw Stop{fmt::format("{} (see --help)", error.what()), Misused};
    }
    for (const std::string& pair : raw.settings)
        if (auto set = a.settings.setPair(pair, pie::engine::Source::CommandLine); !set)
            throw Stop{set.error().message(), Misused};
    for (const std::string& pairs : a.tried) {
        pie::engine::Settings trial = a.settings;
        if (auto set = trial.setOptions(pairs, pie::engine::Source::CommandLine); !set)
            throw Stop{"--try: " + set.error().message(), Misused};
    }
    const auto view = a.settings.view;
    if (view != pie::engine::View::Lit && view != pie::engine::View::Light)
        throw Stop{"view: there is nothing to measure where our light is not shown (use lit or light)", Misused};
    if (!raw.camera.empty()) a.camera = parseCamera(raw.camera);
    if (a.camera && a.everything) throw Stop{"--camera and --everything exclude each other", Misused};
    a.points = raw.points.value_or(a.quick ? 60 : 300);
    a.random = raw.random.value_or(a.quick ? 6 : 24);
    a.mostFrames = raw.frames.value_or(a.quick ? 24 : 1000);
    a.target = raw.target.value_or(a.quick ? 0.05 : 0.02);
    a.processorTime = raw.time == "processor";
    return a;
}

} // namespace pietrade
