#pragma once
// Where a level is looked at from first. A viewer's own home position is computed from the bounding sphere and stands
// outside the level.

#include "osgPlugins/osgpie/level_node.h"

namespace osgpie {

/// Adds a CameraView at the first player start, and an event callback that makes it the home of a viewer's camera
/// manipulator once, when the level is all that the viewer shows and the application has set no home of its own.
void addInitialView(LevelNode& node);

} // namespace osgpie
