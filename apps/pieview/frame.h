#pragma once
// Draws a scene graph as a camera sees it: into the OpenGL context that is current (a window's), or into memory on a
// context of its own. One thread.

#include "apps/support/camera.h"
#include "apps/support/picture_file.h"
#include "pie/core/result.h"

#include <osg/Group>
#include <osgViewer/Viewer>

namespace pieview {

class Frame {
public:
    /// Draws where the current context draws, `width` × `height` pixels from the lower left corner.
    static std::unique_ptr<Frame> inWindow(osg::Group& scene, int width, int height);
    /// Draws into memory alone: see picture(). Needs a display.
    static pie::Result<std::unique_ptr<Frame>> inMemory(osg::Group& scene);

    void look(const apps::Camera& camera, const apps::Lens& lens);
    /// Update and draw at `seconds` of the level's own time.
    void draw(double seconds);
    /// Update without drawing: light gets better for what the last frame showed.
    void update(double seconds);
    /// Draws once more, into memory, of the size that look() was told. `floats`: values beyond 1 stay.
    [[nodiscard]] apps::FloatPicture picture(double seconds, bool floats);
    /// Lets go of what it holds in the graphics card; before the window goes.
    void releaseObjects();

private:
    explicit Frame(osg::Group& scene);
    osgViewer::Viewer viewer_;
    osg::ref_ptr<osg::GraphicsContext> context_;
    osg::ref_ptr<osg::GraphicsContext> window_;
    int width_ = 0, height_ = 0;
};

} // namespace pieview
