#pragma once
// A level as a node: grouped Geodes that follow the level's spatial tree, an update callback that drives the photon
// tracer, and draw callbacks that fetch the light of what survived culling. Add the node to any scene; nothing else is
// needed.

#include "pie/engine/engine.h"

#include <osg/Group>

#include <memory>

namespace osgpie {

class LevelNode : public osg::Group {
public:
    explicit LevelNode(std::shared_ptr<pie::engine::Engine> engine) : engine_(std::move(engine)) {}
    [[nodiscard]] pie::engine::Engine& engine() { return *engine_; }
    [[nodiscard]] const pie::engine::Engine& engine() const { return *engine_; }
    // Class names stay those of osg::Group: that is what a file format may write it as.

protected:
    ~LevelNode() override = default;

private:
    std::shared_ptr<pie::engine::Engine> engine_;
};

/// Builds the scene graph for what `engine` was made from. The graph shares the level's pictures and the engine's
/// light.
[[nodiscard]] osg::ref_ptr<LevelNode> makeLevelNode(std::shared_ptr<pie::engine::Engine> engine);

} // namespace osgpie
