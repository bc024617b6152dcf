#include "apps/pieview/frame.h"

#include <osg/Math>
#include <osgViewer/Renderer>

#include <cmath>
#include <cstring>
#include <limits>

namespace pieview {
namespace {

osg::Vec3d vector(const pie::Vec3& v) { return {double{v.x}, double{v.y}, double{v.z}}; }

void setUpAgain(osg::Camera& camera) {
    if (auto* renderer = dynamic_cast<osgViewer::Renderer*>(camera.getRenderer()))
        renderer->setCameraRequiresSetUp(true);
}

osg::ref_ptr<osg::Image> makeTarget(int width, int height, bool floats) {
    osg::ref_ptr image = new osg::Image;
    image->allocateImage(width, height, 1, GL_RGBA, floats ? GL_FLOAT : GL_UNSIGNED_BYTE);
    image->setInternalTextureFormat(floats ? GL_RGBA32F_ARB : GL_RGBA8);
    return image;
}

/// Every pixel is the mean of this many in either direction: smooth edges, on any driver and in floats, too.
constexpr int finer = 2;

float channelAt(const osg::Image& image, int column, int row, std::size_t channel, bool floats) {
    const unsigned char* at = image.data(static_cast<unsigned>(column), static_cast<unsigned>(row));
    if (!floats) return static_cast<float>(at[channel]) / 255.0F;
    float value = 0;
    std::memcpy(&value, at + channel * sizeof(float), sizeof(float));
    return value;
}

/// `image` is `finer` times as large, with its first row at the bottom.
apps::FloatPicture pictureOf(const osg::Image& image, bool floats) {
    apps::FloatPicture picture{image.s() / finer, image.t() / finer, {}};
    for (int y = picture.height - 1; y >= 0; --y)
        for (int x = 0; x < picture.width; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                float sum = 0;
                for (int i = 0; i < finer * finer; ++i)
                    sum += channelAt(image, finer * x + i % finer, finer * y + i / finer, c, floats);
                picture.rgb.push_back(sum / (finer * finer));
            }
    return picture;
}

} // namespace

Frame::Frame(osg::Group& scene) {
    viewer_.setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
    viewer_.setLightingMode(osg::View::NO_LIGHT);
    viewer_.setKeyEventSetsDone(0);
    viewer_.setReleaseContextAtEndOfFrameHint(false);
    viewer_.getCamera()->setClearColor({0, 0, 0, 1});
    viewer_.setSceneData(&scene);
}

std::unique_ptr<Frame> Frame::inWindow(osg::Group& scene, int width, int height) {
    std::unique_ptr<Frame> frame(new Frame(scene));
    frame->window_ = frame->viewer_.setUpViewerAsEmbeddedInWindow(0, 0, width, height);
    frame->viewer_.realize();
    return frame;
}

pie::Result<std::unique_ptr<Frame>> Frame::inMemory(osg::Group& scene) {
    const osg::ref_ptr traits = new osg::GraphicsContext::Traits;
    traits->readDISPLAY();
    traits->width = traits->height = 16;
    traits->pbuffer = true;
    std::unique_ptr<Frame> frame(new Frame(scene));
    frame->context_ = osg::GraphicsContext::createGraphicsContext(traits);
    if (!frame->context_)
        return pie::Error{"", "display", "no OpenGL context",
                          "is DISPLAY right, and are Mesa's drivers installed: package libgl1-mesa-dri?"};
    frame->viewer_.getCamera()->setGraphicsContext(frame->context_);
    frame->viewer_.getCamera()->setViewport(0, 0, 16, 16);
    frame->viewer_.realize();
    return frame;
}

void Frame::look(const apps::Camera& camera, const apps::Lens& lens) {
    osg::Camera& view = *viewer_.getCamera();
    if (lens.width != width_ || lens.height != height_) {
        width_ = lens.width;
        height_ = lens.height;
        if (window_) window_->resized(0, 0, width_, height_);
        view.setViewport(0, 0, width_, height_);
    }
    const double vertical = 2 * std::atan(double{lens.half().y});
    view.setProjectionMatrixAsPerspective(osg::RadiansToDegrees(vertical), double{lens.aspect()}, 1.0, 10'000.0);
    view.setViewMatrixAsLookAt(vector(camera.eye), vector(camera.eye + apps::ahead(camera)),
                               vector(apps::above(camera)));
}

void Frame::draw(double seconds) { viewer_.frame(seconds); }

void Frame::update(double seconds) {
    viewer_.advance(seconds);
    viewer_.updateTraversal();
}

apps::FloatPicture Frame::picture(double seconds, bool floats) {
    osg::Camera& view = *viewer_.getCamera();
    const osg::ref_ptr<osg::Image> image = makeTarget(finer * width_, finer * height_, floats);
    view.setViewport(0, 0, finer * width_, finer * height_);
    view.setRenderTargetImplementation(osg::Camera::FRAME_BUFFER_OBJECT);
    view.attach(osg::Camera::COLOR_BUFFER, image);
    setUpAgain(view);
    viewer_.frame(seconds);
    view.detach(osg::Camera::COLOR_BUFFER);
    view.setRenderTargetImplementation(osg::Camera::FRAME_BUFFER);
    view.setViewport(0, 0, width_, height_);
    setUpAgain(view);
    return pictureOf(*image, floats);
}

void Frame::releaseObjects() { viewer_.getCamera()->releaseGLObjects(); }

} // namespace pieview
