#pragma once
// Names as the game compares them: ASCII, without case, '/' between parts.

#include <optional>
#include <string>
#include <string_view>

namespace pie::level {

[[nodiscard]] constexpr char lowerChar(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
[[nodiscard]] std::string lower(std::string_view text);
[[nodiscard]] bool equalNoCase(std::string_view a, std::string_view b);
[[nodiscard]] bool startsWithNoCase(std::string_view text, std::string_view prefix);
[[nodiscard]] bool endsWithNoCase(std::string_view text, std::string_view suffix);

/// Lower case, '\' as '/', without "." and empty parts. Empty for a name that climbs out of its tree: "..", absolute,
/// drive letter, or one with control characters.
[[nodiscard]] std::optional<std::string> safeName(std::string_view name);
/// "textures/a.b/c" of "textures/a.b/c.tga": only the last part's extension goes.
[[nodiscard]] std::string_view withoutExtension(std::string_view name);
/// "tga", in the case it is written in; empty if the last part has none.
[[nodiscard]] std::string_view extension(std::string_view name);

} // namespace pie::level
