#include "tests/pieview/x_client.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XTest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace pie::test {
namespace {

void pause(int milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds)); }

std::vector<std::string> parts(const std::string& keys) {
    std::vector<std::string> names;
    std::istringstream stream(keys);
    for (std::string name; std::getline(stream, name, '+');) names.push_back(name);
    return names;
}

} // namespace

XClient::XClient(const std::string& display) : display_(XOpenDisplay(display.c_str())) {}

XClient::~XClient() {
    if (display_) XCloseDisplay(display_);
}

void XClient::hold(const std::string& key, bool down) const {
    const KeySym symbol = XStringToKeysym(key.c_str());
    XTestFakeKeyEvent(display_, XKeysymToKeycode(display_, symbol), down ? True : False, 0);
    XSync(display_, False);
}

void XClient::press(const std::string& keys) const {
    const std::vector<std::string> names = parts(keys);
    for (const std::string& name : names) hold(name, true);
    pause(30); // a key that is down for no time is easily missed
    std::for_each(names.rbegin(), names.rend(), [this](const std::string& name) { hold(name, false); });
    pause(20);
}

void XClient::moveTo(int x, int y) const {
    XTestFakeMotionEvent(display_, -1, x, y, 0);
    XSync(display_, False);
    pause(30);
}

void XClient::button(unsigned number, bool down) const {
    XTestFakeButtonEvent(display_, number, down ? True : False, 0);
    XSync(display_, False);
    pause(30);
}

Picture XClient::screen() const {
    XWindowAttributes root{};
    const Window window = DefaultRootWindow(display_);
    XGetWindowAttributes(display_, window, &root);
    XImage* image = XGetImage(display_, window, 0, 0, static_cast<unsigned>(root.width),
                              static_cast<unsigned>(root.height), AllPlanes, ZPixmap);
    if (!image) return {};
    Picture picture{root.width, root.height, {}};
    for (int y = 0; y < root.height; ++y)
        for (int x = 0; x < root.width; ++x) {
            const unsigned long pixel = XGetPixel(image, x, y);
            for (const unsigned shift : {16U, 8U, 0U})
                picture.rgb.push_back(static_cast<std::uint8_t>(pixel >> shift & 0xffU));
        }
    XDestroyImage(image);
    return picture;
}

Picture XClient::screenOnce(const std::function<bool(const Picture&)>& wanted, double seconds) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    Picture seen = screen();
    while (!wanted(seen) && std::chrono::steady_clock::now() < end) {
        pause(30);
        seen = screen();
    }
    return seen;
}

Program::Program(const std::vector<std::string>& command,
                 const std::vector<std::pair<std::string, std::string>>& environment, const std::string& folder) {
    process_ = ::fork();
    if (process_ != 0) return;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
    if (::chdir(folder.c_str()) != 0) ::_exit(126);
    const int silence = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    ::dup2(silence, 1);
    ::dup2(silence, 2);
    std::vector<char*> arguments;
    for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
}

Program::~Program() {
    if (!runs()) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
}

bool Program::runs() {
    if (process_ <= 0) return false;
    int status = 0;
    if (::waitpid(process_, &status, WNOHANG) != process_) return true;
    process_ = -1;
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return false;
}

int Program::wait(double seconds) {
    for (int i = 0; i < seconds * 50 && runs(); ++i) pause(20);
    return runs() ? -1 : status_;
}

double Program::processorSeconds() const {
    std::ifstream file("/proc/" + std::to_string(process_) + "/stat");
    std::string text;
    std::getline(file, text);
    std::istringstream fields(text.substr(text.rfind(')') + 2));
    std::string field;
    constexpr int before = 11; // fields between the name and utime
    for (int i = 0; i < before; ++i) fields >> field;
    double user = 0;
    double system = 0;
    fields >> user >> system;
    return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

} // namespace pie::test
