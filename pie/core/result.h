#pragma once
// Errors are values at the door: a function that can fail on user input returns Result<T>. Exceptions may be used
// inside a source file; they never leave a module.

#include <string>
#include <utility>
#include <variant>

namespace pie {

/// What went wrong, in the four parts a user needs. `message()` joins them into one line.
struct Error {
    std::string file;   ///< as the user named it; empty when no file is concerned
    std::string place;  ///< lump and index, line and column, setting; may be empty
    std::string reason; ///< what is wrong
    std::string remedy; ///< what to do; may be empty

    [[nodiscard]] std::string message() const {
        std::string text = file;
        for (const std::string* part : {&place, &reason})
            if (!part->empty()) text += (text.empty() ? "" : ": ") + *part;
        if (!remedy.empty()) text += " (" + remedy + ")";
        return text;
    }
};

/// A value or an Error. `*result` is only allowed when `result` is true.
template <class T> class [[nodiscard]] Result {
public:
    Result(T value) : state_(std::move(value)) {}     // NOLINT(google-explicit-constructor): return value;
    Result(Error error) : state_(std::move(error)) {} // NOLINT(google-explicit-constructor): return Error{…};

    [[nodiscard]] explicit operator bool() const { return std::holds_alternative<T>(state_); }
    [[nodiscard]] T& operator*() & { return std::get<T>(state_); }
    [[nodiscard]] const T& operator*() const& { return std::get<T>(state_); }
    [[nodiscard]] T&& operator*() && { return std::get<T>(std::move(state_)); }
    [[nodiscard]] T* operator->() { return &std::get<T>(state_); }
    [[nodiscard]] const T* operator->() const { return &std::get<T>(state_); }
    [[nodiscard]] const Error& error() const { return std::get<Error>(state_); }

private:
    std::variant<T, Error> state_;
};

} // namespace pie
