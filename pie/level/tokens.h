#pragma once
// Words of the game's text files (entities, .map, shader scripts): separated by white space, "quoted" words may hold
// it, // and /* */ comments count as white space. Braces are words only where white space sets them apart, as in the
// game.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace pie::level {

struct Token {
    std::string_view text; ///< without quotes
    bool quoted = false;
    int line = 1, column = 1;

    [[nodiscard]] bool is(char c) const { return !quoted && text.size() == 1 && text.front() == c; }
};

class Tokens {
public:
    explicit Tokens(std::string_view text, int firstLine = 1) : text_(text), line_(firstLine) {}

    /// The next word anywhere; nothing at the end of the text.
    [[nodiscard]] std::optional<Token> next();
    /// The next word of the current line; nothing at its end.
    [[nodiscard]] std::optional<Token> nextOnLine();
    void skipLine();
    /// Skips to behind the '}' that closes a '{' already read; false if the text ends before.
    [[nodiscard]] bool skipBlock();

    [[nodiscard]] int line() const { return line_; }
    [[nodiscard]] std::size_t offset() const { return at_; }

private:
    /// Stops at a word or, with `stayOnLine`, at the end of the line; false: there is no word.
    bool skipSpace(bool stayOnLine);
    Token word();

    std::string_view text_;
    std::size_t at_ = 0;
    std::size_t lineStart_ = 0;
    int line_ = 1;
};

/// The number a word starts with, as the game's atof reads it; 0 if there is none or it is not finite.
[[nodiscard]] float toNumber(std::string_view word);
/// The same, but nothing if the word does not start with a finite number. `rest`: what stands behind it.
[[nodiscard]] std::optional<float> leadingNumber(std::string_view text, std::string_view* rest = nullptr);

} // namespace pie::level
