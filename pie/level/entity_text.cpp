#include "pie/level/entity_text.h"

#include "pie/core/whole_file.h"
#include "pie/level/tokens.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <system_error>
#include <vector>

namespace fs = std::filesystem;

namespace pie::level {
namespace {

struct Span {
    std::size_t begin = 0, end = 0; ///< bytes of the text
};

/// An entity and where it stands.
struct PlacedEntity {
    Entity entity;
    std::vector<Span> keys, values; ///< of each pair, with their quotation marks
    bool taken = false;
};

/// Where a word stands, with its quotation marks.
Span spanOf(std::string_view text, const Token& token) {
    const auto begin = static_cast<std::size_t>(token.text.data() - text.data());
    if (!token.quoted) return {begin, begin + token.text.size()};
    return {begin - 1, begin + token.text.size() + 1};
}

/// Of text that parseEntities() accepts.
std::vector<PlacedEntity> placedEntities(std::string_view text) {
    std::vector<PlacedEntity> entities;
    Tokens tokens(text);
    while (tokens.next()) {
        PlacedEntity& placed = entities.emplace_back();
        while (const std::optional<Token> key = tokens.next()) {
            if (key->is('}')) break;
            if (key->is('{')) {
                if (!tokens.skipBlock()) break;
                continue;
            }
            const std::optional<Token> value = tokens.next();
            if (!value) break;
            placed.entity.pairs.emplace_back(key->text, value->text);
            placed.keys.push_back(spanOf(text, *key));
            placed.values.push_back(spanOf(text, *value));
        }
    }
    return entities;
}

struct Replacement {
    Span where;
    std::string by;
};

/// What stands between the line's start and a pair that begins its line, with the line end before it: how a further
/// pair is set off. A space where pairs stand in one line.
std::string separatorBefore(std::string_view text, std::size_t pair) {
    std::size_t start = pair;
    while (start > 0 && (text[start - 1] == ' ' || text[start - 1] == '\t')) --start;
    if (start == 0 || text[start - 1] != '\n') return " ";
    const bool carriageReturn = start > 1 && text[start - 2] == '\r';
    return (carriageReturn ? "\r\n" : "\n") + std::string(text.substr(start, pair - start));
}

Error refusal(const std::string& file, const Entity& entity, const std::string& why, const std::string& remedy) {
    const std::string_view origin = entity.value("origin");
    return Error{file, fmt::format("{} at {}", entity.className(), origin.empty() ? "no origin" : origin), why, remedy};
}

std::optional<Error> collect(std::string_view text, const std::string& file, const EntityEdit& edit,
                             const PlacedEntity& placed, std::vector<Replacement>& changes) {
    const auto& before = edit.before.pairs;
    const auto& after = edit.after.pairs;
    if (after.size() < before.size()) return refusal(file, edit.before, "a key of it would be lost", "");
    for (std::size_t i = 0; i < after.size(); ++i) {
        const auto& [key, value] = after[i];
        if ((key + value).find_first_of("\"\r\n") != std::string::npos)
            return refusal(file, edit.before, "a value with a quotation mark or a line end cannot be written", "");
        if (i >= before.size()) {
            if (before.empty()) return refusal(file, edit.before, "has no keys to put another one behind", "");
            const std::string separator = separatorBefore(text, placed.keys.back().begin);
            const std::size_t end = placed.values.back().end;
            changes.push_back({{end, end}, fmt::format(R"({}"{}" "{}")", separator, key, value)});
        } else if (key != before[i].first) {
            return refusal(file, edit.before, fmt::format("its key '{}' would be lost", before[i].first), "");
        } else if (value != before[i].second) {
            changes.push_back({placed.values[i], fmt::format("\"{}\"", value)});
        }
    }
    return std::nullopt;
}

Result<std::string> readText(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    if (!stream) return Error{file.string(), "", "cannot be read", ""};
    return text;
}

/// Written like another file: by the same who may read and write it.
std::optional<Error> writeLike(const fs::path& file, std::string_view content, fs::perms permissions) {
    if (std::optional<Error> problem = writeWhole(file, content)) return problem;
    std::error_code ignored; // the content is what counts
    fs::permissions(file, permissions, ignored);
    return std::nullopt;
}

} // namespace

Result<std::string> editEntities(std::string_view text, const std::string& fileName,
                                 std::span<const EntityEdit> edits) {
    if (const auto readable = parseEntities(text, fileName, "map"); !readable) return readable.error();
    std::vector<PlacedEntity> entities = placedEntities(text);
    std::vector<Replacement> changes;
    for (const EntityEdit& edit : edits) {
        const auto found = std::find_if(entities.begin(), entities.end(), [&](const PlacedEntity& placed) {
            return !placed.taken && placed.entity.pairs == edit.before.pairs;
        });
        if (found == entities.end())
            return refusal(fileName, edit.before, "is not there as it was read",
                           "has the file changed since? load it again and repeat the edit");
        found->taken = true;
        if (std::optional<Error> problem = collect(text, fileName, edit, *found, changes)) return *problem;
    }
    // Those for one place stay in the order of the pairs.
    std::stable_sort(changes.begin(), changes.end(),
                     [](const Replacement& a, const Replacement& b) { return a.where.begin < b.where.begin; });
    std::string result;
    std::size_t copied = 0;
    for (const Replacement& change : changes) {
        result.append(text.substr(copied, change.where.begin - copied));
        result.append(change.by);
        copied = change.where.end;
    }
    result.append(text.substr(copied));
    return result;
}

std::optional<Error> saveEntities(const fs::path& file, std::span<const EntityEdit> edits) {
    std::error_code problem;
    const fs::path target = fs::canonical(file, problem);
    if (problem) return Error{file.string(), "", problem.message(), ""};
    const fs::perms permissions = fs::status(target, problem).permissions();
    const Result<std::string> text = readText(target);
    if (!text) return text.error();
    const Result<std::string> edited = editEntities(*text, file.string(), edits);
    if (!edited) return edited.error();
    if (*edited == *text) return std::nullopt;
    if (std::optional<Error> failed = writeLike(target.string() + ".before", *text, permissions)) return failed;
    return writeLike(target, *edited, permissions);
}

} // namespace pie::level
