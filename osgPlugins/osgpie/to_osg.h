#pragma once
// Our vectors as OSG's.

#include "pie/core/vec.h"

#include <osg/Vec2>
#include <osg/Vec3>

namespace osgpie {

[[nodiscard]] inline osg::Vec3 toOsg(const pie::Vec3& v) { return {v.x, v.y, v.z}; }
[[nodiscard]] inline osg::Vec2 toOsg(const pie::Vec2& v) { return {v.x, v.y}; }

} // namespace osgpie
