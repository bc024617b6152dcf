#include "pie/level/entities.h"
#include "pie/level/names.h"
#include "pie/level/tokens.h"

#include <fmt/format.h>

#include <algorithm>

namespace pie::level {
namespace {

Error at(const std::string& file, const std::string& place, const Token& token, std::string why) {
    std::replace(why.begin(), why.end(), '\n', ' '); // quoted words may hold line ends, messages not
    return Error{file, fmt::format("{}, line {}, column {}", place, token.line, token.column), std::move(why), ""};
}

} // namespace

std::string_view Entity::value(std::string_view key) const {
    for (std::size_t i = pairs.size(); i-- > 0;)
        if (equalNoCase(pairs[i].first, key)) return pairs[i].second;
    return {};
}

void Entity::set(std::string_view key, std::string value) {
    const auto last =
        std::find_if(pairs.rbegin(), pairs.rend(), [&](const auto& pair) { return equalNoCase(pair.first, key); });
    if (last != pairs.rend())
        last->second = std::move(value);
    else
        pairs.emplace_back(std::string(key), std::move(value));
}

bool Entity::has(std::string_view key) const {
    for (const auto& [name, value] : pairs)
        if (equalNoCase(name, key)) return true;
    return false;
}

std::optional<float> Entity::number(std::string_view key) const { return leadingNumber(value(key)); }

std::optional<Vec3> Entity::vector(std::string_view key) const {
    std::string_view rest = value(key);
    Vec3 result(0.0F);
    for (int i = 0; i < 3; ++i) {
        const std::optional<float> part = leadingNumber(rest, &rest);
        if (!part) return std::nullopt;
        result[i] = *part;
    }
    return result;
}

Result<std::vector<Entity>> parseEntities(std::string_view text, const std::string& fileName,
                                          const std::string& place) {
    std::vector<Entity> entities;
    Tokens tokens(text);
    while (const std::optional<Token> open = tokens.next()) {
        if (!open->is('{'))
            return at(fileName, place, *open, fmt::format("expected '{{', found '{}'", open->text.substr(0, 40)));
        Entity& entity = entities.emplace_back();
        for (;;) {
            const std::optional<Token> key = tokens.next();
            if (!key) return at(fileName, place, *open, "this entity is not closed by '}' before the text ends");
            if (key->is('}')) break;
            if (key->is('{')) {
                if (!tokens.skipBlock())
                    return at(fileName, place, *key, "this brush is not closed by '}' before the text ends");
                continue;
            }
            const std::optional<Token> value = tokens.next();
            if (!value || value->is('}') || value->is('{'))
                return at(fileName, place, *key, fmt::format("the key '{}' has no value", key->text.substr(0, 40)));
            entity.pairs.emplace_back(key->text, value->text);
        }
    }
    return entities;
}

} // namespace pie::level
