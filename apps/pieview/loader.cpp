#include "apps/pieview/loader.h"

#include "osgPlugins/osgpie/load.h"
#include "pie/core/clock.h"
#include "pie/intersect/intersector.h"
#include "pie/scene/scene.h"

#include <array>
#include <chrono>

namespace pieview {

Trace makeTrace(const pie::level::Level& level) {
    struct Solid {
        pie::scene::Scene scene;
        std::unique_ptr<pie::intersect::Intersector> intersector;
    };
    const auto solid = std::make_shared<Solid>();
    solid->scene = pie::scene::makeScene(level);
    solid->intersector = pie::intersect::makeIntersector(pie::intersect::Kind::Embree, solid->scene, level.tree);
    return [solid](const Vec3& origin, const Vec3& direction, float reach) -> std::optional<Obstacle> {
        const std::array<pie::intersect::Ray, 1> ray{{{origin, 0.0F, direction, reach}}};
        std::array<pie::intersect::Hit, 1> hit;
        solid->intersector->closest(ray, hit);
        if (!hit[0].found()) return std::nullopt;
        return Obstacle{hit[0].t, solid->scene.normals[hit[0].triangle]};
    };
}

void Loader::request(const std::string& level, const pie::engine::Settings& settings) {
    Request request{level, settings};
    if (busy_)
        next_ = std::move(request);
    else
        start(std::move(request));
}

void Loader::start(Request request) {
    busy_ = true;
    thread_ = std::jthread([this, request = std::move(request)](const std::stop_token& stop) { work(request, stop); });
}

void Loader::work(const Request& request, const std::stop_token& stop) {
    const auto start = pie::Clock::now();
    LoadedLevel loaded;
    try {
        auto node = osgpie::loadLevelNode(request.level, request.settings);
        if (node)
            loaded.node = *node;
        else
            loaded.error = node.error();
        if (loaded.node && !stop.stop_requested()) loaded.trace = makeTrace(loaded.node->level());
        while (loaded.node && !loaded.node->isComplete() && !stop.stop_requested())
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        if (stop.stop_requested()) return; // the node gives up what it is at
        if (loaded.node) loaded.node->complete();
    } catch (const std::exception& error) {
        loaded.node = nullptr;
        loaded.error = pie::Error{request.level, "", error.what(), ""};
    }
    loaded.milliseconds = pie::millisecondsSince(start);
    {
        const std::lock_guard lock(mutex_);
        done_ = std::move(loaded);
    }
    if (wake_) wake_();
}

bool Loader::cancel() {
    next_.reset();
    if (!busy_) return false;
    thread_.request_stop();
    thread_.join();
    const std::lock_guard lock(mutex_);
    done_.reset();
    busy_ = false;
    return true;
}

std::optional<LoadedLevel> Loader::take() {
    std::optional<LoadedLevel> taken;
    {
        const std::lock_guard lock(mutex_);
        taken.swap(done_);
    }
    if (!taken) return std::nullopt;
    thread_.join();
    busy_ = false;
    if (next_) {
        Request next = std::move(*next_);
        next_.reset();
        start(std::move(next));
    }
    return taken;
}

} // namespace pieview
