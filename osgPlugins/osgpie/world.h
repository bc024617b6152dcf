#pragma once
// The drawables of a level's mesh, cell by cell. Not for use outside osgPlugins/osgpie.

#include "osgPlugins/osgpie/background.h"
#include "osgPlugins/osgpie/state_sets.h"
#include "pie/engine/engine.h"

#include <osg/Geometry>
#include <osg/Group>

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

namespace osgpie {

/// Drawables without their states: OSG notes in a state which drawables have it, and states are shared with a graph
/// that other threads may be at work on. `attachStates` puts them in.
struct World {
    osg::ref_ptr<osg::Node> root; ///< null: nothing is drawn
    std::vector<std::pair<osg::ref_ptr<osg::Geometry>, osg::ref_ptr<osg::StateSet>>> states;

    void attachStates();
};

/// What is drawn of engine->mesh() as it is now. Where the engine is refined and shows our light, drawables get theirs
/// by callbacks. `states` must know every state beforehand when this is not the thread that made them.
[[nodiscard]] World makeWorld(const std::shared_ptr<pie::engine::Engine>& engine, StateSets& states);

/// Makes the world of the refined level in the background, and prepares its light.
class RefinedWorld {
public:
    /// `place` holds the world that is shown until then.
    RefinedWorld(std::shared_ptr<pie::engine::Engine> engine, std::unique_ptr<StateSets> states,
                 const osg::ref_ptr<osg::Group>& place);
    void wait() { job_.wait(); }
    [[nodiscard]] bool isDone() const { return done_; }
    /// Waits, and puts the refined world in its place.
    void show();

private:
    void work(const std::stop_token& stop);

    std::shared_ptr<pie::engine::Engine> engine_;
    std::unique_ptr<StateSets> states_;
    osg::ref_ptr<osg::Group> place_;
    World world_;
    std::string failure_;
    std::atomic<bool> done_{false};
    Background job_; ///< last: it ends before what it works on
};

} // namespace osgpie
