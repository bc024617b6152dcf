#pragma once
// Surfaces that turn towards the eye (deformVertexes autosprite, autosprite2): flares and flames made of quads. They
// are drawn from the level's quads, never refined; each vertex carries its quad's centre and its place around it for
// the vertex shader.

#include "osgPlugins/osgpie/state_sets.h"

#include <osg/Node>

namespace osgpie {

[[nodiscard]] bool isSprite(const pie::level::Shader& shader);
/// All sprites of the level in one Geode; null if there are none.
[[nodiscard]] osg::ref_ptr<osg::Node> makeSprites(const pie::level::Level& level, StateSets& states, float overbright);

} // namespace osgpie
