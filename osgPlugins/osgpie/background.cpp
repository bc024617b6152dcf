#include "osgPlugins/osgpie/background.h"

#include <condition_variable>
#include <list>
#include <mutex>

namespace osgpie {
namespace {

class Running {
public:
    using Place = std::list<std::stop_source>::iterator;

    static Running& instance() {
        static Running all;
        return all;
    }
    Running() = default;
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;
    ~Running() {
        std::unique_lock lock(mutex_);
        for (std::stop_source& source : sources_) source.request_stop();
        over_.wait(lock, [this] { return sources_.empty(); });
    }

    Place add(const std::stop_source& source) {
        const std::lock_guard lock(mutex_);
        return sources_.insert(sources_.end(), source);
    }
    void remove(Place place) {
        const std::lock_guard lock(mutex_);
        sources_.erase(place);
        over_.notify_all();
    }

private:
    std::mutex mutex_;
    std::condition_variable over_;
    std::list<std::stop_source> sources_;
};

} // namespace

Background::Background(std::function<void(const std::stop_token&)> job) {
    const std::stop_source ends; // of the program
    const auto place = Running::instance().add(ends);
    thread_ = std::jthread([job = std::move(job), ends, place](const std::stop_token& dropped) {
        const std::stop_callback forward(dropped, [ends]() mutable { ends.request_stop(); });
        job(ends.get_token());
        Running::instance().remove(place);
    });
}

void Background::wait() {
    if (thread_.joinable()) thread_.join();
}

} // namespace osgpie
