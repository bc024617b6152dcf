#pragma once
// What views that look inside draw over the level. Inside osgPlugins/osgpie only.

#include "pie/level/level.h"
#include "pie/photons/photon.h"

#include <osg/Node>

#include <vector>

namespace osgpie {

/// The edges of what `world` draws. Shares its drawables.
[[nodiscard]] osg::ref_ptr<osg::Node> makeEdges(osg::Node& world);
/// The edges of the level as it is in the file.
[[nodiscard]] osg::ref_ptr<osg::Node> makeCoarseEdges(const pie::level::Level& level);
/// A point per photon, in the colour of its flux, the brightest channel full; darker where it was reflected before.
[[nodiscard]] osg::ref_ptr<osg::Node> makePhotonPoints(const std::vector<pie::photons::Photon>& photons);

} // namespace osgpie
