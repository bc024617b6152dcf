#include "apps/pieview/arguments.h"

#include "apps/support/picture_file.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>

namespace pieview {
namespace {

using pie::engine::Source;

bool endsInLevel(std::string name) {
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return name.ends_with(".bsp") || name.ends_with(".map");
}

int wrong(const std::string& message) {
    fmt::print(stderr, "pieview: {}\n", message);
    return 2;
}

std::optional<std::string> readSize(const std::string& size, Arguments& arguments) {
    int used = 0;
    constexpr int least = 16;
    constexpr int most = 8192;
    if (std::sscanf(size.c_str(), "%dx%d%n", &arguments.width, &arguments.height, &used) != 2 ||
        static_cast<std::size_t>(used) != size.size() || std::min(arguments.width, arguments.height) < least ||
        std::max(arguments.width, arguments.height) > most)
        return fmt::format("--size {}: expected WIDTHxHEIGHT, {} to {} pixels each", size, least, most);
    return std::nullopt;
}

} // namespace

std::variant<Arguments, int> readArguments(int argc, const char* const* argv) {
    Arguments arguments;
    std::string game, map, camera, mode, size, statistics;
    std::vector<std::string> settings;
    CLI::App app{"A Quake 3 level lit by photons, in a window that follows every save.\n\n"
                 "  pieview maps/mine.map\n"
                 "  pieview --game baseoa --map oa_dm1 --set preset=balanced\n"
                 "  pieview maps/mine.map --screenshot out.png --mode split\n\n"
                 "In the window, ? shows all keys."};
    app.add_option("LEVEL", arguments.level, "a .bsp or .map, on disk or inside a pk3");
    app.add_option("--game", game, "game directory (with *.pk3 or maps/)");
    app.add_option("--map", map, "name of a map in the game directory, in place of LEVEL");
    app.add_option("--set", settings, "key=value, any setting of doc/settings.md; may be repeated")
        ->take_all()
        ->allow_extra_args(false);
    app.add_option("--camera", camera,
                   "\"x y z yaw pitch\" in units and degrees, pitch positive downwards (default: a player start)");
    app.add_option("--mode", mode, "what is shown, a value of the setting view");
    app.add_option("--size", size, "WIDTHxHEIGHT of window or picture (1280x800)");
    app.add_option("--fov", arguments.fieldOfView, "horizontal field of view, degrees")
        ->check(CLI::Range(1.0, 170.0))
        ->capture_default_str();
    app.add_option("--screenshot", arguments.screenshot, "a picture, .png or .exr, instead of a window");
    app.add_option("--frames", arguments.frames, "with --screenshot: so many frames (default: until light is settled)")
        ->check(CLI::Range(1, 1'000'000));
    app.add_option("--path", arguments.pathPictures,
                   "with --screenshot: so many pictures along the path recorded in the window, OUT-0001.png and on")
        ->check(CLI::Range(2, 100'000));
    app.add_option("--stats", statistics, "statistics on standard output instead of a window")
        ->check(CLI::IsMember({"json"}));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    arguments.statistics = !statistics.empty();
    if (arguments.level.empty() == map.empty()) return wrong("one level is needed, or --map NAME; see --help");
    if (!map.empty()) {
        if (game.empty()) return wrong("--map needs --game DIR");
        arguments.level = endsInLevel(map) ? map : map + ".bsp";
    }
    if (!endsInLevel(arguments.level))
        return wrong(fmt::format("{}: no level; .bsp and .map files are, on disk or inside a pk3", arguments.level));
    for (const std::string& pair : settings)
        if (const auto set = arguments.settings.setPair(pair, Source::CommandLine); !set)
            return wrong("--set " + set.error().message());
    if (!game.empty())
        if (const auto set = arguments.settings.set("game", game, Source::CommandLine); !set)
            return wrong(set.error().message());
    if (!mode.empty())
        if (const auto set = arguments.settings.set("view", mode, Source::CommandLine); !set)
            return wrong("--mode: " + set.error().message());
    if (!camera.empty()) {
        arguments.camera = apps::parseCamera(camera);
        if (!arguments.camera) return wrong(fmt::format(R"(--camera "{}": expected "x y z yaw pitch")", camera));
    }
    if (!size.empty())
        if (const auto problem = readSize(size, arguments)) return wrong(*problem);
    if (!arguments.screenshot.empty() && !apps::isPictureName(arguments.screenshot))
        return wrong(arguments.screenshot + ": the picture's name must end in .png or .exr");
    if (arguments.screenshot.empty() && (arguments.pathPictures > 0 || arguments.frames))
        if (!arguments.statistics || arguments.pathPictures > 0)
            return wrong("--frames and --path go with --screenshot");
    for (const std::string& warning : arguments.settings.warnings()) fmt::print(stderr, "pieview: {}\n", warning);
    return arguments;
}

} // namespace pieview
