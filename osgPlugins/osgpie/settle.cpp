#include "osgPlugins/osgpie/settle.h"

#include "osgPlugins/osgpie/callbacks.h"

#include <osg/Geometry>
#include <osg/NodeVisitor>

namespace osgpie {
namespace {

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
    while (node.engine().advance()) {}
    Settle visitor;
    node.accept(visitor);
    node.setUpdateCallback(nullptr);
}

} // namespace osgpie
