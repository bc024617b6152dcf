#include "osgPlugins/osgpie/sprites.h"

#include "osgPlugins/osgpie/to_osg.h"

#include <osg/Geode>
#include <osg/Geometry>

#include <array>
#include <map>

namespace osgpie {
namespace {

using pie::Vec3;
using pie::level::DeformKind;
using pie::level::Level;
using pie::level::Surface;

struct Arrays {
    osg::ref_ptr<osg::Vec3Array> positions = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr<osg::Vec4Array> colours = new osg::Vec4Array(osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr<osg::Vec2Array> texture = new osg::Vec2Array(osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr<osg::Vec3Array> centres = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr<osg::Vec2Array> offsets = new osg::Vec2Array(osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr<osg::Vec3Array> axes = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr<osg::DrawElementsUInt> indices = new osg::DrawElementsUInt(GL_TRIANGLES);
};

using Quad = std::array<pie::level::Vertex, 4>;

void addVertex(Arrays& arrays, const pie::level::Vertex& vertex, const Vec3& centre, const Vec3& axis,
               const pie::Vec2& offset, const pie::Vec2& texture, float overbright) {
    const pie::Rgb light = gameLight(pie::Rgb(vertex.colour.r, vertex.colour.g, vertex.colour.b), overbright);
    arrays.positions->push_back(toOsg(vertex.position));
    arrays.normals->push_back(toOsg(vertex.normal));
    arrays.colours->push_back({light.x, light.y, light.z, static_cast<float>(vertex.colour.a) / 255.0F});
    arrays.texture->push_back({texture.x, texture.y});
    arrays.centres->push_back(toOsg(centre));
    arrays.offsets->push_back({offset.x, offset.y});
    arrays.axes->push_back(toOsg(axis));
}

void addIndices(Arrays& arrays) {
    const auto first = static_cast<unsigned>(arrays.positions->size()) - 4;
    for (const unsigned i : {0U, 1U, 3U, 3U, 1U, 2U}) arrays.indices->push_back(first + i);
}

/// A square of 0.707 of the corner distance about the centre, with the whole texture (the game's Autosprite).
void addFacing(Arrays& arrays, const Quad& quad, float overbright) {
    Vec3 centre(0.0F);
    for (const auto& v : quad) centre += 0.25F * v.position;
    const float radius = 0.707F * glm::length(quad[0].position - centre);
    constexpr std::array<pie::Vec2, 4> places{{{-1, 1}, {1, 1}, {1, -1}, {-1, -1}}};
    for (std::size_t i = 0; i < 4; ++i) {
        const pie::Vec2 texture(places[i].x > 0 ? 1.0F : 0.0F, places[i].y > 0 ? 0.0F : 1.0F);
        addVertex(arrays, quad[i], centre, Vec3(0.0F), places[i] * radius, texture, overbright);
    }
    addIndices(arrays);
}

/// Turns about the line through the middles of its shortest edge and of the edge across (the game's Autosprite2, which
/// takes the two shortest: the same edges, but for squares, where those may meet in a corner).
void addTurning(Arrays& arrays, const Quad& quad, float overbright) {
    // Edge 5 − e has the other two corners.
    static constexpr std::array<std::array<std::size_t, 2>, 6> edges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
    const auto length = [&](std::size_t e) {
        return glm::length(quad[edges[e][0]].position - quad[edges[e][1]].position);
    };
    std::size_t shortest = 0;
    for (std::size_t e = 1; e < edges.size(); ++e)
        if (length(e) < length(shortest)) shortest = e;
    const auto& low = edges[shortest];
    const auto& high = edges[5 - shortest];
    const auto middle = [&](const std::array<std::size_t, 2>& e) {
        return 0.5F * (quad[e[0]].position + quad[e[1]].position);
    };
    const Vec3 along = middle(high) - middle(low);
    const float span = glm::length(along);
    const Vec3 axis = span > 0 ? along / span : Vec3(0, 0, 1);
    const Vec3 centre = 0.5F * (middle(low) + middle(high));
    const auto add = [&](std::size_t v, float x, float y) {
        addVertex(arrays, quad[v], centre, axis, {x, y}, quad[v].texture, overbright);
    };
    const float lowHalf = 0.5F * length(shortest);
    const float highHalf = 0.5F * length(5 - shortest);
    // Keep sides together: the end of the upper edge that lies on the same side as the lower edge's first.
    const Vec3 side = quad[low[0]].position - middle(low);
    const bool same = glm::dot(side, quad[high[0]].position - middle(high)) >= 0;
    add(low[0], -lowHalf, -0.5F * span);
    add(low[1], lowHalf, -0.5F * span);
    add(same ? high[1] : high[0], highHalf, 0.5F * span);
    add(same ? high[0] : high[1], -highHalf, 0.5F * span);
    addIndices(arrays);
}

void addSurface(Arrays& arrays, const Level& level, const Surface& surface, DeformKind kind, float overbright) {
    for (std::uint32_t first = 0; first + 3 < surface.vertexCount; first += 4) {
        Quad quad;
        for (std::uint32_t i = 0; i < 4; ++i) quad[i] = level.vertices[surface.firstVertex + first + i];
        if (kind == DeformKind::AutoSprite)
            addFacing(arrays, quad, overbright);
        else
            addTurning(arrays, quad, overbright);
    }
}

DeformKind spriteKind(const pie::level::Shader& shader) {
    for (const auto& deform : shader.deforms)
        if (deform.kind == DeformKind::AutoSprite || deform.kind == DeformKind::AutoSprite2) return deform.kind;
    return DeformKind::Normal;
}

} // namespace

bool isSprite(const pie::level::Shader& shader) { return spriteKind(shader) != DeformKind::Normal; }

osg::ref_ptr<osg::Node> makeSprites(const Level& level, StateSets& states, float overbright) {
    std::map<StateKey, Arrays> byState;
    for (const Surface& surface : level.surfaces) {
        const auto& shader = level.shaders[surface.shader];
        if (!isSprite(shader) || !shader.drawn() || !level.models[surface.model].drawn) continue;
        addSurface(byState[{surface.shader, surface.lightmap, surface.fog}], level, surface, spriteKind(shader),
                   overbright);
    }
    osg::ref_ptr geode = new osg::Geode;
    geode->setName("sprites");
    for (auto& [key, arrays] : byState) {
        const StateSets::Entry& entry = states.get(key);
        if (!entry.state || arrays.indices->empty()) continue;
        osg::ref_ptr geometry = new osg::Geometry;
        geometry->setName(entry.state->getName());
        geometry->setVertexArray(arrays.positions);
        geometry->setNormalArray(arrays.normals);
        geometry->setColorArray(arrays.colours);
        if (entry.baked) geometry->setSecondaryColorArray(arrays.colours);
        geometry->setTexCoordArray(0, arrays.texture);
        geometry->setTexCoordArray(2, arrays.centres);
        geometry->setTexCoordArray(3, arrays.offsets);
        geometry->setTexCoordArray(4, arrays.axes);
        geometry->addPrimitiveSet(arrays.indices);
        geometry->setUseDisplayList(false);
        geometry->setUseVertexBufferObjects(true);
        osg::ref_ptr state = new osg::StateSet(*entry.state);
        state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
        geometry->setStateSet(state);
        geode->addDrawable(geometry);
    }
    return geode->getNumDrawables() > 0 ? geode : nullptr;
}

} // namespace osgpie
