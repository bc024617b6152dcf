#pragma once
// Runs a program as a user would and keeps what it says.

#include <string>
#include <utility>
#include <vector>

namespace pie::test {

struct CommandOptions {
    /// Added to this process's environment; an empty value removes the variable.
    std::vector<std::pair<std::string, std::string>> environment;
    std::string folder;          ///< working directory; empty: this process's
    double timeoutSeconds = 300; ///< then the program and its children are killed: long enough under a sanitizer
};

struct CommandResult {
    int status = -1;       ///< exit status; 128 + n when killed by signal n; -1 when it could not be started
    bool timedOut = false; ///< then status is 128 + SIGKILL
    std::string out, err;
    double seconds = 0;
};

/// `command[0]` is searched in PATH. Standard input is empty.
[[nodiscard]] CommandResult run(const std::vector<std::string>& command, const CommandOptions& options = {});

} // namespace pie::test
