#pragma once
// Levels read through the plug-in of this build, and what stands in the graph that comes back. `usePlugin` first, then
// `readLevel`; `trianglesOf` says what would be drawn, in world space and in file order of nothing in particular.

#include "pie/level/bsp.h"
#include "tests/support/files.h"

#include <osg/Node>
#include <osg/StateSet>
#include <osg/Texture2D>
#include <osgDB/ReaderWriter>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace pie::test {

/// Puts the plug-in of this build before every other one, as OSG_LIBRARY_PATH would. Done once.
void usePlugin();

/// Without the object cache: every call reads the file. `options` as after -O.
[[nodiscard]] osgDB::ReaderWriter::ReadResult readLevel(const std::string& file, const std::string& options = {});
/// The same, with a node or a failed test and null.
[[nodiscard]] osg::ref_ptr<osg::Node> readNode(const std::string& file, const std::string& options = {});

/// The first update of a viewer: what is to be lit is refined from then on.
void firstUpdate(osg::Node& node);

struct DrawnTriangle {
    std::array<osg::Vec3d, 3> place; ///< in world space
    std::array<osg::Vec3, 3> normal;
    std::array<osg::Vec2, 3> texture;
    std::array<osg::Vec4, 3> colour;
    std::string material;       ///< name of the state set: the shader
    const osg::StateSet* state; ///< lives as long as the node
    /// Where the right-hand rule points: the front, for OpenGL's usual winding. Not normalised; half its length is the
    /// area.
    [[nodiscard]] osg::Vec3d front() const { return (place[1] - place[0]) ^ (place[2] - place[0]); }
    [[nodiscard]] osg::Vec3d centre() const { return (place[0] + place[1] + place[2]) / 3.0; }
};
/// Everything but the sky's cube.
[[nodiscard]] std::vector<DrawnTriangle> trianglesOf(osg::Node& node);
/// Of one material.
[[nodiscard]] std::vector<DrawnTriangle> trianglesOf(osg::Node& node, const std::string& material);
[[nodiscard]] double areaOf(const std::vector<DrawnTriangle>& triangles);
/// All state sets below the node, each once, in the order in which they are met.
[[nodiscard]] std::vector<osg::ref_ptr<osg::StateSet>> stateSetsOf(osg::Node& node);
/// The first one of that name; a failed test and null if there is none.
[[nodiscard]] osg::ref_ptr<osg::StateSet> stateSet(osg::Node& node, const std::string& name);
[[nodiscard]] const osg::Texture2D* textureOf(const osg::StateSet& state, unsigned unit = 0);

/// A game directory of the test's own: maps, scripts and pictures.
class Game {
public:
    /// Returns the path of the level.
    std::string addLevel(const std::string& name, const level::Bsp& bsp) const;
    /// A 32-bit TGA of one colour; `name` without extension.
    void addPicture(const std::string& name, Rgba8 colour) const;
    void addScript(const std::string& text, const std::string& name = "made") const;
    [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
    [[nodiscard]] const TemporaryFolder& folder() const { return folder_; }

private:
    TemporaryFolder folder_;
};

[[nodiscard]] std::string fileOf(const level::Bsp& bsp);

/// The environment in which a program finds the plug-in of this build: OSG_LIBRARY_PATH and no display.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> pluginEnvironment(const std::string& display = {});

} // namespace pie::test
