#include "tests/support/command.h"

#include "tests/support/files.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace pie::test {
namespace {

using Clock = std::chrono::steady_clock;

std::vector<std::string> mergedEnvironment(const CommandOptions& options) {
    std::vector<std::string> all;
    for (char** entry = environ; *entry != nullptr; ++entry) {
        const std::string text = *entry;
        bool replaced = false;
        for (const auto& [name, value] : options.environment) replaced = replaced || text.starts_with(name + "=");
        if (!replaced) all.push_back(text);
    }
    for (const auto& [name, value] : options.environment) {
        if (value.empty()) continue;
        std::string entry = name;
        entry += '=';
        entry += value;
        all.push_back(std::move(entry));
    }
    return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
    std::vector<char*> list;
    list.reserve(texts.size() + 1);
    for (std::string& text : texts) list.push_back(text.data());
    list.push_back(nullptr);
    return list;
}

/// Between fork and exec: only what is safe there although the parent has threads.
[[noreturn]] void become(char* const* arguments, char* const* environment, const char* folder, const char* out,
                         const char* err) {
    constexpr mode_t mode = 0600;
    ::setpgid(0, 0);
    const int input = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    const int output = ::open(out, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode);
    const int errors = ::open(err, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode);
    if (input >= 0 && output >= 0 && errors >= 0 && ::dup2(input, 0) >= 0 && ::dup2(output, 1) >= 0 &&
        ::dup2(errors, 2) >= 0 && (*folder == '\0' || ::chdir(folder) == 0))
        ::execvpe(arguments[0], arguments, environment);
    ::_exit(127);
}

/// Waits for the child; false when it had to be killed.
bool await(pid_t child, Clock::time_point deadline, int& state) {
    for (;;) {
        const pid_t ended = ::waitpid(child, &state, WNOHANG);
        if (ended == child) return true;
        if (ended < 0 && errno != EINTR) return true;
        if (Clock::now() >= deadline) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ::kill(-child, SIGKILL);
    ::waitpid(child, &state, 0);
    return false;
}

} // namespace

CommandResult run(const std::vector<std::string>& command, const CommandOptions& options) {
    CommandResult result;
    if (command.empty()) return result;
    const TemporaryFolder folder;
    const std::string out = folder.path() / "out";
    const std::string err = folder.path() / "err";
    std::vector<std::string> arguments = command;
    std::vector<std::string> environment = mergedEnvironment(options);
    const std::vector<char*> argumentList = pointers(arguments);
    const std::vector<char*> environmentList = pointers(environment);

    const Clock::time_point start = Clock::now();
    const pid_t child = ::fork();
    if (child < 0) return result;
    if (child == 0)
        become(argumentList.data(), environmentList.data(), options.folder.c_str(), out.c_str(), err.c_str());
    ::setpgid(child, child); // whichever of the two comes first
    int state = 0;
    const auto limit =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options.timeoutSeconds));
    result.timedOut = !await(child, start + limit, state);
    result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    result.status = WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
    result.out = readText(out);
    result.err = readText(err);
    return result;
}

} // namespace pie::test
