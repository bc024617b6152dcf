// piebench: what a frame costs, how true it is, and what the paper's tables look like today.

#include "apps/piebench/frame.h"
#include "apps/piebench/paper.h"
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
    piebench::PaperOptions paper;
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

/// What the three commands about the paper share.
CLI::App* describePaper(CLI::App& app, Arguments& a, const char* name, const char* what, const char* examples) {
    CLI::App* command = app.add_subcommand(name, what);
    command->footer(fmt::format(
        "Examples:\n{}\n\n"
        "The paper's path, k = 50 nearest photons over pi r² and all light from photons, and our gather beside\n"
        "it. Frame rates are those of light alone; the paper's, on a 3 GHz Pentium 4, include drawing.\n"
        "Times are of the processor with one thread, else wall clock; medians.\n"
        "Exit status: 0 measured, 1 a file cannot be read, 2 wrong arguments.",
        examples));
    command->add_option("--seconds", a.paper.seconds, "of every measurement, at least")
        ->check(CLI::Range(0.0, 3600.0))
        ->capture_default_str();
    describeCommon(*command, a.common);
    return command;
}

CLI::App* describeTable61(CLI::App& app, Arguments& a) {
    CLI::App* command =
        describePaper(app, a, "table61", "the paper's table 6.1: frame rate by photons and triangles",
                      "  piebench table61\n  piebench table61 levels/maps/small.map --most 6400 --json");
    command->add_option("LEVEL", a.paper.level, "default: small, of our levels");
    command->add_option("--most", a.paper.most, "leave out cells of more photons or triangles")
        ->check(CLI::Range(400, 25'600))
        ->capture_default_str();
    return command;
}

CLI::App* describeTable62(CLI::App& app, Arguments& a) {
    CLI::App* command =
        describePaper(app, a, "table62", "the paper's table 6.2: frame rate by accumulation frames",
                      "  piebench table62\n  piebench table62 levels/maps/normal.map --triangles 25600 --threads 2");
    command->add_option("LEVEL", a.paper.level, "default: normal, of our levels");
    command->add_option("--photons", a.paper.photons, "kept, over all frames, about")
        ->check(CLI::Range(64, 5'000'000))
        ->capture_default_str();
    command->add_option("--triangles", a.paper.triangles, "refine to so many (default: not refined)")
        ->check(CLI::Range(1, 10'000'000));
    return command;
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

void print(const Common& common, const piebench::Json& report, std::string (*text)(const piebench::Json&)) {
    fmt::print("{}", common.json ? report.dump(2) + "\n" : text(report));
}

void runFrame(Arguments& a) {
    const pie::engine::Settings settings = settingsOf(a.common);
    a.frame.measured = a.tracer == "embree" ? Contender::Embree : contenders.at(a.estimator);
    for (const std::string& other : a.against) a.frame.against.push_back(contenders.at(other));
    if (a.frame.measured == Contender::Embree && (!a.against.empty() || a.frame.scaling))
        throw Stop{"--tracer embree is measured alone; --against embree compares", Misused};
    a.frame.judged = !a.noReference;
    a.frame.reference.folder = a.cache;
    print(a.common, piebench::measureFrame(a.frame, settings), piebench::frameText);
}

} // namespace

int main(int argc, char** argv) {
    const auto say = [](const std::string& line) { fmt::print(stderr, "piebench: {}\n", line); };
    try {
        Arguments arguments;
        CLI::App app{"What a frame costs and how true it is; the paper's tables, measured again."};
        app.require_subcommand(1);
        const CLI::App* frame = describeFrame(app, arguments);
        const CLI::App* table61 = describeTable61(app, arguments);
        const CLI::App* table62 = describeTable62(app, arguments);
        const CLI::App* statements = describePaper(
            app, arguments, "statements", "what the paper says of its parameters, each with what is measured here",
            "  piebench statements\n  piebench statements --seconds 1 --json");
        try {
            app.parse(argc, argv);
        } catch (const CLI::Success& asked) {
            return app.exit(asked);
        } catch (const CLI::ParseError& error) {
            say(fmt::format("{} (see --help)", error.what()));
            return Misused;
        }
        if (*frame) return runFrame(arguments), Done;
        const pie::engine::Settings settings = settingsOf(arguments.common);
        if (*table61) print(arguments.common, piebench::table61(arguments.paper, settings), piebench::table61Text);
        if (*table62) print(arguments.common, piebench::table62(arguments.paper, settings), piebench::table62Text);
        if (*statements)
            print(arguments.common, piebench::statements(arguments.paper, settings), piebench::statementsText);
        return Done;
    } catch (const Stop& stop) {
        say(stop.message);
        return stop.status;
    } catch (const std::exception& problem) {
        say(problem.what());
        return Failed;
    }
}
