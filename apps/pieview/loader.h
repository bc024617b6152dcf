#pragma once
// Reads levels behind the window. A level comes out whole: refined, its light prepared, ready to be shown in the next
// frame. request() during a load is not lost: that load is finished and shown, then the level is read once more.

#include "apps/pieview/walk.h"
#include "osgPlugins/osgpie/level_node.h"
#include "pie/core/result.h"
#include "pie/engine/settings.h"

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace pieview {

/// What is solid in a level.
[[nodiscard]] Trace makeTrace(const pie::level::Level& level);

struct LoadedLevel {
    osg::ref_ptr<osgpie::LevelNode> node; ///< null: `error` says why
    std::optional<pie::Error> error;
    Trace trace;
    double milliseconds = 0;
};

class Loader {
public:
    /// `wake` is called by the loading thread when something is to be taken.
    explicit Loader(std::function<void()> wake = {}) : wake_(std::move(wake)) {}
    /// Gives up what is being loaded.
    ~Loader() { cancel(); }
    Loader(const Loader&) = delete;
    Loader& operator=(const Loader&) = delete;

    void request(const std::string& level, const pie::engine::Settings& settings);
    /// Gives up what is being loaded and what was requested meanwhile. Returns whether there was anything.
    bool cancel();
    [[nodiscard]] bool busy() const { return busy_; }
    /// What has been loaded since; starts what was requested meanwhile.
    [[nodiscard]] std::optional<LoadedLevel> take();

private:
    struct Request {
        std::string level;
        pie::engine::Settings settings;
    };
    void start(Request request);
    void work(const Request& request, const std::stop_token& stop);

    std::function<void()> wake_;
    std::optional<Request> next_;
    bool busy_ = false;
    std::mutex mutex_;
    std::optional<LoadedLevel> done_; ///< under the mutex
    std::jthread thread_;             ///< last: it ends before what it writes to
};

} // namespace pieview
