#pragma once
// Drawing in this process on a virtual display of its own: one OpenGL context per Offscreen, software-rendered where
// there is no other. Ask `available` first and skip the test where it says no.

#include "tests/support/picture.h"

#include <osg/GraphicsContext>
#include <osg/Matrixd>
#include <osg/Node>
#include <osgViewer/Viewer>

#include <functional>
#include <string>
#include <vector>

namespace pie::test {

/// The process's display: DISPLAY is set to it at the first call. Empty where Xvfb is missing.
[[nodiscard]] const std::string& ownDisplay();
/// What to say when a test is skipped.
inline constexpr const char* noDisplay = "needs a virtual display with OpenGL: apt-get install xvfb libgl1-mesa-dri";

/// A pixel buffer, not yet realized; null where there is no OpenGL.
[[nodiscard]] osg::ref_ptr<osg::GraphicsContext> makeContext(int width, int height);

struct Shot {
    int width = 160, height = 120;
    osg::Matrixd view, projection;
    int frames = 2;
    osgViewer::ViewerBase::ThreadingModel threading = osgViewer::ViewerBase::SingleThreaded;
    int contexts = 1;      ///< each shows the same view
    bool optimize = false; ///< OSG's Optimizer first, as osgviewer runs it
};
/// Seen from above, x to the right and y upwards, without perspective: the part of the level between the corners.
[[nodiscard]] Shot fromAbove(double left, double right, double bottom, double top);
/// From `eye` towards `centre`, 90 degrees wide, z upwards.
[[nodiscard]] Shot lookingAt(const osg::Vec3d& eye, const osg::Vec3d& centre);

/// The picture of every frame, per context: [context][frame]. Empty where there is no OpenGL. Time stands at zero.
[[nodiscard]] std::vector<std::vector<Picture>> renderFrames(osg::Node& scene, const Shot& shot);
/// The last frame.
[[nodiscard]] Picture render(osg::Node& scene, const Shot& shot);

} // namespace pie::test

/// First line of a test that draws.
#define PIE_NEED_DISPLAY()                                                                                             \
    if (::pie::test::ownDisplay().empty()) GTEST_SKIP() << ::pie::test::noDisplay
