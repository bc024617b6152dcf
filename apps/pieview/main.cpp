// pieview: the level author's window. See doc/manual.md.

#include "apps/pieview/arguments.h"
#include "apps/pieview/headless.h"
#include "apps/pieview/window.h"

#include <osg/Notify>

#include <cstdio>
#include <exception>

namespace {

/// What OSG and the level's reader say goes to standard error: standard output is for statistics.
class ToStandardError : public osg::NotifyHandler {
public:
    void notify(osg::NotifySeverity /*severity*/, const char* message) override { std::fputs(message, stderr); }
};

} // namespace

int main(int argc, char** argv) {
    osg::setNotifyHandler(new ToStandardError);
    try {
        const auto arguments = pieview::readArguments(argc, argv);
        if (const int* status = std::get_if<int>(&arguments)) return *status;
        const auto& wanted = std::get<pieview::Arguments>(arguments);
        return wanted.headless() ? pieview::runHeadless(wanted) : pieview::runWindow(wanted);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "pieview: %s\n", error.what());
        return 1;
    }
}
