// maplevel: compiles the .map text of a level editor into a .bsp of version 46, without light.

#include "pie/brushes/compile.h"
#include "pie/core/whole_file.h"
#include "pie/level/names.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

constexpr int failed = 1;
constexpr int misused = 2;

struct Arguments {
    std::string map, bsp, game;
    std::vector<std::string> textures;
    bool quiet = false;
};

void describe(CLI::App& app, Arguments& arguments) {
    app.footer(
        "Examples:\n"
        "  maplevel maps/mine.map\n"
        "  maplevel mine.map build/mine.bsp --game ~/quake3/baseq3\n\n"
        "Lights stay in the entities, every leaf sees every other, there are no lightmaps. Where the level leaks, a\n"
        ".lin file beside the .bsp shows the way out, as editors read it.\n"
        "Exit status: 0 the level was written, 1 it could not be, 2 wrong arguments.");
    app.add_option("LEVEL.map", arguments.map, "the map text")->required();
    app.add_option("LEVEL.bsp", arguments.bsp, "what to write (default: beside the map)");
    app.add_option("--game", arguments.game,
                   "game directory with scripts and textures (default: the one around the map)");
    app.add_option("--textures", arguments.textures, "more game directories, searched after the level's own");
    app.add_flag("--quiet", arguments.quiet, "print warnings and errors only");
}

int fail(const std::string& message) {
    fmt::print(stderr, "maplevel: {}\n", message);
    return failed;
}

int compile(const Arguments& arguments) {
    using namespace pie;
    const std::vector<fs::path> textures(arguments.textures.begin(), arguments.textures.end());
    std::vector<fs::path> folders = textures;
    if (!arguments.game.empty()) folders.emplace_back(arguments.game);
    Result<level::Location> location = level::locate(arguments.map, {}, folders);
    if (!location) return fail(location.error().message());
    const Result<level::Bytes> bytes = location->files.read(location->name);
    if (!bytes) return fail(bytes.error().message());
    const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    const Result<brushes::MapText> map = brushes::parseMap(text, arguments.map);
    if (!map) return fail(map.error().message());
    const level::ShaderLibrary shaders = level::ShaderLibrary::load(location->files);
    const Result<brushes::CompiledMap> compiled = brushes::compileMap(*map, arguments.map, location->files, shaders);
    if (!compiled) return fail(compiled.error().message());
    for (const auto& list : {map->problems, compiled->warnings})
        for (const std::string& line : list) fmt::print(stderr, "maplevel: {}\n", line);

    const fs::path target =
        arguments.bsp.empty() ? fs::path(arguments.map).replace_extension(".bsp") : fs::path(arguments.bsp);
    const std::vector<std::byte> file = level::writeBsp(compiled->bsp);
    if (writeWhole(target, {reinterpret_cast<const char*>(file.data()), file.size()}))
        return fail(target.string() + ": cannot be written (is the folder there, and is it yours?)");
    const fs::path way = fs::path(target).replace_extension(".lin");
    std::error_code ignored;
    fs::remove(way, ignored);
    if (!compiled->leakPath.empty()) {
        std::string points;
        for (const glm::dvec3& p : compiled->leakPath) points += fmt::format("{:.3f} {:.3f} {:.3f}\n", p.x, p.y, p.z);
        if (writeWhole(way, points)) return fail(way.string() + ": cannot be written");
    }
    if (arguments.quiet) return 0;
    const level::Bsp& bsp = compiled->bsp;
    fmt::print("{}: {} brushes, {} patches, {} models -> {} faces, {} leaves, {} parts, {} bytes\n", target.string(),
               compiled->brushes, compiled->patches, compiled->models, bsp.faces.size(), bsp.leaves.size(),
               bsp.models.size(), file.size());
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    try {
        Arguments arguments;
        CLI::App app{"Compiles the .map text of a level editor into a Quake 3 .bsp (version 46), without light."};
        describe(app, arguments);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : misused;
        }
        return compile(arguments);
    } catch (const std::exception& problem) {
        return fail(problem.what());
    }
}
