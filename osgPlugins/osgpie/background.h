#pragma once
// One job in a thread of its own: it may be asked to stop, and is over before whoever started it goes away. Jobs that
// are still running when the program ends are asked to stop and waited for, before anything static that they use goes.

#include <functional>
#include <stop_token>
#include <thread>

namespace osgpie {

class Background {
public:
    /// The job returns soon after a stop was requested, and does not throw.
    explicit Background(std::function<void(const std::stop_token&)> job);
    Background(const Background&) = delete;
    Background& operator=(const Background&) = delete;
    /// Asks the job to stop and waits for it.
    ~Background() = default;
    /// Waits for the job. One thread at a time.
    void wait();

private:
    std::jthread thread_;
};

} // namespace osgpie
