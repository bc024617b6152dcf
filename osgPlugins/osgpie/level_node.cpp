#include "osgPlugins/osgpie/level_node.h"

#include "osgPlugins/osgpie/callbacks.h"
#include "osgPlugins/osgpie/sprites.h"
#include "osgPlugins/osgpie/state_sets.h"
#include "osgPlugins/osgpie/world.h"

namespace osgpie {

LevelNode::LevelNode(std::shared_ptr<pie::engine::Engine> engine) : engine_(std::move(engine)) {}

LevelNode::~LevelNode() = default;

pie::engine::Engine& LevelNode::engine() {
    if (refined_) refined_->wait();
    return *engine_;
}

bool LevelNode::isComplete() const { return !refined_ || refined_->isDone(); }

void LevelNode::complete() {
    if (!refined_) return;
    refined_->show();
    refined_.reset();
}

void LevelNode::completeLater(std::unique_ptr<RefinedWorld> world) { refined_ = std::move(world); }

osg::ref_ptr<LevelNode> makeLevelNode(std::shared_ptr<pie::engine::Engine> engine) {
    osg::ref_ptr root = new LevelNode(engine);
    const pie::level::Level& level = engine->level();
    const auto& settings = engine->settings();
    auto states = std::make_unique<StateSets>(engine->sharedLevel(), settings);
    root->setName(level.name);
    osg::ref_ptr place = new osg::Group;
    World world = makeWorld(engine, *states);
    world.attachStates();
    if (engine->refined()) {
        if (world.root) root->addChild(world.root);
    } else {
        place->setName("level");
        // A described group is one that OSG's optimiser keeps.
        place->addDescription("refined by the first update");
        if (world.root) place->addChild(world.root);
        root->addChild(place);
    }
    if (const osg::ref_ptr<osg::Node> sprites = makeSprites(level, *states, largestLight(settings)))
        root->addChild(sprites);
    const osg::ref_ptr<osg::Node> sky = states->makeSky();
    if (sky) root->addChild(sky);
    const std::shared_ptr<ViewSwitch> views = states->viewSwitch();
    if (views) {
        views->attach(*root, engine, engine->refined() ? world.root : osg::ref_ptr<osg::Node>(place), sky);
        root->setViews(views);
    }
    if (settings.showsOurLight()) {
        osg::ref_ptr<Flashlight> flashlight;
        if (views) views->setFlashlight(settings.flashlight);
        if (settings.flashlight || views) root->addCullCallback(flashlight = new Flashlight(engine));
        root->addUpdateCallback(new AdvanceCallback(engine, flashlight, views));
    }
    if (!engine->refined())
        root->completeLater(std::make_unique<RefinedWorld>(std::move(engine), std::move(states), std::move(place)));
    return root;
}

} // namespace osgpie
