#include "osgPlugins/osgpie/initial_view.h"

#include <osg/CameraView>
#include <osgGA/CameraManipulator>
#include <osgGA/EventVisitor>
#include <osgViewer/View>

#include <cmath>

namespace osgpie {
namespace {

struct Home {
    osg::Vec3d eye, centre;
};

/// How far ahead an orbiting manipulator turns about.
constexpr double lookDistance = 256.0;

Home homeOf(const pie::level::Level& level) {
    const auto view = level.firstView();
    const double yaw = osg::DegreesToRadians(static_cast<double>(view.yaw));
    const osg::Vec3d eye(static_cast<double>(view.eye.x), static_cast<double>(view.eye.y),
                         static_cast<double>(view.eye.z));
    return {eye, eye + osg::Vec3d(std::cos(yaw), std::sin(yaw), 0.0) * lookDistance};
}

/// The level is the viewer's scene, or the only thing in it.
bool isWholeScene(const osg::Node* scene, const osg::Node* level) {
    while (scene && scene != level) {
        const osg::Group* group = scene->asGroup();
        scene = group && group->getNumChildren() == 1 ? group->getChild(0) : nullptr;
    }
    return scene == level;
}

class InitialViewCallback : public osg::NodeCallback {
public:
    explicit InitialViewCallback(const Home& home) : home_(home) {}

    void operator()(osg::Node* node, osg::NodeVisitor* visitor) override {
        if (!done_) {
            done_ = true;
            auto* events = dynamic_cast<osgGA::EventVisitor*>(visitor);
            auto* view = events ? dynamic_cast<osgViewer::View*>(events->getActionAdapter()) : nullptr;
            osgGA::CameraManipulator* manipulator = view ? view->getCameraManipulator() : nullptr;
            if (manipulator && manipulator->getAutoComputeHomePosition() && isWholeScene(view->getSceneData(), node)) {
                manipulator->setHomePosition(home_.eye, home_.centre, osg::Vec3d(0, 0, 1));
                manipulator->setAutoComputeHomePosition(false);
                manipulator->home(0.0);
            }
        }
        traverse(node, visitor);
    }

private:
    Home home_;
    bool done_ = false;
};

} // namespace

void addInitialView(LevelNode& node) {
    const Home home = homeOf(node.level());
    osg::ref_ptr view = new osg::CameraView;
    view->setName("first player start");
    view->setPosition(home.eye);
    osg::Quat attitude;
    // A CameraView looks along −z with y up.
    const osg::Matrixd look = osg::Matrixd::lookAt(home.eye, home.centre, osg::Vec3d(0, 0, 1));
    attitude.set(osg::Matrixd::inverse(look));
    view->setAttitude(attitude);
    node.addChild(view);
    node.addEventCallback(new InitialViewCallback(home));
}

} // namespace osgpie
