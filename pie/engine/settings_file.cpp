// Settings from TOML. In a source of its own: the parser is one large header.

#include "pie/engine/settings_table.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <fstream>
#include <sstream>

namespace pie::engine {
namespace {

constexpr std::uintmax_t largestFile = 1U << 20U;

std::string place(const toml::source_region& region) {
    return fmt::format("line {}, column {}", region.begin.line, region.begin.column);
}

/// Folders in a file are meant from where the file is.
std::string resolve(const std::string& path, const std::filesystem::path& folder) {
    if (path.empty() || std::filesystem::path(path).is_absolute()) return path;
    return (folder / path).lexically_normal().string();
}

/// One value as `Settings::set` reads it; nullopt for kinds that no setting has (tables, dates).
std::optional<std::string> text(const toml::node& node, const table::Field& field,
                                const std::filesystem::path& folder) {
    const bool isList = std::holds_alternative<std::vector<std::string> Settings::*>(field);
    const bool isPath = isList || std::holds_alternative<table::Path>(field);
    if (const auto* s = node.as_string()) return isPath ? resolve(s->get(), folder) : s->get();
    if (const auto* b = node.as_boolean()) return std::string(b->get() ? "true" : "false");
    if (const auto* i = node.as_integer()) return fmt::format("{}", i->get());
    if (const auto* f = node.as_floating_point()) return fmt::format("{}", f->get());
    const toml::array* const list = node.as_array();
    if (!list || !isList) return std::nullopt;
    std::string joined;
    for (const toml::node& item : *list) {
        const auto* const s = item.as_string();
        if (!s) return std::nullopt;
        if (!joined.empty()) joined += ':';
        joined += resolve(s->get(), folder);
    }
    return joined;
}

Result<std::string> load(const std::filesystem::path& file) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) return Error{file.string(), "", "cannot be read: " + error.message(), ""};
    if (size > largestFile) return Error{file.string(), "", "is too large for a settings file", ""};
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream content;
    content << stream.rdbuf();
    if (!stream) return Error{file.string(), "", "cannot be read", ""};
    return std::move(content).str();
}

Result<bool> apply(const toml::table& entries, const std::filesystem::path& file, Settings& settings) {
    for (const auto& [key, node] : entries) {
        const std::string where = place(node.source());
        const auto index = table::find(key.str());
        if (node.is_table() && !index)
            return Error{file.string(), where, fmt::format("[{}] is a table", key.str()),
                         "settings are flat: key = value"};
        const auto value =
            index ? text(node, table::rows()[*index].field, file.parent_path()) : std::optional<std::string>("");
        if (!value)
            return Error{file.string(), where, fmt::format("{} has a value of the wrong kind", key.str()),
                         "use " + table::syntax(table::rows()[*index])};
        if (Result<bool> taken = settings.set(key.str(), *value, Source::File); !taken) {
            const Error& inner = taken.error();
            return Error{file.string(), where, inner.place + ": " + inner.reason, inner.remedy};
        }
    }
    return true;
}

} // namespace

Result<bool> Settings::readFile(const std::filesystem::path& file) {
    const Result<std::string> content = load(file);
    if (!content) return content.error();
    Settings changed = *this;
    try {
        if (Result<bool> applied = apply(toml::parse(*content), file, changed); !applied) return applied;
    } catch (const toml::parse_error& error) {
        return Error{file.string(), place(error.source()), std::string(error.description()), ""};
    }
    *this = std::move(changed);
    return true;
}

} // namespace pie::engine
