// pieprobe: irradiance at given points of a level or an .obj, by the engine or by the reference path tracer.

#include "apps/pieprobe/light_option.h"
#include "apps/pieprobe/obj.h"
#include "apps/pieprobe/points.h"
#include "apps/pieprobe/sample.h"
#include "apps/pieprobe/surface.h"
#include "pie/brushes/load.h"
#include "pie/core/parallel.h"
#include "pie/engine/options.h"
#include "pie/engine/transport.h"
#include "pie/gather/texels.h"
#include "pie/reference/path_tracer.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;
using pieprobe::Answer;
using pieprobe::Placed;
using pieprobe::Points;
using pieprobe::Status;

enum Exit : int { Done = 0, Failed = 1, Misused = 2, Incomplete = 3 };

struct Arguments {
    std::string scene, points, out;
    std::vector<std::string> settings, lights;
    std::optional<int> frames;
    std::optional<std::uint64_t> seed;
    std::optional<int> threads;
    std::optional<std::size_t> sample;
    std::optional<double> tolerance;
    bool noLevelLights = false, twoSided = false, time = false, reference = false, quiet = false;
    double target = 0.003;
    std::uint64_t mostPaths = 1 << 20;
};

void describe(CLI::App& app, Arguments& a) {
    app.footer(
        "Examples:\n"
        "  pieprobe maps/mine.bsp points.csv out.csv --frames 50\n"
        "  pieprobe maps/mine.bsp points.csv out.csv --sample 300\n"
        "  pieprobe box.obj points.csv out.csv --light \"point 278 500 279.6 100 100 100\"\n"
        "  pieprobe box.obj points.csv truth.csv --light \"…\" --reference --target 0.003\n\n" +
        pieprobe::lightHelp() +
        "\nPOINTS names its columns in the first line, x,y,z,nx,ny,nz in any order. OUT repeats them and adds\n"
        "  Er,Eg,Eb   irradiance, watts per square unit\n"
        "  stderr     standard error of the mean channel: noise alone\n"
        "  photons    that the estimate rests on; with --reference, paths\n"
        "  radius     units: of the search, or of the surface that stands for a hit\n"
        "  bias       how far the mean channel may be off besides, where that is known\n"
        "  status     ok, off_surface, bad_normal, not_finite (no values), target_not_reached (--reference)\n"
        "Unless --set says otherwise: gather_rays=1024, direct_tolerance=0.02, texel_size at most 32 in levels,\n"
        "standard_errors=true: slower and truer than what is drawn.\n"
        "In an .obj, Kd is the reflectance, fronts are counter-clockwise, materials named sky… are sky surfaces.\n"
        "Exit status: 0 all points answered, 1 nothing written: a file cannot be read or written, 2 wrong arguments,\n"
        "3 written, but some points have a status other than ok (reported one a line).");
    app.add_option("SCENE", a.scene, "a .bsp or .map (on disk, or inside a pk3), or a Wavefront .obj")->required();
    app.add_option("POINTS", a.points, "CSV file of points and normals; written first with --sample")->required();
    app.add_option("OUT", a.out, "CSV file to write; appears whole or not at all")->required();
    app.add_option("--sample", a.sample, "write POINTS first: so many random points, spread over all surfaces")
        ->check(CLI::Range(1, 10'000'000));
    app.add_option("--light", a.lights, "add a light, see below; may be repeated")->take_all();
    app.add_flag("--no-level-lights", a.noLevelLights, "leave out the lights of the level");
    app.add_flag("--two-sided", a.twoSided, "surfaces of an .obj reflect and receive on both sides");
    app.add_option("--set", a.settings, "KEY=VALUE, any setting of the engine (doc/settings.md); may be repeated")
        ->take_all();
    app.add_option("--frames", a.frames,
                   "frames of photons (default: still_frames, accumulation_frames where photons are kept)")
        ->check(CLI::Range(1, 1'000'000));
    app.add_option("--seed", a.seed, "same as --set seed=N");
    app.add_option("--threads", a.threads, "same as --set threads=N; changes nothing but time");
    app.add_option("--tolerance", a.tolerance,
                   "how far from its surface a point may lie, units (default: a 512th of the scene, 2 at most)")
        ->check(CLI::NonNegativeNumber);
    app.add_flag("--time", a.time, "print milliseconds by stage, as JSON");
    app.add_flag("--reference", a.reference, "by path tracing, unbiased, instead of the engine");
    app.add_option("--target", a.target, "reference: standard error of a point, relative to its light")
        ->check(CLI::Range(1e-6, 1.0))
        ->capture_default_str();
    app.add_option("--most-paths", a.mostPaths, "reference: paths a point, at most")->capture_default_str();
    app.add_flag("--quiet", a.quiet, "no lines about lights and the scene");
}

/// Wall clock by stage.
class Watch {
public:
    void stage(const char* name) {
        const auto now = Clock::now();
        stages_.emplace_back(name, std::chrono::duration<double, std::milli>(now - last_).count());
        last_ = now;
    }
    [[nodiscard]] std::string json() const {
        std::string text = "{";
        double total = 0;
        for (const auto& [name, milliseconds] : stages_) {
            text += fmt::format("\"{}\":{:.3f},", name, milliseconds);
            total += milliseconds;
        }
        return text + fmt::format("\"total\":{:.3f}}}", total);
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point last_ = Clock::now();
    std::vector<std::pair<std::string, double>> stages_;
};

struct Lit {
    std::shared_ptr<const pie::scene::Scene> scene;
    std::vector<pie::lights::Light> lights;
    pie::level::Tree tree;
};

struct Stop {
    std::string message;
    Exit status = Failed;
};

void say(const std::string& line) { fmt::print(stderr, "pieprobe: {}\n", line); }

/// The first few.
void sayFirst(const std::vector<std::string>& lines, std::string_view whereAllAre) {
    constexpr std::size_t few = 5;
    for (std::size_t i = 0; i < std::min(few, lines.size()); ++i) say(lines[i]);
    if (lines.size() > few) say(fmt::format("and {} more; {}", lines.size() - few, whereAllAre));
}

template <class T> T valueOr(pie::Result<T> result, Exit status) {
    if (!result) throw Stop{result.error().message(), status};
    return std::move(*result);
}

pie::engine::Settings settingsOf(const Arguments& a) {
    pie::engine::Settings settings;
    constexpr auto source = pie::engine::Source::CommandLine;
    for (const std::string& pair : a.settings) valueOr(settings.setPair(pair, source), Misused);
    if (a.seed) valueOr(settings.set("seed", std::to_string(*a.seed), source), Misused);
    if (a.threads) valueOr(settings.set("threads", std::to_string(*a.threads), source), Misused);
    // Frames that the map forgets again would be traced in vain.
    if (a.frames && settings.origin("accumulation_frames") == pie::engine::Source::Default)
        valueOr(settings.set("accumulation_frames", std::to_string(*a.frames), source), Misused);
    if (a.frames && settings.origin("still_frames") == pie::engine::Source::Default)
        valueOr(settings.set("still_frames", std::to_string(*a.frames), pie::engine::Source::Level), Misused);
    // Numbers are wanted truer than pictures. Below a command line, whoever sets these there.
    for (const char* pair : {"standard_errors=true", "gather_rays=1024", "direct_tolerance=0.02"})
        valueOr(settings.setPair(pair, pie::engine::Source::Level), Misused);
    return settings;
}

/// In scenes as large as a level texels half as large as for pictures.
void sizeTexels(pie::engine::Settings& settings, const pie::scene::Scene& scene) {
    constexpr float largest = 32;
    if (settings.origin("texel_size") == pie::engine::Source::Default &&
        pie::gather::SurfaceTexels::automaticEdge(scene) > largest)
        settings.texelSize = largest;
}

Lit readScene(const Arguments& a, const pie::engine::Settings& settings) {
    Lit lit;
    std::string extension = fs::path(a.scene).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (extension == ".obj") {
        auto obj = valueOr(pieprobe::readObj(a.scene, {settings.maxReflectance, a.twoSided}), Failed);
        if (!a.quiet)
            for (const std::string& warning : obj.warnings) say(a.scene + ": " + warning);
        lit.scene = std::make_shared<const pie::scene::Scene>(std::move(obj.scene));
        return lit;
    }
    if (a.twoSided) throw Stop{"--two-sided is for .obj files: a level's shaders say which surfaces are", Misused};
    const std::vector<fs::path> folders(settings.textures.begin(), settings.textures.end());
    auto location = valueOr(pie::level::locate(a.scene, settings.game, folders), Failed);
    pie::level::LoadOptions options;
    options.patchTolerance = settings.patchTolerance;
    auto level = valueOr(pie::brushes::loadLevel(std::move(location), options), Failed);
    if (!a.quiet) sayFirst(level.statistics.warnings, "bspinfo lists them");
    lit.scene =
        std::make_shared<const pie::scene::Scene>(pie::scene::makeScene(level, pie::engine::sceneOptions(settings)));
    lit.tree = std::move(level.tree);
    if (a.noLevelLights) return lit;
    auto imported = pie::lights::importLights(level, *lit.scene, pie::engine::importOptions(settings));
    // The stand-in for missing light is for looking at levels, not beside lights that were asked for.
    if (imported.fallback && !a.lights.empty()) return lit;
    if (!a.quiet) {
        for (const std::string& warning : imported.warnings) say("light: " + warning);
        say("light of the level: " + imported.summary());
    }
    lit.lights = std::move(imported.lights);
    return lit;
}

/// Answers of the engine, for receivers in order.
std::vector<Answer> byEngine(const Arguments& a, const pie::engine::Settings& settings, const Lit& lit,
                             const pie::scene::Receivers& receivers, Watch& watch, std::string& statistics) {
    pie::engine::Transport transport(pie::engine::makeSurroundings(lit.scene, lit.tree, settings), lit.lights, lit.tree,
                                     receivers, settings);
    watch.stage("prepare");
    std::vector<std::uint32_t> which(receivers.points.size());
    std::iota(which.begin(), which.end(), 0U);
    transport.finish(which);
    watch.stage("gather");
    for (int frame = 0; frame < a.frames.value_or(std::numeric_limits<int>::max()) && transport.advance(); ++frame) {}
    watch.stage("trace");
    std::vector<pie::Rgb> irradiance(which.size());
    transport.irradiance(which, irradiance);
    watch.stage("irradiance");
    std::vector<pie::gather::Estimate> estimates(which.size());
    transport.explain(which, estimates);
    watch.stage("explain");
    statistics = transport.statistics().json();
    std::vector<Answer> answers(which.size());
    for (std::size_t i = 0; i < which.size(); ++i) {
        const pie::gather::Estimate& e = estimates[i];
        answers[i] = {Status::Ok, true, {}, double{e.standardError}, double{e.bias}, e.photons, double{e.radius}};
        for (int c = 0; c < 3; ++c) answers[i].irradiance[c] = double{irradiance[i][c]};
    }
    return answers;
}

std::vector<Answer> byReference(const Arguments& a, const pie::engine::Settings& settings, const Lit& lit,
                                const pie::scene::Receivers& receivers, Watch& watch) {
    const auto intersector = pie::intersect::makeIntersector(settings.intersector, *lit.scene, lit.tree);
    pie::reference::Options options;
    options.target = a.target;
    options.mostPaths = a.mostPaths;
    options.seed = settings.seed;
    if (settings.origin("recursion_depth") != pie::engine::Source::Default)
        options.recursionDepth = static_cast<std::uint32_t>(settings.recursionDepth);
    const pie::reference::PathTracer tracer(lit.scene, lit.lights, *intersector, options);
    watch.stage("prepare");
    std::vector<pie::reference::Value> values(receivers.points.size());
    const bool shown = isatty(STDERR_FILENO) != 0 && !a.quiet;
    tracer.trace(receivers.points, values, [&](std::size_t count) {
        if (shown) fmt::print(stderr, "\rpieprobe: {} of {} points", count, values.size());
    });
    if (shown) fmt::print(stderr, "\n");
    watch.stage("trace");
    std::vector<Answer> answers;
    answers.reserve(values.size());
    for (const pie::reference::Value& v : values)
        answers.push_back({v.reached ? Status::Ok : Status::TargetNotReached,
                           true,
                           {v.irradiance.x, v.irradiance.y, v.irradiance.z},
                           v.meanError,
                           0.0,
                           v.paths,
                           0.0});
    return answers;
}

Exit probe(const Arguments& a) {
    Watch watch;
    pie::engine::Settings settings = settingsOf(a);
    pie::setThreads(static_cast<unsigned>(settings.threads));
    if (!a.quiet)
        for (const std::string& warning : settings.warnings()) say(warning);
    std::vector<pie::lights::Light> added;
    for (const std::string& text : a.lights) added.push_back(valueOr(pieprobe::parseLight(text), Misused));
    pieprobe::OutFile out;
    pieprobe::OutFile drawn;
    Points points;
    if (a.sample) {
        if (const auto problem = drawn.open(a.points)) throw Stop{problem->message(), Failed};
    } else {
        points = valueOr(pieprobe::readPoints(a.points), Failed);
    }
    for (const std::string& column : points.ignored)
        if (!a.quiet) say(fmt::format("{}: column \"{}\" is not used", a.points, column));
    if (const auto problem = out.open(a.out)) throw Stop{problem->message(), Failed};
    Lit lit = readScene(a, settings);
    if (a.sample) {
        if (const auto problem = drawn.write(pieprobe::randomPoints(*lit.scene, *a.sample, settings.seed)))
            throw Stop{problem->message(), Failed};
        points = valueOr(pieprobe::readPoints(a.points), Failed);
    }
    for (pie::lights::Light& light : added) {
        if (std::holds_alternative<pie::lights::SunLight>(light) && !lit.scene->has(pie::scene::Interaction::Sky))
            say("a sun shines through sky surfaces, and the scene has none: it lights nothing");
        lit.lights.push_back(std::move(light));
    }
    if (lit.lights.empty()) say("there is no light, so all is dark (see --light)");
    sizeTexels(settings, *lit.scene);
    watch.stage("load");

    const std::vector<Placed> placed =
        pieprobe::place(*lit.scene, points.points, a.tolerance.value_or(pieprobe::defaultTolerance(*lit.scene)),
                        pieprobe::insetFor(*lit.scene, a.reference));
    pie::scene::Receivers receivers;
    std::vector<std::size_t> of;
    std::vector<Answer> answers(placed.size());
    for (std::size_t i = 0; i < placed.size(); ++i) {
        answers[i].status = placed[i].status;
        if (placed[i].status == Status::Ok) {
            of.push_back(i);
            receivers.points.push_back(placed[i].receiver);
        } else {
            say(fmt::format("{}: line {}: {}", a.points, points.points[i].line, placed[i].problem));
        }
    }
    watch.stage("points");
    std::string statistics;
    const std::vector<Answer> found = a.reference ? byReference(a, settings, lit, receivers, watch)
                                                  : byEngine(a, settings, lit, receivers, watch, statistics);
    for (std::size_t i = 0; i < of.size(); ++i) {
        answers[of[i]] = found[i];
        if (found[i].status == Status::TargetNotReached)
            say(fmt::format("{}: line {}: standard error {:.3g} of {:.3g} after {} paths", a.points,
                            points.points[of[i]].line, found[i].standardError,
                            (found[i].irradiance[0] + found[i].irradiance[1] + found[i].irradiance[2]) / 3,
                            found[i].photons));
    }
    if (const auto problem = out.write(pieprobe::outText(points.points, answers)))
        throw Stop{problem->message(), Failed};
    watch.stage("write");
    if (a.time)
        fmt::print("{{\"points\":{},\"threads\":{},\"milliseconds\":{}{}}}\n", answers.size(), pie::threads(),
                   watch.json(), statistics.empty() ? "" : ",\"engine\":" + statistics);
    const auto all = static_cast<std::size_t>(std::count_if(
        answers.begin(), answers.end(), [](const Answer& answer) { return answer.status == Status::Ok; }));
    return all == answers.size() ? Done : Incomplete;
}

} // namespace

int main(int argc, char** argv) {
    try {
        Arguments arguments;
        CLI::App app{"Irradiance at points of a level or an .obj, in watts per square unit, with a standard error."};
        describe(app, arguments);
        try {
            app.parse(argc, argv);
        } catch (const CLI::Success& asked) {
            return app.exit(asked);
        } catch (const CLI::ParseError& error) {
            say(fmt::format("{} (see --help)", error.what()));
            return Misused;
        }
        return probe(arguments);
    } catch (const Stop& stop) {
        say(stop.message);
        return stop.status;
    } catch (const std::exception& problem) {
        say(problem.what());
        return Failed;
    }
}
