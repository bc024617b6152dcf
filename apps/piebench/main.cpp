// piebench: what a frame costs, how true it is, and what the paper's tables look like today.

#include "apps/piebench/frame.h"
#include "apps/piebench/stop.h"
#include "pie/core/parallel.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>
#include <map>
#include <optional>

namespace {

using piebench::Contender;
using piebench::Done;
using piebench::Failed;
using piebench::Misused;
using piebench::Stop;
using piebench::valueOr;

/// What every command takes.
struct Common {
    std::vector<std::string> settings;
    std::optional<std::uint64_t> seed;
    std::optional<int> threads;
    bool json = false;
};

struct Arguments {
    Common common;
    piebench::FrameOptions frame;
    std::string estimator = "gather", tracer = "pie", cache;
    std::vector<std::string> against;
    bool noReference = false;
};

const std::map<std::string, Contender> contenders{{"gather", Contender::Gather},
                                                  {"nearest", Contender::Nearest},
                                                  {"true_area", Contender::TrueArea},
                                                  {"nanoflann", Contender::Nanoflann},
                                                  {"embree", Contender::Embree}};

void describeCommon(CLI::App& command, Common& common) {
    command
        .add_option("--set", common.settings, "KEY=VALUE, any setting of the engine (doc/settings.md); may be repeated")
        ->take_all();
    command.add_option("--seed", common.seed, "same as --set seed=N");
    command.add_option("--threads", common.threads, "same as --set threads=N (default here: 1)");
    command.add_flag("--json", common.json, "print one JSON object");
}

CLI::App* describeFrame(CLI::App& app, Arguments& a) {
    CLI::App* frame = app.add_subcommand("frame", "milliseconds of every stage of a frame, and its error");
    frame->footer(
        "Examples:\n"
        "  piebench frame levels/maps/normal.map\n"
        "  piebench frame ctf_inyard --set game=/usr/share/games/openarena/baseoa --triangles 23181 \\\n"
        "      --against nanoflann --against embree --json\n"
        "  piebench frame levels/maps/small.map --threads 2 --scaling\n\n"
        "A full frame traces all photons anew, a steady one a tenth of them (accumulation of 10 frames); both estimate "
        "at\n"
        "every vertex. Contenders take their turns in the same run; ratios are medians over the turns, of wall clock "
        "and\n"
        "of processor time, which other programs disturb less.\n"
        "All contenders get the photons of the gather: first hits among them in levels of more than 16 lights, else\n"
        "direct light comes by shadow rays. nearest and nanoflann are the paper's estimate, k = 50 nearest over pi r²\n"
        "in a slice, unless --set says otherwise; nanoflann's tree is built anew for each frame.\n"
        "Errors, in parts of one: rms is that of error / (E + 0.1 mean E), rms_99 without the worst hundredth, median\n"
        "that of |error| / E.\n"
        "Exit status: 0 measured, 1 a file cannot be read or written, 2 wrong arguments.");
    frame->add_option("LEVEL", a.frame.level, "a .bsp or .map (on disk, or inside a pk3)")->required();
    frame->add_option("--photons", a.frame.photons, "stored in a full frame, about")
        ->check(CLI::Range(10, 5'000'000))
        ->capture_default_str();
    frame->add_option("--triangles", a.frame.triangles, "refine to so many (default: as a picture is)")
        ->check(CLI::Range(1, 10'000'000));
    frame->add_option("--estimator", a.estimator, "gather, nearest, true_area or nanoflann")
        ->check(CLI::IsMember({"gather", "nearest", "true_area", "nanoflann"}))
        ->capture_default_str();
    frame->add_option("--tracer", a.tracer, "pie, or embree: the same rays by Embree alone, and nothing else")
        ->check(CLI::IsMember({"pie", "embree"}))
        ->capture_default_str();
    frame->add_option("--against", a.against, "gather, nearest, true_area, nanoflann or embree; may be repeated")
        ->check(CLI::IsMember({"gather", "nearest", "true_area", "nanoflann", "embree"}))
        ->take_all();
    frame->add_option("--repeats", a.frame.repeats, "turns of each")
        ->check(CLI::Range(1, 10'000))
        ->capture_default_str();
    frame->add_flag("--scaling", a.frame.scaling, "also --threads threads against one, by turns");
    frame->add_flag("--no-reference", a.noReference, "leave errors out");
    frame->add_option("--sample", a.frame.reference.sample, "vertices that are path traced")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
    frame->add_option("--target", a.frame.reference.target, "relative standard error of each of those")
        ->check(CLI::Range(1e-4, 1.0))
        ->capture_default_str();
    frame->add_option("--most-paths", a.frame.reference.mostPaths, "and paths for each, at most")
        ->capture_default_str();
    frame->add_option("--cache", a.cache,
                      "folder where references are kept (default: piebench in $XDG_CACHE_HOME or ~/.cache)");
    describeCommon(*frame, a.common);
    return frame;
}

pie::engine::Settings settingsOf(const Common& common) {
    pie::engine::Settings settings;
    constexpr auto source = pie::engine::Source::CommandLine;
    for (const std::string& pair : common.settings) valueOr(settings.setPair(pair, source), Misused);
    if (common.seed) valueOr(settings.set("seed", std::to_string(*common.seed), source), Misused);
    if (common.threads) valueOr(settings.set("threads", std::to_string(*common.threads), source), Misused);
    if (settings.origin("threads") == pie::engine::Source::Default) settings.threads = 1;
    pie::setThreads(static_cast<unsigned>(settings.threads));
    return settings;
}

void runFrame(Arguments& a) {
    const pie::engine::Settings settings = settingsOf(a.common);
    a.frame.measured = a.tracer == "embree" ? Contender::Embree : contenders.at(a.estimator);
    for (const std::string& other : a.against) a.frame.against.push_back(contenders.at(other));
    if (a.frame.measured == Contender::Embree && (!a.against.empty() || a.frame.scaling))
        throw Stop{"--tracer embree is measured alone; --against embree compares", Misused};
    a.frame.judged = !a.noReference;
    a.frame.reference.folder = a.cache;
    const piebench::Json report = piebench::measureFrame(a.frame, settings);
    fmt::print("{}", a.common.json ? report.dump(2) + "\n" : piebench::frameText(report));
}

} // namespace

int main(int argc, char** argv) {
    const auto say = [](const std::string& line) { fmt::print(stderr, "piebench: {}\n", line); };
    try {
        Arguments arguments;
        CLI::App app{"What a frame costs and how true it is; the paper's tables, measured again."};
        app.require_subcommand(1);
        const CLI::App* frame = describeFrame(app, arguments);
        try {
            app.parse(argc, argv);
        } catch (const CLI::Success& asked) {
            return app.exit(asked);
        } catch (const CLI::ParseError& error) {
            say(fmt::format("{} (see --help)", error.what()));
            return Misused;
        }
        if (*frame) runFrame(arguments);
        return Done;
    } catch (const Stop& stop) {
        say(stop.message);
        return stop.status;
    } catch (const std::exception& problem) {
        say(problem.what());
        return Failed;
    }
}
