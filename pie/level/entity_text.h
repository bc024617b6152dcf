#pragma once
// Changes to entities in the text that holds them: a .map an editor wrote keeps every other byte, its comments, brushes
// and line ends among them.

#include "pie/level/entities.h"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace pie::level {

/// An entity as it was read, and as it shall be: of `after`, values may differ and pairs may follow at the end; keys
/// stay, and none goes.
struct EntityEdit {
    Entity before, after;
};

/// `text` with the edits made. Each takes the first entity that equals its `before` and that no earlier edit took: of
/// two that are alike it does not matter which one changes. An edit whose entity is not there, and a value that no text
/// can hold (a quotation mark, a line end), is an Error, and nothing is changed.
[[nodiscard]] Result<std::string> editEntities(std::string_view text, const std::string& fileName,
                                               std::span<const EntityEdit> edits);

/// The same in a file, which appears whole or stays as it was; what it held before is then in a file beside it with
/// ".before" at the end of its name. Symbolic links are followed, permissions kept. Without a change nothing is
/// written.
[[nodiscard]] std::optional<Error> saveEntities(const std::filesystem::path& file, std::span<const EntityEdit> edits);

} // namespace pie::level
