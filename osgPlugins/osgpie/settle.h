#pragma once
// A level whose light stands still: for converters and for programs that never run an update traversal.

#include "osgPlugins/osgpie/level_node.h"

namespace osgpie {

/// Traces all photons, lights every vertex and takes the update and draw callbacks away. What is left is a plain scene
/// graph.
void settle(LevelNode& node);

} // namespace osgpie
