#include "pie/brushes/map_text.h"

#include "pie/level/names.h"
#include "pie/level/tokens.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

namespace pie::brushes {
namespace {

using level::Token;
using level::Tokens;

/// Contents of a face that a detail brush carries, as editors write them.
constexpr int mostControls = 1024 * 1024;

/// What stopped a brush, a patch or an entity from being read.
struct Fault {
    int line = 0, column = 0;
    std::string text;
};

class Parser {
public:
    Parser(std::string_view text, const std::string& fileName) : text_(text), tokens_(text), fileName_(fileName) {}

    MapText parse() {
        while (const std::optional<Token> token = next()) {
            if (token->is('{')) {
                entity(*token);
            } else {
                report({token->line, token->column, "expected '{' of an entity, found '" + shown(*token) + "'"});
                if (!skipTo('{')) break;
            }
        }
        return std::move(map_);
    }

private:
    std::string_view text_;
    Tokens tokens_;
    const std::string& fileName_;
    MapText map_;
    std::optional<Token> peeked_;
    std::size_t base_ = 0; ///< where in the text `tokens_` started

    static std::string shown(const Token& token) { return std::string(token.text.substr(0, 40)); }

    void report(const Fault& fault) {
        map_.problems.push_back(
            fmt::format("{}: line {}, column {}: {}", fileName_, fault.line, fault.column, fault.text));
    }

    /// The next word. A quote that is not closed on its line ends with it: no editor writes values over several lines.
    std::optional<Token> next() {
        if (peeked_) return std::exchange(peeked_, std::nullopt);
        std::optional<Token> token = tokens_.next();
        if (token && token->quoted)
            if (const std::size_t end = token->text.find('\n'); end != std::string_view::npos) {
                report({token->line, token->column, "the quote is not closed on its line; it ends there"});
                token->text = token->text.substr(0, end);
                if (token->text.ends_with('\r')) token->text.remove_suffix(1);
                base_ = static_cast<std::size_t>(token->text.data() - text_.data()) + token->text.size();
                tokens_ = Tokens(text_.substr(base_), token->line);
            }
        return token;
    }
    const std::optional<Token>& peek() {
        if (!peeked_) peeked_ = next();
        return peeked_;
    }

    Fault atEnd(const std::string& wanted) {
        return {tokens_.line(), 1, "expected " + wanted + ", found the end of the file"};
    }
    /// Skips up to a brace, which stays to be read.
    bool skipTo(char brace) {
        while (const std::optional<Token>& token = peek()) {
            if (token->is(brace)) return true;
            next();
        }
        return false;
    }
    /// Skips behind the '}' that closes what was opened `depth` times.
    void skipOut(int depth) {
        while (depth > 0) {
            const std::optional<Token> token = next();
            if (!token) return;
            if (token->is('{')) ++depth;
            if (token->is('}')) --depth;
        }
    }

    std::optional<Fault> expect(std::string_view word) {
        const std::optional<Token> token = next();
        if (!token) return atEnd(fmt::format("'{}'", word));
        if (!token->quoted && token->text == word) return std::nullopt;
        if (token->is('{') || token->is('}')) peeked_ = token;
        return Fault{token->line, token->column, fmt::format("expected '{}', found '{}'", word, shown(*token))};
    }
    std::optional<Fault> number(double& value) {
        const std::optional<Token> token = next();
        if (!token) return atEnd("a number");
        std::string_view digits = token->text;
        if (digits.starts_with('+')) digits.remove_prefix(1);
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (error == std::errc() && end == digits.data() + digits.size() && std::isfinite(value)) return std::nullopt;
        if (token->is('{') || token->is('}')) peeked_ = token;
        return Fault{token->line, token->column, fmt::format("expected a number, found '{}'", shown(*token))};
    }
    template <class... Values> std::optional<Fault> numbers(Values&... values) {
        std::optional<Fault> fault;
        static_cast<void>(((fault = number(values), !fault) && ...));
        return fault;
    }
    /// ( x y z )
    std::optional<Fault> triple(glm::dvec3& v) {
        if (auto fault = expect("(")) return fault;
        if (auto fault = numbers(v.x, v.y, v.z)) return fault;
        return expect(")");
    }
    std::optional<Fault> shader(std::string& name) {
        const std::optional<Token> token = next();
        if (!token) return atEnd("a shader name");
        if (token->is('{') || token->is('}') || token->is('(') || token->text.empty()) {
            if (token->is('{') || token->is('}')) peeked_ = token;
            return Fault{token->line, token->column, "expected a shader name, found '" + shown(*token) + "'"};
        }
        name = level::lower(token->text);
        for (char& c : name)
            if (c == '\\') c = '/';
        if (!name.starts_with("textures/")) name.insert(0, "textures/");
        return std::nullopt;
    }

    void entity(const Token& open) {
        MapEntity entity;
        entity.line = open.line;
        while (const std::optional<Token> token = next()) {
            if (token->is('}')) {
                map_.entities.push_back(std::move(entity));
                return;
            }
            if (token->is('{')) {
                if (const std::optional<Fault> fault = primitive(entity, *token)) {
                    report(*fault);
                    skipOut(depth_);
                }
                continue;
            }
            const std::optional<Token> value = next();
            if (!value) break;
            if (value->is('{') || value->is('}')) {
                report({token->line, token->column, fmt::format("the key '{}' has no value", shown(*token))});
                peeked_ = value;
                continue;
            }
            entity.entity.pairs.emplace_back(token->text, value->text);
        }
        report({open.line, open.column,
                "the entity is not closed by '}' before the file ends; what it holds so far is kept"});
        map_.entities.push_back(std::move(entity));
    }

    int depth_ = 0; ///< braces that are open inside the entity, for skipping what has a fault

    std::optional<Fault> primitive(MapEntity& entity, const Token& open) {
        depth_ = 1;
        const std::optional<Token>& first = peek();
        if (!first) return atEnd("a brush or a patch");
        const std::string word = level::lower(first->text);
        if (word == "patchdef2" || word == "patchdef3") {
            next();
            return patch(entity, open, word == "patchdef3");
        }
        if (word == "brushdef") {
            next();
            if (auto fault = expect("{")) return fault;
            ++depth_;
            if (auto fault = brush(entity, open, true)) return fault;
            --depth_;
            return expect("}");
        }
        if (!first->is('(') && !first->is('}'))
            return Fault{first->line, first->column,
                         fmt::format("expected '(', patchDef2 or brushDef, found '{}'", shown(*first))};
        return brush(entity, open, false);
    }

    /// Up to and with its '}'.
    std::optional<Fault> brush(MapEntity& entity, const Token& open, bool primitiveForm) {
        BrushText brush;
        brush.line = open.line;
        for (;;) {
            const std::optional<Token>& token = peek();
            if (!token) return atEnd("'}' of the brush");
            if (token->is('}')) break;
            if (auto fault = face(brush.faces.emplace_back(), primitiveForm)) return fault;
        }
        next();
        entity.brushes.push_back(std::move(brush));
        return std::nullopt;
    }

    std::optional<Fault> face(FaceText& face, bool primitiveForm) {
        for (glm::dvec3& point : face.points)
            if (auto fault = triple(point)) return fault;
        if (primitiveForm) {
            MatrixTexture matrix;
            if (auto fault = expect("(")) return fault;
            for (glm::dvec3& row : matrix.rows)
                if (auto fault = triple(row)) return fault;
            if (auto fault = expect(")")) return fault;
            face.texture = matrix;
            if (auto fault = shader(face.shader)) return fault;
            return flags(face.contents);
        }
        if (auto fault = shader(face.shader)) return fault;
        const std::optional<Token>& token = peek();
        if (token && token->is('[')) {
            AxisTexture axes;
            for (std::size_t i = 0; i < 2; ++i) {
                if (auto fault = expect("[")) return fault;
                glm::dvec3& axis = axes.axes.at(i);
                if (auto fault = numbers(axis.x, axis.y, axis.z, axes.shift.at(i))) return fault;
                if (auto fault = expect("]")) return fault;
            }
            double rotate = 0; // for the editor only: the axes have been turned already
            if (auto fault = numbers(rotate, axes.scale[0], axes.scale[1])) return fault;
            face.texture = axes;
        } else {
            ShiftedTexture shifted;
            if (auto fault =
                    numbers(shifted.shift[0], shifted.shift[1], shifted.rotate, shifted.scale[0], shifted.scale[1]))
                return fault;
            face.texture = shifted;
        }
        return flags(face.contents);
    }

    /// contents, flags and value, which editors may leave out; only the first says something here.
    std::optional<Fault> flags(std::int32_t& contents) {
        for (int i = 0; i < 3; ++i) {
            const std::optional<Token>& token = peek();
            if (!token || token->is('(') || token->is('}')) return std::nullopt;
            double value = 0;
            if (auto fault = number(value)) return fault;
            if (i == 0 && std::abs(value) < 4294967296.0)
                contents = static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::int64_t>(value)));
        }
        return std::nullopt;
    }

    std::optional<Fault> patch(MapEntity& entity, const Token& open, bool subdivided) {
        PatchText patch;
        patch.line = open.line;
        if (auto fault = expect("{")) return fault;
        ++depth_;
        if (auto fault = shader(patch.shader)) return fault;
        // In the text `columns` come first: each parenthesis holds one column of `rows` controls.
        double columns = 0;
        double rows = 0;
        double contents = 0;
        double other = 0;
        if (auto fault = expect("(")) return fault;
        if (auto fault = numbers(columns, rows)) return fault;
        if (subdivided)
            if (auto fault = numbers(other, other)) return fault;
        if (auto fault = numbers(contents, other, other)) return fault;
        if (auto fault = expect(")")) return fault;
        const auto valid = [](double n) { return n >= 3 && n <= 1023 && std::fmod(n, 2) == 1; };
        if (!valid(columns) || !valid(rows) || columns * rows > mostControls)
            return Fault{open.line, open.column,
                         fmt::format("a patch of {} x {} controls: both must be odd, at least 3", columns, rows)};
        patch.contents = static_cast<std::int32_t>(std::fmod(contents, 2147483648.0));
        patch.width = static_cast<int>(columns);
        patch.height = static_cast<int>(rows);
        patch.controls.resize(static_cast<std::size_t>(patch.width) * static_cast<std::size_t>(patch.height));
        if (auto fault = expect("(")) return fault;
        for (int column = 0; column < patch.width; ++column) {
            if (auto fault = expect("(")) return fault;
            for (int row = 0; row < patch.height; ++row) {
                PatchText::Control& control = patch.at(column, row);
                if (auto fault = expect("(")) return fault;
                glm::dvec3& p = control.position;
                if (auto fault = numbers(p.x, p.y, p.z, control.texture[0], control.texture[1])) return fault;
                // Some editors add a colour.
                while (peek() && !peek()->is(')'))
                    if (auto fault = number(other)) return fault;
                if (auto fault = expect(")")) return fault;
            }
            if (auto fault = expect(")")) return fault;
        }
        if (auto fault = expect(")")) return fault;
        if (auto fault = expect("}")) return fault;
        --depth_;
        if (auto fault = expect("}")) return fault;
        entity.patches.push_back(std::move(patch));
        return std::nullopt;
    }
};

} // namespace

Result<MapText> parseMap(std::string_view text, const std::string& fileName) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    MapText map = Parser(text, fileName).parse();
    if (!map.entities.empty()) return map;
    if (!map.problems.empty()) return Error{"", "", map.problems.front(), ""};
    return Error{fileName, "", "is no map: it holds no entity", ""};
}

} // namespace pie::brushes
