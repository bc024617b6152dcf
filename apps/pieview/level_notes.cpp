#include "apps/pieview/level_notes.h"

#include "pie/core/whole_file.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

namespace pieview {
namespace {

namespace fs = std::filesystem;

/// FNV-1a, 64 bits.
std::uint64_t hash(std::string_view text) {
    std::uint64_t value = 14695981039346656037U;
    for (const char c : text) value = (value ^ static_cast<unsigned char>(c)) * 1099511628211U;
    return value;
}

fs::path configFolder() {
    const char* config = std::getenv("XDG_CONFIG_HOME");
    if (config && *config) return fs::path(config) / "pie";
    const char* home = std::getenv("HOME");
    return home && *home ? fs::path(home) / ".config" / "pie" : fs::path();
}

std::optional<Camera> readCamera(const toml::node* node) {
    const auto* text = node ? node->as_string() : nullptr;
    return text ? apps::parseCamera(text->get()) : std::nullopt;
}

LevelNotes readTable(const toml::table& table) {
    LevelNotes notes;
    if (const auto* bookmarks = table["bookmarks"].as_table())
        for (std::size_t digit = 0; digit < notes.bookmarks.size(); ++digit)
            notes.bookmarks[digit] = readCamera(bookmarks->get(std::to_string(digit)));
    if (const auto* path = table["path"].as_array())
        for (const toml::node& key : *path)
            if (const auto camera = readCamera(&key)) notes.path.push_back(*camera);
    return notes;
}

/// A string of one line in TOML.
std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') result += '\\';
        if (static_cast<unsigned char>(c) >= 0x20) result += c;
    }
    return result + '"';
}

} // namespace

fs::path notesFile(const fs::path& level) {
    const fs::path folder = configFolder();
    if (folder.empty()) return {};
    std::error_code error;
    const fs::path whole = fs::weakly_canonical(level, error);
    const std::string text = error ? level.string() : whole.string();
    return folder / "levels" / fmt::format("{}-{:016x}.toml", level.stem().string(), hash(text));
}

pie::Result<LevelNotes> readNotes(const fs::path& file) {
    std::error_code error;
    if (file.empty() || !fs::exists(file, error)) return LevelNotes{};
    try {
        return readTable(toml::parse_file(file.string()));
    } catch (const toml::parse_error& wrong) {
        return pie::Error{file.string(),
                          fmt::format("line {}, column {}", wrong.source().begin.line, wrong.source().begin.column),
                          std::string(wrong.description()), "mend or remove it; bookmarks are not kept meanwhile"};
    } catch (const std::exception& wrong) {
        return pie::Error{file.string(), "", wrong.what(), "mend or remove it; bookmarks are not kept meanwhile"};
    }
}

std::optional<pie::Error> writeNotes(const fs::path& file, const LevelNotes& notes, const fs::path& level) {
    if (file.empty()) return pie::Error{"", "bookmarks", "there is no home to keep them in", "set HOME"};
    std::string text = fmt::format("# pieview's notes about a level; cameras are \"x y z yaw pitch\".\nlevel = {}\n",
                                   quoted(level.string()));
    text += "path = [";
    for (const Camera& key : notes.path) text += fmt::format("\n    \"{}\",", apps::cameraText(key));
    text += notes.path.empty() ? "]\n" : "\n]\n";
    text += "\n[bookmarks]\n";
    for (std::size_t digit = 0; digit < notes.bookmarks.size(); ++digit)
        if (const auto& camera = notes.bookmarks[digit])
            text += fmt::format("{} = \"{}\"\n", digit, apps::cameraText(*camera));
    std::error_code error;
    fs::create_directories(file.parent_path(), error);
    if (error) return pie::Error{file.parent_path().string(), "", error.message(), ""};
    return pie::writeWhole(file, text);
}

} // namespace pieview
