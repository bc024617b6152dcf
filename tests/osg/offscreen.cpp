#include "tests/osg/offscreen.h"

#include "tests/support/display.h"

#include <osgUtil/Optimizer>

#include <cmath>
#include <cstdlib>
#include <mutex>

namespace pie::test {
namespace {

/// Copies each finished frame. Called by the thread that draws, of one context each.
class Capture : public osg::Camera::DrawCallback {
public:
    explicit Capture(std::vector<Picture>& pictures) : pictures_(&pictures) {}
    void operator()(osg::RenderInfo& info) const override {
        const osg::Viewport* viewport = info.getCurrentCamera()->getViewport();
        const int width = static_cast<int>(viewport->width());
        const int height = static_cast<int>(viewport->height());
        const osg::ref_ptr image = new osg::Image;
        image->readPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, 1);
        Picture picture{width, height, {}};
        for (int row = height - 1; row >= 0; --row) {
            const unsigned char* first = image->data(0, static_cast<unsigned>(row));
            picture.rgb.insert(picture.rgb.end(), first, first + std::ptrdiff_t{3} * width);
        }
        pictures_->push_back(std::move(picture));
    }

private:
    std::vector<Picture>* pictures_;
};

osg::ref_ptr<osg::Camera> makeCamera(const Shot& shot, osg::GraphicsContext* context, std::vector<Picture>& pictures) {
    osg::ref_ptr camera = new osg::Camera;
    camera->setGraphicsContext(context);
    camera->setViewport(new osg::Viewport(0, 0, shot.width, shot.height));
    camera->setDrawBuffer(GL_FRONT);
    camera->setReadBuffer(GL_FRONT);
    camera->setFinalDrawCallback(new Capture(pictures));
    return camera;
}

osg::ref_ptr<osg::GraphicsContext> makePixelBuffer(int width, int height) {
    const osg::ref_ptr traits = new osg::GraphicsContext::Traits;
    traits->readDISPLAY();
    traits->width = width;
    traits->height = height;
    traits->pbuffer = true;
    traits->doubleBuffer = false;
    return osg::GraphicsContext::createGraphicsContext(traits);
}

} // namespace

const std::string& ownDisplay() {
    // Never taken down: OpenGL closes its connection when the process ends, and the server ends with the process.
    static const std::string name = [] {
        static VirtualDisplay* display = VirtualDisplay::start().release();
        if (!display) return std::string();
        ::setenv("DISPLAY", display->name().c_str(), 1);
        // A server that loses its last client starts anew, and refuses new ones meanwhile: one client stays.
        static osg::GraphicsContext* client = makePixelBuffer(1, 1).release();
        return client ? display->name() : std::string();
    }();
    return name;
}

osg::ref_ptr<osg::GraphicsContext> makeContext(int width, int height) {
    return ownDisplay().empty() ? nullptr : makePixelBuffer(width, height);
}

Shot fromAbove(double left, double right, double bottom, double top) {
    constexpr double high = 4096;
    Shot shot;
    shot.view = osg::Matrixd::lookAt(osg::Vec3d(0, 0, high), osg::Vec3d(), osg::Vec3d(0, 1, 0));
    shot.projection = osg::Matrixd::ortho(left, right, bottom, top, 1, 2 * high);
    return shot;
}

Shot lookingAt(const osg::Vec3d& eye, const osg::Vec3d& centre) {
    Shot shot;
    const double aspect = static_cast<double>(shot.width) / shot.height;
    shot.view = osg::Matrixd::lookAt(eye, centre, osg::Vec3d(0, 0, 1));
    shot.projection = osg::Matrixd::perspective(osg::RadiansToDegrees(2 * std::atan(1 / aspect)), aspect, 1, 10'000);
    return shot;
}

std::vector<std::vector<Picture>> renderFrames(osg::Node& scene, const Shot& shot) {
    if (shot.optimize) osgUtil::Optimizer().optimize(&scene);
    std::vector<std::vector<Picture>> pictures(static_cast<std::size_t>(shot.contexts));
    osgViewer::Viewer viewer;
    viewer.setThreadingModel(shot.threading);
    viewer.setLightingMode(osg::View::NO_LIGHT);
    viewer.getCamera()->setViewMatrix(shot.view);
    viewer.getCamera()->setProjectionMatrix(shot.projection);
    viewer.getCamera()->setComputeNearFarMode(osg::Camera::DO_NOT_COMPUTE_NEAR_FAR);
    viewer.getCamera()->setClearColor({0, 0, 0, 1});
    for (auto& frames : pictures) {
        const osg::ref_ptr<osg::GraphicsContext> context = makeContext(shot.width, shot.height);
        if (!context) return {};
        viewer.addSlave(makeCamera(shot, context, frames), osg::Matrixd(), osg::Matrixd());
    }
    viewer.setSceneData(&scene);

    for (int i = 0; i < shot.frames; ++i) viewer.frame(0.0);
    viewer.stopThreading();
    return pictures;
}

Picture render(osg::Node& scene, const Shot& shot) {
    const auto pictures = renderFrames(scene, shot);
    return pictures.empty() || pictures.front().empty() ? Picture{} : pictures.front().back();
}

} // namespace pie::test
