#include "tests/osg/glsl_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

namespace pie::test {
namespace {

const std::set<std::string> types{"void", "float", "int", "vec2", "vec3", "vec4", "mat3", "sampler2D"};
const std::set<std::string> language{"varying", "uniform", "if", "else", "return", "discard", "true", "false"};
const std::set<std::string> builtIn{"abs",     "acos",   "clamp", "cos",       "cross",    "dot",       "floor",
                                    "fract",   "length", "max",   "min",       "mix",      "normalize", "pow",
                                    "radians", "sin",    "sqrt",  "texture2D", "gl_Color", "gl_Normal", "gl_Vertex"};

bool isWordCharacter(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool isName(const std::string& token) { return isWordCharacter(token.front()) && !isDigit(token.front()); }

/// Where a number that starts at `at` ends: digits, a point, an exponent with its sign.
std::size_t endOfNumber(const std::string& text, std::size_t at) {
    while (at < text.size() && (isWordCharacter(text[at]) || text[at] == '.' ||
                                ((text[at] == '+' || text[at] == '-') && (text[at - 1] == 'e' || text[at - 1] == 'E'))))
        ++at;
    return at;
}

/// Comments and directives dropped, but "#define NAME" kept as the two tokens "#define" and NAME.
std::vector<std::string> tokens(const std::string& text) {
    std::vector<std::string> found;
    for (std::size_t i = 0; i < text.size();) {
        const auto take = [&](std::size_t end) {
            found.push_back(text.substr(i, end - i));
            i = end;
        };
        if (std::isspace(static_cast<unsigned char>(text[i])) != 0) {
            ++i;
        } else if (text.compare(i, 2, "//") == 0 || text.compare(i, 8, "#version") == 0) {
            i = std::min(text.find('\n', i), text.size());
        } else if (text[i] == '#') {
            take(std::min(text.find_first_of(" \n", i), text.size()));
        } else if (isDigit(text[i]) || (text[i] == '.' && i + 1 < text.size() && isDigit(text[i + 1]))) {
            take(endOfNumber(text, i + 1));
        } else if (isWordCharacter(text[i])) {
            std::size_t end = i;
            while (end < text.size() && isWordCharacter(text[end])) ++end;
            take(end);
        } else if (text.compare(i, 2, "--") == 0 || text.compare(i, 2, "++") == 0) {
            take(i + 2);
        } else {
            take(i + 1);
        }
    }
    return found;
}

bool isNumber(const std::string& token) {
    std::size_t at = 0;
    const auto digits = [&] {
        const std::size_t first = at;
        while (at < token.size() && isDigit(token[at])) ++at;
        return at - first;
    };
    std::size_t mantissa = digits();
    if (at < token.size() && token[at] == '.') {
        ++at;
        mantissa += digits();
    }
    if (mantissa == 0) return false;
    if (at < token.size() && token[at] == 'e') {
        ++at;
        if (at < token.size() && (token[at] == '+' || token[at] == '-')) ++at;
        if (digits() == 0) return false;
    }
    return at == token.size();
}

class Checker {
public:
    std::vector<std::string> faults;

    void check(const std::vector<std::string>& source) {
        for (std::size_t i = 0; i < source.size(); ++i) {
            const std::string& token = source[i];
            const std::string next = i + 1 < source.size() ? source[i + 1] : std::string();
            const std::string previous = i > 0 ? source[i - 1] : std::string();
            if (token == "--" || token == "++") faults.push_back(fmt::format("operator {} near {}", token, next));
            if (isDigit(token.front()) && !isNumber(token)) faults.push_back("no number: " + token);
            brackets(token);
            if (isName(token)) name(token, previous, next);
            if (token == ";" || token == "{" || (declaring_ && open_.size() < *declaring_)) declaring_.reset();
        }
        if (!open_.empty()) faults.push_back("open bracket at the end: " + open_);
    }

private:
    std::string open_;
    std::set<std::string> known_;
    std::optional<std::size_t> declaring_; ///< depth of the brackets at which a list of declarations goes on

    void brackets(const std::string& token) {
        static const std::string opening = "([{";
        static const std::string closing = ")]}";
        const char c = token.front();
        if (opening.find(c) != std::string::npos) open_ += c;
        const std::size_t kind = closing.find(c);
        if (kind == std::string::npos) return;
        if (open_.empty() || open_.back() != opening[kind])
            faults.push_back("bracket closed that was not open: " + token);
        else
            open_.pop_back();
    }

    void name(const std::string& token, const std::string& previous, const std::string& next) {
        if (types.contains(token)) {
            if (!next.empty() && isName(next)) declaring_ = open_.size();
            return;
        }
        if (language.contains(token) || builtIn.contains(token) || token.starts_with("gl_") || previous == ".") return;
        const bool declared = types.contains(previous) || previous == "#define" ||
                              (previous == "," && declaring_ && *declaring_ == open_.size());
        if (declared)
            known_.insert(token);
        else if (!known_.contains(token))
            faults.push_back("name that nothing declares: " + token);
    }
};

} // namespace

std::vector<std::string> glslFaults(const std::string& source) {
    if (!source.starts_with("#version 120\n")) return {"the version is not in the first line"};
    Checker checker;
    checker.check(tokens(source));
    return checker.faults;
}

std::set<std::string> glslDeclared(const std::string& source, const std::string& qualifier) {
    const std::vector<std::string> all = tokens(source);
    std::set<std::string> names;
    for (std::size_t i = 0; i + 2 < all.size(); ++i)
        if (all[i] == qualifier) names.insert(all[i + 2]);
    return names;
}

} // namespace pie::test
