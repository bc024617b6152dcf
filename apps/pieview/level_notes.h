#pragma once
// What a user keeps about a level: bookmarks and a camera path. One small TOML file per level in the user's
// configuration folder, which is written whole at every change; a file that is damaged is reported and left alone.

#include "apps/support/camera.h"
#include "pie/core/result.h"

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

namespace pieview {

using apps::Camera;

struct LevelNotes {
    std::array<std::optional<Camera>, 10> bookmarks; ///< by digit
    std::vector<Camera> path;
    bool operator==(const LevelNotes&) const = default;
};

/// $XDG_CONFIG_HOME/pie (else ~/.config/pie) /levels/NAME-HASH.toml; the hash is of the level's whole path, so that two
/// levels of one name are apart. Empty where there is no home.
[[nodiscard]] std::filesystem::path notesFile(const std::filesystem::path& level);
/// Nothing noted where there is no file.
[[nodiscard]] pie::Result<LevelNotes> readNotes(const std::filesystem::path& file);
/// Makes folders that are missing.
[[nodiscard]] std::optional<pie::Error> writeNotes(const std::filesystem::path& file, const LevelNotes& notes,
                                                   const std::filesystem::path& level);

} // namespace pieview
