#include "osgPlugins/osgpie/view_overlays.h"

#include "osgPlugins/osgpie/to_osg.h"

#include <osg/Depth>
#include <osg/Geode>
#include <osg/Geometry>
#include <osg/Group>
#include <osg/Point>
#include <osg/PolygonMode>
#include <osg/PolygonOffset>
#include <osg/Program>

#include <algorithm>

namespace osgpie {
namespace {

/// Vertices are drawn a little nearer than they are: they lie on what is drawn beneath.
constexpr const char* vertexSource = "#version 120\nvarying vec4 colour;\nvoid main() {\n    colour = gl_Color;\n"
                                     "    gl_Position = gl_ModelViewProjectionMatrix * gl_Vertex;\n"
                                     "    gl_Position.z -= 0.0005 * gl_Position.w;\n}\n";
constexpr const char* vertexColours =
    "#version 120\nvarying vec4 colour;\nvoid main() { gl_FragColor = vec4(colour.rgb, 1.0); }\n";
constexpr const char* oneColour =
    "#version 120\nuniform vec3 edgeColour;\nvoid main() { gl_FragColor = vec4(edgeColour, 1.0); }\n";

osg::ref_ptr<osg::StateSet> makeState(const char* fragmentSource) {
    osg::ref_ptr state = new osg::StateSet;
    osg::ref_ptr program = new osg::Program;
    program->addShader(new osg::Shader(osg::Shader::VERTEX, vertexSource));
    program->addShader(new osg::Shader(osg::Shader::FRAGMENT, fragmentSource));
    constexpr auto wins = osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE;
    state->setAttributeAndModes(program, wins);
    state->setAttributeAndModes(new osg::Depth(osg::Depth::LEQUAL, 0.0, 1.0, false), wins);
    state->setMode(GL_BLEND, osg::StateAttribute::OFF | osg::StateAttribute::OVERRIDE);
    state->setRenderBinDetails(100, "RenderBin", osg::StateSet::OVERRIDE_RENDERBIN_DETAILS);
    return state;
}

osg::ref_ptr<osg::Node> makeGeode(const osg::ref_ptr<osg::Geometry>& geometry, const osg::ref_ptr<osg::StateSet>& state,
                                  const char* name) {
    geometry->setUseDisplayList(false);
    geometry->setUseVertexBufferObjects(true);
    osg::ref_ptr geode = new osg::Geode;
    geode->setName(name);
    geode->addDrawable(geometry);
    geode->setStateSet(state);
    return geode;
}

} // namespace

osg::ref_ptr<osg::Node> makeEdges(osg::Node& world) {
    osg::ref_ptr group = new osg::Group;
    group->setName("edges");
    group->addChild(&world);
    const osg::ref_ptr<osg::StateSet> state = makeState(oneColour);
    state->addUniform(new osg::Uniform("edgeColour", osg::Vec3(0.35F, 0.9F, 0.55F)));
    state->setAttributeAndModes(new osg::PolygonMode(osg::PolygonMode::FRONT_AND_BACK, osg::PolygonMode::LINE),
                                osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE);
    group->setStateSet(state);
    return group;
}

osg::ref_ptr<osg::Node> makeCoarseEdges(const pie::level::Level& level) {
    osg::ref_ptr geometry = new osg::Geometry;
    osg::ref_ptr positions = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr lines = new osg::DrawElementsUInt(GL_LINES);
    positions->reserve(level.vertices.size());
    for (const auto& vertex : level.vertices) positions->push_back(toOsg(vertex.position));
    for (const auto& surface : level.surfaces) {
        if (!level.shaders[surface.shader].drawn() || !level.models[surface.model].drawn) continue;
        for (std::uint32_t i = 0; i + 2 < surface.indexCount; i += 3) {
            const auto corner = [&](std::uint32_t c) { return level.indices[surface.firstIndex + i + c]; };
            for (std::uint32_t c = 0; c < 3; ++c) {
                lines->push_back(corner(c));
                lines->push_back(corner((c + 1) % 3));
            }
        }
    }
    geometry->setVertexArray(positions);
    geometry->addPrimitiveSet(lines);
    const osg::ref_ptr<osg::StateSet> state = makeState(oneColour);
    state->addUniform(new osg::Uniform("edgeColour", osg::Vec3(1.0F, 0.75F, 0.25F)));
    return makeGeode(geometry, state, "coarse edges");
}

osg::ref_ptr<osg::Node> makePhotonPoints(const std::vector<pie::photons::Photon>& photons) {
    osg::ref_ptr geometry = new osg::Geometry;
    osg::ref_ptr positions = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr colours = new osg::Vec4Array(osg::Array::BIND_PER_VERTEX);
    positions->reserve(photons.size());
    colours->reserve(photons.size());
    for (const auto& photon : photons) {
        const float largest = std::max(pie::maxChannel(photon.flux), 1e-30F);
        const pie::Rgb colour = photon.flux * ((photon.bounce == 0 ? 1.0F : 0.6F) / largest);
        positions->push_back(toOsg(photon.position));
        colours->push_back({colour.x, colour.y, colour.z, 1.0F});
    }
    geometry->setVertexArray(positions);
    geometry->setColorArray(colours);
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_POINTS, 0, static_cast<int>(positions->size())));
    const osg::ref_ptr<osg::StateSet> state = makeState(vertexColours);
    state->setAttribute(new osg::Point(2.0F));
    return makeGeode(geometry, state, "photons");
}

} // namespace osgpie
