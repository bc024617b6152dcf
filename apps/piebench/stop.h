#pragma once
// How a program ends before its end: one line, and the exit status.

#include "pie/core/result.h"

#include <string>
#include <utility>

namespace piebench {

enum Exit : int { Done = 0, Failed = 1, Misused = 2 };

struct Stop {
    std::string message;
    Exit status = Failed;
};

/// The value, or Stop.
template <class T> T valueOr(pie::Result<T> result, Exit status = Failed) {
    if (!result) throw Stop{result.error().message(), status};
    return std::move(*result);
}

} // namespace piebench
