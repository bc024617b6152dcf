#pragma once
// The registry behind Settings: how each row reads and writes its field. Inside pie/engine only.

#include "pie/engine/settings.h"

#include <optional>
#include <variant>

namespace pie::engine::table {

/// A field of an enumeration whose values are 0 to names.size() - 1.
struct Choice {
    std::span<const std::string_view> names;
    void (*write)(Settings&, std::size_t) = nullptr;
    std::size_t (*read)(const Settings&) = nullptr;
};
struct Path {
    std::string Settings::*field;
    bool folder; ///< else a file
};
using Field = std::variant<bool Settings::*, int Settings::*, float Settings::*, std::uint64_t Settings::*,
                           std::vector<std::string> Settings::*, Path, Choice>;

struct Row {
    std::string_view key;
    std::string_view group;
    Field field;
    double lowest = 0, highest = 0; ///< of numbers
    std::string_view unit;
    std::string_view consequence;
    std::string_view paper;
};

[[nodiscard]] std::span<const Row> rows();
/// Row number of a key, exact.
[[nodiscard]] std::optional<std::size_t> find(std::string_view key);
/// The key that a user most likely meant.
[[nodiscard]] std::string_view nearest(std::string_view key);
/// Parses `text` into the row's field; the Error names the key and what is allowed.
[[nodiscard]] Result<bool> write(const Row& row, std::string_view text, Settings& settings);
[[nodiscard]] std::string read(const Row& row, const Settings& settings);
[[nodiscard]] std::string syntax(const Row& row);
[[nodiscard]] std::string range(const Row& row);

} // namespace pie::engine::table
