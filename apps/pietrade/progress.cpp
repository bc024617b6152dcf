#include "apps/pietrade/progress.h"

#include <fmt/format.h>

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace pietrade {
namespace {

std::size_t terminalWidth() {
    winsize size{};
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col - 1U : 79U;
}

} // namespace

std::string duration(double seconds) {
    const auto all = static_cast<long>(std::ceil(std::max(0.0, seconds)));
    if (all >= 3600) return fmt::format("{} h {:02} min", all / 3600, all % 3600 / 60);
    if (all >= 60) return fmt::format("{} min {:02} s", all / 60, all % 60);
    return fmt::format("{} s", all);
}

std::string bar(std::size_t done, std::size_t all, double secondsLeft, std::string_view what, std::size_t width) {
    constexpr std::size_t length = 20;
    const std::size_t full = all == 0 ? length : std::min(length, length * done / all);
    std::string text = fmt::format("[{}{}] {}/{}", std::string(full, '#'), std::string(length - full, '.'), done, all);
    if (std::isfinite(secondsLeft)) text += fmt::format(", {} left", duration(secondsLeft));
    if (!what.empty()) text += fmt::format(": {}", what);
    if (text.size() > width) text.resize(width);
    return text;
}

void Progress::begin(std::size_t all, std::size_t done) {
    all_ = all;
    done_ = free_ = done;
    start_ = pie::Clock::now();
}

double Progress::secondsLeft() const {
    const std::size_t measured = done_ - free_;
    if (measured == 0) return std::nan("");
    return 1e-3 * pie::millisecondsSince(start_) / static_cast<double>(measured) * static_cast<double>(all_ - done_);
}

void Progress::clear() {
    if (shown_) fmt::print(stderr, "\r\x1b[K");
    shown_ = false;
}

void Progress::step(std::string_view what) {
    what_ = what;
    if (kind_ != Kind::Bar) return;
    clear();
    fmt::print(stderr, "{}", bar(done_, all_, secondsLeft(), what, terminalWidth()));
    std::fflush(stderr);
    shown_ = true;
}

void Progress::done(std::string_view result) {
    done_ = std::min(done_ + 1, all_);
    if (kind_ == Kind::Lines) {
        const double left = secondsLeft();
        fmt::print(stderr, "pietrade: {}/{} {}: {}{}\n", done_, all_, what_, result,
                   std::isfinite(left) && done_ < all_ ? fmt::format("; {} left", duration(left)) : "");
    }
}

void Progress::reach(std::size_t done, std::string_view what) {
    done_ = done;
    constexpr double pause = 5000; // ms
    if (kind_ == Kind::Bar) {
        step(what);
    } else if (kind_ == Kind::Lines && (done == all_ || pie::millisecondsSince(line_) > pause)) {
        fmt::print(stderr, "pietrade: {}/{} {}\n", done, all_, what);
        line_ = pie::Clock::now();
    }
}

void Progress::say(std::string_view line) {
    clear();
    if (kind_ != Kind::None) fmt::print(stderr, "pietrade: {}\n", line);
}

Progress::~Progress() { clear(); }

} // namespace pietrade
