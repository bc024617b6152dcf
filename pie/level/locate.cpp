#include "pie/level/file_source.h"
#include "pie/level/names.h"
#include "pie/level/vfs.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

namespace fs = std::filesystem;

namespace pie::level {
namespace {

/// A path that leads into an archive: the archive and the name behind it.
struct InArchive {
    fs::path archive;
    std::string name;
};

std::optional<InArchive> splitArchive(const fs::path& path) {
    fs::path front;
    for (auto part = path.begin(); part != path.end(); ++part) {
        front /= *part;
        std::error_code error;
        if (!endsWithNoCase(part->string(), ".pk3") || !fs::is_regular_file(front, error)) continue;
        fs::path rest;
        for (auto behind = std::next(part); behind != path.end(); ++behind) rest /= *behind;
        return InArchive{front, rest.generic_string()};
    }
    return std::nullopt;
}

/// The game directory of "GAME/maps/…/x.bsp": the folder above the last "maps". Empty if there is none.
fs::path gameAbove(const fs::path& file) {
    for (fs::path folder = file.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
        if (equalNoCase(folder.filename().string(), "maps")) return folder.parent_path();
    return {};
}

Result<bool> mountAll(Vfs& files, const std::vector<fs::path>& games) {
    for (const fs::path& game : games)
        if (Result<bool> mounted = files.mountGame(game); !mounted) return mounted;
    return true;
}

/// What the user may have meant, when a map of that name is not there.
std::string knownMaps(const Vfs& files) {
    const std::vector<std::string> maps = files.list("maps", ".bsp");
    if (maps.empty()) return "no maps/*.bsp there at all";
    return fmt::format("there are {} maps, the first is {}", maps.size(), maps.front());
}

Result<Location> locateByName(const std::string& level, const fs::path& game, Vfs files) {
    std::string name = level;
    if (!endsWithNoCase(name, ".bsp") && !endsWithNoCase(name, ".map")) name += ".bsp";
    if (!files.contains(name) && files.contains("maps/" + name)) name = "maps/" + name;
    if (!files.contains(name))
        return Error{level, "", fmt::format("no such map in {}", game.string()), knownMaps(files)};
    return Location{std::move(files), *safeName(name)};
}

Result<Location> locateInArchive(const InArchive& where, Vfs files) {
    if (Result<bool> mounted = files.mountGame(fs::absolute(where.archive).parent_path()); !mounted)
        return mounted.error();
    const std::string wanted = where.archive.string() + "/" + where.name;
    const Result<std::shared_ptr<const FileSource>> archive = makeArchiveSource(where.archive);
    if (!archive) return archive.error();
    const std::optional<std::string> name = safeName(where.name);
    if (!name || !(*archive)->contains(*name)) return Error{wanted, "", "no such file in the archive", ""};
    // Another archive may win over the one the user named; then the level is that file all the same.
    const std::string found = files.origin(*name);
    const fs::path holder = found.substr(0, found.size() - std::min(found.size(), name->size() + 1));
    std::error_code error;
    if (!fs::equivalent(holder, where.archive, error)) {
        Result<Bytes> bytes = (*archive)->read(*name);
        if (!bytes) return bytes.error();
        std::vector<std::pair<std::string, Bytes>> explicitFile;
        explicitFile.emplace_back(*name, std::move(*bytes));
        files.mountMemory(where.archive.string(), std::move(explicitFile));
    }
    return Location{std::move(files), *name};
}

Result<Location> locateOnDisk(const fs::path& path, Vfs files) {
    const fs::path file = fs::absolute(path).lexically_normal();
    const fs::path game = gameAbove(file);
    const fs::path root = game.empty() ? file.parent_path() : game;
    const Result<bool> mounted = game.empty() ? files.mountFolder(root) : files.mountGame(root);
    if (!mounted) return mounted.error();
    const std::optional<std::string> name = safeName(file.lexically_relative(root).generic_string());
    if (!name) return Error{path.string(), "", "has a name that no game directory can hold", ""};
    return Location{std::move(files), *name};
}

} // namespace

Result<Location> locate(const std::string& level, const fs::path& game, const std::vector<fs::path>& searchFolders) {
    Vfs files;
    if (Result<bool> mounted = mountAll(files, searchFolders); !mounted) return mounted.error();
    if (!game.empty()) {
        if (Result<bool> mounted = files.mountGame(game); !mounted) return mounted.error();
        return locateByName(level, game, std::move(files));
    }
    std::error_code error;
    if (fs::is_regular_file(level, error)) return locateOnDisk(level, std::move(files));
    if (const std::optional<InArchive> inside = splitArchive(level)) return locateInArchive(*inside, std::move(files));
    if (!searchFolders.empty() && level.find('/') == std::string::npos)
        return locateByName(level, searchFolders.back(), std::move(files));
    return Error{level, "", "no such file",
                 "a level is a .bsp or .map on disk, some.pk3/maps/x.bsp, or a map name with a game directory"};
}

} // namespace pie::level
