#pragma once
// Entities: blocks of "key" "value" lines, the same text in a BSP's entity lump and in a .map file.

#include "pie/core/result.h"
#include "pie/core/vec.h"

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pie::level {

struct Entity {
    std::vector<std::pair<std::string, std::string>> pairs; ///< as written, in order

    /// Value of `key` (compared without case; the last one wins, as in the game), or an empty view.
    [[nodiscard]] std::string_view value(std::string_view key) const;
    [[nodiscard]] bool has(std::string_view key) const;
    [[nodiscard]] std::string_view className() const { return value("classname"); }
    /// Gives `key` a value where value() reads it; a key that is not there is added at the end, spelt as given.
    void set(std::string_view key, std::string value);
    /// The number a value starts with; nullopt if absent, not a number or not finite.
    [[nodiscard]] std::optional<float> number(std::string_view key) const;
    [[nodiscard]] std::optional<Vec3> vector(std::string_view key) const;
};

/// `place` names the text in messages ("entities"). Errors name line and column. Brushes and patches inside an entity,
/// as in a .map, are skipped.
[[nodiscard]] Result<std::vector<Entity>> parseEntities(std::string_view text, const std::string& fileName,
                                                        const std::string& place = "entities");

} // namespace pie::level
