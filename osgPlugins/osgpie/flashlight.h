#pragma once
// A spot light that follows the view (the flashlight of pi-engine, fig 6.9): where the eye was when the level was last
// culled, the light is from the next update on. Cull callback of the level's root; several views share the light of
// the one that was culled last.

#include "pie/engine/engine.h"

#include <osg/NodeCallback>
#include <osg/Vec3>

#include <memory>
#include <mutex>
#include <optional>

namespace osgpie {

class Flashlight : public osg::NodeCallback {
public:
    explicit Flashlight(std::shared_ptr<pie::engine::Engine> engine) : engine_(std::move(engine)) {}
    void operator()(osg::Node* node, osg::NodeVisitor* visitor) override;
    /// Moves the light to the view, or puts it out. In the update, before Engine::advance().
    void follow(bool on = true);

private:
    struct View {
        osg::Vec3 eye, look;
        bool operator==(const View&) const = default;
    };
    std::shared_ptr<pie::engine::Engine> engine_;
    std::mutex mutex_; ///< cull and update may be in different threads
    std::optional<View> seen_;
    std::optional<View> lit_;
    std::optional<std::size_t> number_; ///< of the light, in the engine
};

} // namespace osgpie
