#include "tests/osg/scene_reading.h"

#include "tests/level/make_level.h"

#include <osg/Geometry>
#include <osg/NodeVisitor>
#include <osg/TriangleIndexFunctor>
#include <osgDB/Registry>
#include <osgUtil/UpdateVisitor>

#include <gtest/gtest.h>

#include <algorithm>

namespace pie::test {
namespace {

struct Corners {
    std::vector<std::array<unsigned, 3>> triangles;
    void operator()(unsigned a, unsigned b, unsigned c) { triangles.push_back({a, b, c}); }
};

class Collect : public osg::NodeVisitor {
public:
    Collect() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
    std::vector<DrawnTriangle> triangles;
    std::vector<osg::ref_ptr<osg::StateSet>> states;

    void apply(osg::Node& node) override {
        addState(node);
        traverse(node);
    }
    void apply(osg::Geometry& geometry) override {
        addState(geometry);
        if (geometry.getName() != "sky") addTriangles(geometry);
    }

private:
    void addState(osg::Node& node) {
        osg::StateSet* state = node.getStateSet();
        if (state && std::find(states.begin(), states.end(), state) == states.end()) states.emplace_back(state);
    }

    void addTriangles(osg::Geometry& geometry) {
        osg::TriangleIndexFunctor<Corners> corners;
        geometry.accept(corners);
        const osg::Matrixd toWorld = osg::computeLocalToWorld(getNodePath());
        const auto* places = dynamic_cast<const osg::Vec3Array*>(geometry.getVertexArray());
        const auto* normals = dynamic_cast<const osg::Vec3Array*>(geometry.getNormalArray());
        const auto* texture = dynamic_cast<const osg::Vec2Array*>(geometry.getTexCoordArray(0));
        const auto* colours = dynamic_cast<const osg::Vec4Array*>(geometry.getColorArray());
        ASSERT_TRUE(places && normals && texture && colours) << geometry.getName() << " lacks an array";
        for (const osg::Array* array :
             {static_cast<const osg::Array*>(normals), static_cast<const osg::Array*>(texture),
              static_cast<const osg::Array*>(colours)}) {
            ASSERT_EQ(array->getBinding(), osg::Array::BIND_PER_VERTEX);
            ASSERT_EQ(array->getNumElements(), places->size()) << geometry.getName();
        }
        for (const auto& indices : corners.triangles) {
            DrawnTriangle triangle;
            for (std::size_t i = 0; i < 3; ++i) {
                ASSERT_LT(indices.at(i), places->size()) << geometry.getName();
                triangle.place.at(i) = osg::Vec3d((*places)[indices.at(i)]) * toWorld;
                triangle.normal.at(i) = (*normals)[indices.at(i)];
                triangle.texture.at(i) = (*texture)[indices.at(i)];
                triangle.colour.at(i) = (*colours)[indices.at(i)];
            }
            triangle.state = geometry.getStateSet();
            triangle.material = triangle.state ? triangle.state->getName() : std::string();
            triangles.push_back(triangle);
        }
    }
};

std::string text(const level::Bytes& bytes) {
    std::string content(bytes.size(), '\0');
    std::transform(bytes.begin(), bytes.end(), content.begin(), [](std::byte b) { return static_cast<char>(b); });
    return content;
}

} // namespace

void usePlugin() {
    static const bool done = [] {
        osgDB::Registry::instance()->getLibraryFilePathList().push_front(PIE_PLUGIN_PATH);
        return true;
    }();
    static_cast<void>(done);
}

osgDB::ReaderWriter::ReadResult readLevel(const std::string& file, const std::string& options) {
    usePlugin();
    const osg::ref_ptr read = new osgDB::Options(options);
    read->setObjectCacheHint(osgDB::Options::CACHE_NONE);
    return osgDB::Registry::instance()->readNode(file, read);
}

osg::ref_ptr<osg::Node> readNode(const std::string& file, const std::string& options) {
    auto result = readLevel(file, options);
    EXPECT_TRUE(result.validNode()) << file << ": " << result.message();
    return result.getNode();
}

void firstUpdate(osg::Node& node) {
    osgUtil::UpdateVisitor visitor;
    visitor.setFrameStamp(new osg::FrameStamp);
    node.accept(visitor);
}

std::vector<DrawnTriangle> trianglesOf(osg::Node& node) {
    Collect collect;
    node.accept(collect);
    return std::move(collect.triangles);
}

std::vector<DrawnTriangle> trianglesOf(osg::Node& node, const std::string& material) {
    std::vector<DrawnTriangle> triangles = trianglesOf(node);
    std::erase_if(triangles, [&](const DrawnTriangle& t) { return t.material != material; });
    return triangles;
}

double areaOf(const std::vector<DrawnTriangle>& triangles) {
    double area = 0;
    for (const DrawnTriangle& triangle : triangles) area += 0.5 * triangle.front().length();
    return area;
}

std::vector<osg::ref_ptr<osg::StateSet>> stateSetsOf(osg::Node& node) {
    Collect collect;
    node.accept(collect);
    return std::move(collect.states);
}

osg::ref_ptr<osg::StateSet> stateSet(osg::Node& node, const std::string& name) {
    for (const auto& state : stateSetsOf(node))
        if (state->getName() == name) return state;
    ADD_FAILURE() << "no state set " << name;
    return nullptr;
}

const osg::Texture2D* textureOf(const osg::StateSet& state, unsigned unit) {
    return dynamic_cast<const osg::Texture2D*>(state.getTextureAttribute(unit, osg::StateAttribute::TEXTURE));
}

std::string fileOf(const level::Bsp& bsp) { return text(level::writeBsp(bsp)); }

std::string Game::addLevel(const std::string& name, const level::Bsp& bsp) const {
    return folder_.write("maps/" + name + ".bsp", fileOf(bsp));
}

void Game::addPicture(const std::string& name, Rgba8 colour) const {
    constexpr int side = 8;
    static_cast<void>(folder_.write(name + ".tga", text(makeTga(side, side, [&](int, int) { return colour; }))));
}

void Game::addScript(const std::string& script, const std::string& name) const {
    static_cast<void>(folder_.write("scripts/" + name + ".shader", script));
}

std::vector<std::pair<std::string, std::string>> pluginEnvironment(const std::string& display) {
    return {{"OSG_LIBRARY_PATH", PIE_PLUGIN_PATH}, {"DISPLAY", display}, {"OSG_NOTIFY_LEVEL", ""}};
}

} // namespace pie::test
