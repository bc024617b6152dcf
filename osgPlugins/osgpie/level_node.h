#pragma once
// A level as a node: grouped Geodes that follow the level's spatial tree, an update callback that drives the photon
// tracer, and draw callbacks that fetch the light of what survived culling. Add the node to any scene; nothing else is
// needed.
//
// A level that is to be lit is drawn refined. Refinement takes longer than reading, so it goes on in a thread of its
// own once the node is there: the node holds the level as it is in the file, whole and with every picture, but without
// our light. The first update puts the refined level in its place, before anything is drawn. Who wants it sooner calls
// complete(). A node that is dropped before gives up the work.

#include "osgPlugins/osgpie/view_switch.h"
#include "pie/engine/engine.h"

#include <osg/Group>

#include <memory>

namespace osgpie {

class RefinedWorld;

class LevelNode : public osg::Group {
public:
    explicit LevelNode(std::shared_ptr<pie::engine::Engine> engine);
    [[nodiscard]] const pie::level::Level& level() const { return engine_->level(); }
    /// Waits for refinement, without showing it.
    [[nodiscard]] pie::engine::Engine& engine();
    /// Whether complete() would return at once.
    [[nodiscard]] bool isComplete() const;
    /// Changes views while the level is shown; null unless the settings have `switch_views` or a view that needs it.
    [[nodiscard]] ViewSwitch* views() { return views_.get(); }
    /// Called by makeLevelNode.
    void setViews(std::shared_ptr<ViewSwitch> views) { views_ = std::move(views); }
    /// Waits for refinement and shows the level refined; done already, it returns at once. For the thread that may
    /// change the scene graph: the one that read the node until it is part of a scene, later the update.
    void complete();
    /// The level is refined by `world`, which is shown in place of what the node holds. Called by makeLevelNode.
    void completeLater(std::unique_ptr<RefinedWorld> world);
    // Class names stay those of osg::Group: that is what a file format may write it as.

protected:
    ~LevelNode() override;

private:
    std::shared_ptr<pie::engine::Engine> engine_;
    std::shared_ptr<ViewSwitch> views_;
    std::unique_ptr<RefinedWorld> refined_; ///< null: nothing to wait for
};

/// Builds the scene graph for what `engine` was made from; if that is not refined yet, starts to refine it. The graph
/// shares the level's pictures and the engine's light.
[[nodiscard]] osg::ref_ptr<LevelNode> makeLevelNode(std::shared_ptr<pie::engine::Engine> engine);

} // namespace osgpie
