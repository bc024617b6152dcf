#include "tests/support/display.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace pie::test {
namespace {

/// The number that the server writes when it is ready; empty when it ends or stays silent instead.
std::string readNumber(int pipe) {
    constexpr int patienceMilliseconds = 20'000;
    std::string number;
    for (;;) {
        pollfd wait{pipe, POLLIN, 0};
        const int ready = ::poll(&wait, 1, patienceMilliseconds);
        if (ready < 0 && errno == EINTR) continue;
        char c = 0;
        if (ready <= 0 || ::read(pipe, &c, 1) != 1) return {};
        if (c == '\n') return number;
        number += c;
    }
}

void stop(pid_t server) {
    ::kill(server, SIGTERM);
    ::waitpid(server, nullptr, 0);
}

} // namespace

std::unique_ptr<VirtualDisplay> VirtualDisplay::start(int width, int height) {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0) return nullptr;
    const std::string screen = std::to_string(width) + "x" + std::to_string(height) + "x24";
    const pid_t parent = ::getpid();
    const pid_t server = ::fork();
    if (server == 0) {
        // Ends with the test even when that is killed.
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);
        const int silence = ::open("/dev/null", O_RDWR | O_CLOEXEC);
        constexpr int readyPipe = 3;
        if (::getppid() == parent && ::dup2(silence, 1) >= 0 && ::dup2(silence, 2) >= 0 &&
            ::dup2(pipe[1], readyPipe) >= 0 && (pipe[1] != readyPipe || ::fcntl(readyPipe, F_SETFD, 0) == 0))
            ::execlp("Xvfb", "Xvfb", "-displayfd", "3", "-screen", "0", screen.c_str(), "-nolisten", "tcp", "-noreset",
                     static_cast<char*>(nullptr));
        ::_exit(127);
    }
    ::close(pipe[1]);
    const std::string number = server > 0 ? readNumber(pipe[0]) : std::string();
    ::close(pipe[0]);
    if (number.empty()) {
        if (server > 0) stop(server);
        return nullptr;
    }
    return std::unique_ptr<VirtualDisplay>(new VirtualDisplay(server, ":" + number));
}

VirtualDisplay::~VirtualDisplay() { stop(server_); }

} // namespace pie::test
