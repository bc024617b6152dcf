#pragma once
// A user at a display: presses keys, moves the mouse, looks at the screen. And the program that is used.

#include "tests/support/picture.h"

#include <functional>
#include <string>
#include <sys/types.h>
#include <utility>
#include <vector>

struct _XDisplay;

namespace pie::test {

class XClient {
public:
    explicit XClient(const std::string& display);
    ~XClient();
    XClient(const XClient&) = delete;
    XClient& operator=(const XClient&) = delete;
    [[nodiscard]] bool works() const { return display_ != nullptr; }

    /// Names as of X: "w", "F3", "question", with "Shift" and "Control_L" before: "Control_L+1".
    void press(const std::string& keys) const;
    void hold(const std::string& key, bool down) const;
    void moveTo(int x, int y) const;
    /// 1 left, 3 right; 4 and 5 are the wheel.
    void button(unsigned number, bool down) const;
    [[nodiscard]] Picture screen() const;
    /// Looks until what is seen is as wanted, at most so long; the last look.
    [[nodiscard]] Picture screenOnce(const std::function<bool(const Picture&)>& wanted, double seconds = 30) const;

private:
    _XDisplay* display_;
};

/// Runs until it is over or the object goes, which kills it.
class Program {
public:
    Program(const std::vector<std::string>& command,
            const std::vector<std::pair<std::string, std::string>>& environment, const std::string& folder);
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    [[nodiscard]] bool runs();
    /// Exit status once it has ended; −1 if it does not within so many seconds.
    [[nodiscard]] int wait(double seconds);
    /// Processor time so far, seconds.
    [[nodiscard]] double processorSeconds() const;

private:
    pid_t process_ = -1;
    int status_ = -1;
};

} // namespace pie::test
