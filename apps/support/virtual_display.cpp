#include "apps/support/virtual_display.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <utility>

namespace apps {
namespace {

/// The display number that Xvfb writes once it listens; empty when it ended or stayed silent.
std::string readNumber(int descriptor) {
    std::string text;
    pollfd waiting{descriptor, POLLIN, 0};
    constexpr int patienceMs = 20'000;
    while (poll(&waiting, 1, patienceMs) > 0) {
        std::array<char, 32> part{};
        const ssize_t count = read(descriptor, part.data(), part.size());
        if (count <= 0) return {};
        text.append(part.data(), static_cast<std::size_t>(count));
        if (text.back() == '\n') {
            text.pop_back();
            return text;
        }
    }
    return {};
}

[[noreturn]] void runServer(int numberDescriptor, const std::string& screen) {
    prctl(PR_SET_PDEATHSIG, SIGTERM); // never outlives the program, however that ends
    const int silence = open("/dev/null", O_RDWR);
    dup2(silence, STDOUT_FILENO);
    dup2(silence, STDERR_FILENO);
    const std::string number = std::to_string(numberDescriptor);
    execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", screen.c_str(), "-nolisten", "tcp", "-noreset",
           static_cast<char*>(nullptr));
    _exit(127);
}

} // namespace

pie::Result<VirtualDisplay> VirtualDisplay::start(int width, int height) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) return pie::Error{"", "display", "no pipe to talk to Xvfb", ""};
    const std::string screen = std::to_string(width) + "x" + std::to_string(height) + "x24";
    const pid_t process = fork();
    if (process == 0) {
        close(ends[0]);
        runServer(ends[1], screen);
    }
    close(ends[1]);
    VirtualDisplay display(process);
    const std::string number = process > 0 ? readNumber(ends[0]) : std::string();
    close(ends[0]);
    if (number.empty())
        return pie::Error{"", "display", "there is none and Xvfb could not be started",
                          "set DISPLAY or install the package xvfb"};
    setenv("DISPLAY", (":" + number).c_str(), 1);
    return display;
}

VirtualDisplay::VirtualDisplay(VirtualDisplay&& other) noexcept : process_(std::exchange(other.process_, -1)) {}

VirtualDisplay& VirtualDisplay::operator=(VirtualDisplay&& other) noexcept {
    std::swap(process_, other.process_);
    return *this;
}

VirtualDisplay::~VirtualDisplay() {
    if (process_ <= 0) return;
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
}

} // namespace apps
