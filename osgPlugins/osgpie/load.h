#pragma once
// From a level's name to a node: settings → file → level → engine → scene graph.

#include "osgPlugins/osgpie/level_node.h"
#include "pie/core/result.h"
#include "pie/engine/settings.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace osgpie {

/// Loads `level` (see pie::level::locate) and builds its node; refinement goes on behind it (level_node.h). Nothing is
/// printed; what the content's author should know stands in Level::statistics. May be called from several threads at
/// once.
[[nodiscard]] pie::Result<osg::ref_ptr<LevelNode>> loadLevelNode(const std::string& level,
                                                                 const pie::engine::Settings& settings);
/// The same from the bytes of a .bsp; `level` says where it lies, for messages and for finding its textures.
[[nodiscard]] pie::Result<osg::ref_ptr<LevelNode>>
loadLevelNode(const std::vector<std::byte>& bytes, const std::string& level, const pie::engine::Settings& settings);

} // namespace osgpie
