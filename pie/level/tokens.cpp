#include "pie/level/tokens.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace pie::level {
namespace {

bool isSpace(char c) { return static_cast<unsigned char>(c) <= ' '; }

} // namespace

bool Tokens::skipSpace(bool stayOnLine) {
    while (at_ < text_.size()) {
        const char c = text_[at_];
        if (c == '\n') {
            if (stayOnLine) return false;
            ++line_;
            lineStart_ = ++at_;
        } else if (c == '\r' && stayOnLine) {
            // The game turns every run of white space that holds a carriage return into a line end (COM_Compress):
            // shipped scripts have lone ones.
            return false;
        } else if (isSpace(c)) {
            ++at_;
        } else if (text_.substr(at_).starts_with("//")) {
            at_ = std::min(text_.find('\n', at_), text_.size());
        } else if (text_.substr(at_).starts_with("/*")) {
            // A comment that is never closed ends with the text, as in the game.
            const std::size_t close = text_.find("*/", at_ + 2);
            const std::size_t end = close == std::string_view::npos ? text_.size() : close + 2;
            for (; at_ < end; ++at_)
                if (text_[at_] == '\n') {
                    ++line_;
                    lineStart_ = at_ + 1;
                }
        } else {
            return true;
        }
    }
    return false;
}

Token Tokens::word() {
    Token token;
    token.line = line_;
    token.column = static_cast<int>(at_ - lineStart_) + 1;
    const std::size_t start = at_;
    if (text_[at_] == '"') {
        const std::size_t close = std::min(text_.find('"', at_ + 1), text_.size());
        token.text = text_.substr(at_ + 1, close - at_ - 1);
        token.quoted = true;
        for (; at_ < std::min(close + 1, text_.size()); ++at_)
            if (text_[at_] == '\n') {
                ++line_;
                lineStart_ = at_ + 1;
            }
        return token;
    }
    // The game strips comments before it splits words, so they end a word even without white space before them.
    while (at_ < text_.size() && !isSpace(text_[at_]) &&
           !(text_[at_] == '/' && at_ + 1 < text_.size() && (text_[at_ + 1] == '/' || text_[at_ + 1] == '*')))
        ++at_;
    token.text = text_.substr(start, at_ - start);
    return token;
}

std::optional<Token> Tokens::next() {
    if (!skipSpace(false)) return std::nullopt;
    return word();
}

std::optional<Token> Tokens::nextOnLine() {
    if (!skipSpace(true)) return std::nullopt;
    return word();
}

void Tokens::skipLine() { at_ = std::min(text_.find_first_of("\r\n", at_), text_.size()); }

/// What next() would find, without making words of it: a level uses a few dozen of thousands of definitions.
bool Tokens::skipBlock() {
    const auto commentAt = [this](std::size_t i) {
        return text_[i] == '/' && i + 1 < text_.size() && (text_[i + 1] == '/' || text_[i + 1] == '*');
    };
    int depth = 1;
    while (at_ < text_.size()) {
        const char c = text_[at_];
        if (c == '\n') {
            ++line_;
            lineStart_ = ++at_;
        } else if (isSpace(c)) {
            ++at_;
        } else if (commentAt(at_)) {
            if (!skipSpace(false)) return false;
        } else if (c == '"') {
            static_cast<void>(word());
        } else {
            const std::size_t start = at_++;
            while (at_ < text_.size() && !isSpace(text_[at_]) && !commentAt(at_)) ++at_;
            if (at_ - start > 1) continue;
            if (c == '{') ++depth;
            if (c == '}' && --depth == 0) return true;
        }
    }
    return false;
}

std::optional<float> leadingNumber(std::string_view text, std::string_view* rest) {
    while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
    std::string_view digits = text;
    // from_chars knows no plus sign, the game's atof does.
    if (digits.starts_with('+')) digits.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (end == digits.data()) return std::nullopt;
    if (rest != nullptr) *rest = std::string_view(end, static_cast<std::size_t>(digits.data() + digits.size() - end));
    if (error != std::errc() || !std::isfinite(static_cast<float>(value))) return std::nullopt;
    return static_cast<float>(value);
}

float toNumber(std::string_view word) { return leadingNumber(word).value_or(0.0F); }

} // namespace pie::level
