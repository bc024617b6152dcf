#pragma once
// A virtual X display for tests that draw.

#include <memory>
#include <string>
#include <sys/types.h>

namespace pie::test {

/// An Xvfb server on a number that was free, stopped with the object. Tests whose `start` returns null skip and name
/// the package xvfb.
class VirtualDisplay {
public:
    [[nodiscard]] static std::unique_ptr<VirtualDisplay> start(int width = 1280, int height = 1024);
    ~VirtualDisplay();
    VirtualDisplay(const VirtualDisplay&) = delete;
    VirtualDisplay& operator=(const VirtualDisplay&) = delete;

    [[nodiscard]] const std::string& name() const { return name_; } ///< ":99", for DISPLAY

private:
    VirtualDisplay(pid_t server, std::string name) : server_(server), name_(std::move(name)) {}
    pid_t server_;
    std::string name_;
};

} // namespace pie::test
