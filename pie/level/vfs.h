#pragma once
// The game's view of files: one tree of names laid over folders and pk3 (zip) archives.
//
// Order of precedence, highest first (LEVELS in doc/manual.md): files given explicitly, folders, pk3 files in reverse
// name order; a later `mount` wins over an earlier one. Names are relative, use '/', and compare without case. A name
// that climbs out
// ("..", absolute, drive letter) is never found. Safe to read from several threads at once.

#include "pie/core/result.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace pie::level {

using Bytes = std::vector<std::byte>;

/// A readable tree of files: a folder, an archive, or in tests a list in memory.
class FileSource;

class Vfs {
public:
    /// Adds one folder on top of everything mounted so far. Not an error if it is empty.
    [[nodiscard]] Result<bool> mountFolder(const std::filesystem::path& folder);
    /// Adds one zip archive on top. A damaged archive is an Error.
    [[nodiscard]] Result<bool> mountArchive(const std::filesystem::path& pk3);
    /// Adds files held in memory on top (tests, streams).
    void mountMemory(std::string name, std::vector<std::pair<std::string, Bytes>> files);
    /// Adds a game directory as the game does: its *.pk3 in name order, then the folder itself. Damaged pk3 files are
    /// skipped and named in `warnings()`.
    [[nodiscard]] Result<bool> mountGame(const std::filesystem::path& gameDirectory);

    [[nodiscard]] bool contains(std::string_view name) const;
    /// Where the name was found, for messages: "/games/baseoa/pak0.pk3/maps/x.bsp". Empty if not found.
    [[nodiscard]] std::string origin(std::string_view name) const;
    [[nodiscard]] Result<Bytes> read(std::string_view name) const;
    /// Names below `folder` that end in `suffix` (both without case), each once, sorted without case, in lower case.
    [[nodiscard]] std::vector<std::string> list(std::string_view folder, std::string_view suffix) const;
    /// The same names in the order in which the game lists them: highest precedence first, inside an archive as stored,
    /// inside a folder by name.
    [[nodiscard]] std::vector<std::string> scan(std::string_view folder, std::string_view suffix) const;
    [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

private:
    std::vector<std::shared_ptr<const FileSource>> sources_; ///< lowest precedence first
    std::vector<std::string> warnings_;
};

/// A level as a user names it, and the file system it lives in.
struct Location {
    Vfs files;
    std::string name; ///< inside `files`: "maps/x.bsp"
};

/// Finds a level: a file on disk ("…/maps/x.bsp" implies the game directory above it; elsewhere its own folder), a file
/// in an archive
/// ("some.pk3/maps/x.bsp": the game directory is the archive's folder), or with `game` a map name ("x" or
/// "maps/x.bsp"). `searchFolders` are mounted below the level's own game directory (textures of a base game).
[[nodiscard]] Result<Location> locate(const std::string& level, const std::filesystem::path& game = {},
                                      const std::vector<std::filesystem::path>& searchFolders = {});

} // namespace pie::level
