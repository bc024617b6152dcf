// bspinfo: what is in a level, as the viewer sees it.

#include "apps/bspinfo/report.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>

namespace {

struct Arguments {
    std::string level, map, game;
    std::vector<std::string> textures;
    bool json = false;
};

constexpr int unreadable = 1;
constexpr int misused = 2;

void describe(CLI::App& app, Arguments& arguments) {
    app.footer("Examples:\n"
               "  bspinfo ~/games/baseq3/maps/mine.bsp\n"
               "  bspinfo /usr/share/games/openarena/baseoa/pak1-maps.pk3/maps/oa_dm1.bsp\n"
               "  bspinfo --game /usr/share/games/openarena/baseoa --map oa_dm1 --json\n\n"
               "Lengths are in level units, power in watts (1 watt per square unit is one lightmap unit), times in "
               "milliseconds.\n"
               "Exit status: 0 the level was read, 1 it could not be, 2 wrong arguments.");
    app.add_option("LEVEL", arguments.level, "a .bsp or .map on disk, or inside a pk3 (some.pk3/maps/x.bsp)");
    app.add_option("--map", arguments.map, "name of a map in the game directory, instead of LEVEL");
    app.add_option("--game", arguments.game, "game directory (default: the one around the level)");
    app.add_option("--textures", arguments.textures, "more game directories, searched after the level's own");
    app.add_flag("--json", arguments.json, "print one JSON object");
}

int fail(const std::string& message, int status) {
    fmt::print(stderr, "bspinfo: {}\n", message);
    return status;
}

int show(const Arguments& arguments) {
    if (arguments.level.empty() == arguments.map.empty())
        return fail("either a level or --map is needed (see --help)", misused);
    const std::vector<std::filesystem::path> textures(arguments.textures.begin(), arguments.textures.end());
    const auto report =
        bspinfo::inspect(arguments.map.empty() ? arguments.level : arguments.map, arguments.game, textures);
    if (!report) return fail(report.error().message(), unreadable);
    fmt::print("{}", arguments.json ? bspinfo::json(*report) : bspinfo::text(*report));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    try {
        Arguments arguments;
        CLI::App app{
            "What is in a Quake 3 level: dialect, lumps, faces, drawn geometry, lights, textures, loading times."};
        describe(app, arguments);
        try {
            app.parse(argc, argv);
        } catch (const CLI::Success& asked) {
            return app.exit(asked);
        } catch (const CLI::ParseError& error) {
            return fail(fmt::format("{} (see --help)", error.what()), misused);
        }
        return show(arguments);
    } catch (const std::exception& error) {
        return fail(error.what(), unreadable);
    }
}
