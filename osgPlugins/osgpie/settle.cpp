#include "osgPlugins/osgpie/settle.h"

#include "osgPlugins/osgpie/callbacks.h"

#include <osg/Geometry>
#include <osg/NodeVisitor>

namespace osgpie {
namespace {

/// Refines the light of every lit drawable to the end.
class Finish : public osg::NodeVisitor {
public:
    explicit Finish(pie::engine::Engine& engine) : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN), engine_(engine) {}
    void apply(osg::Geometry& geometry) override {
        if (const auto* callback = dynamic_cast<const IrradianceCallback*>(geometry.getDrawCallback()))
            engine_.finish(callback->receivers());
    }

private:
    pie::engine::Engine& engine_;
};

/// Fetches the light of every lit drawable once and for all.
class Settle : public osg::NodeVisitor {
public:
    Settle() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
    void apply(osg::Geometry& geometry) override {
        const auto* callback = dynamic_cast<const IrradianceCallback*>(geometry.getDrawCallback());
        if (!callback) return;
        callback->refresh();
        geometry.setDrawCallback(nullptr);
        geometry.setDataVariance(osg::Object::STATIC);
    }
};

} // namespace

void settle(LevelNode& node) {
    node.complete();
    node.engine().prepare();
    Finish finish(node.engine());
    node.accept(finish);
    while (node.engine().advance()) {}
    Settle visitor;
    node.accept(visitor);
    node.setUpdateCallback(nullptr);
    node.setCullCallback(nullptr); // the flashlight
}

} // namespace osgpie
