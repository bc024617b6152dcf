// The sky: a cube around the eye at infinite depth, behind everything that is opaque and before what blends.
#include "osgPlugins/osgpie/state_sets.h"

#include <osg/CullFace>
#include <osg/Depth>
#include <osg/Geode>
#include <osg/Geometry>

namespace osgpie {
namespace {

/// The cube takes no part in bounds, culling or near and far planes: it has no place.
struct NoBounds : osg::Drawable::ComputeBoundingBoxCallback {
    osg::BoundingBox computeBound(const osg::Drawable&) const override { return {}; }
};

osg::ref_ptr<osg::Geometry> makeCube() {
    osg::ref_ptr geometry = new osg::Geometry;
    geometry->setName("sky");
    osg::ref_ptr corners = new osg::Vec3Array;
    for (unsigned i = 0; i < 8; ++i)
        corners->push_back({(i & 1U) ? 1.0F : -1.0F, (i & 2U) ? 1.0F : -1.0F, (i & 4U) ? 1.0F : -1.0F});
    geometry->setVertexArray(corners);
    static constexpr GLubyte triangles[] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                            2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    geometry->addPrimitiveSet(new osg::DrawElementsUByte(GL_TRIANGLES, std::size(triangles), triangles));
    geometry->setUseDisplayList(false);
    geometry->setUseVertexBufferObjects(true);
    geometry->setComputeBoundingBoxCallback(new NoBounds);
    geometry->setCullingActive(false);
    geometry->setDataVariance(osg::Object::DYNAMIC); // keeps optimisers from merging it into the level
    return geometry;
}

/// The sky shader that covers most of the level.
const pie::level::Shader* mainSky(const pie::level::Level& level, std::uint32_t& index) {
    std::vector<double> area(level.shaders.size(), 0.0);
    for (const auto& surface : level.surfaces) {
        if (!level.shaders[surface.shader].parms.sky) continue;
        for (std::uint32_t i = 0; i + 2 < surface.indexCount; i += 3) {
            const auto corner = [&](std::uint32_t c) {
                return level.vertices[level.indices[surface.firstIndex + i + c]].position;
            };
            area[surface.shader] +=
                static_cast<double>(glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0))));
        }
    }
    const pie::level::Shader* best = nullptr;
    for (std::size_t i = 0; i < area.size(); ++i)
        if (area[i] > 0.0 && (!best || area[i] > area[index])) {
            best = &level.shaders[i];
            index = static_cast<std::uint32_t>(i);
        }
    return best;
}

} // namespace

osg::ref_ptr<osg::Node> StateSets::makeSky() {
    if (!settings_.drawSky || (settings_.view == pie::engine::View::Light && !settings_.viewsSwitch()) ||
        settings_.renderer == pie::engine::Renderer::Fixed)
        return nullptr;
    StateKey key;
    const pie::level::Shader* shader = mainSky(*level_, key.shader);
    if (!shader) return nullptr;
    Look chosen = look(key);
    chosen.light = LightSource::None;
    chosen.switchable = false;
    chosen.cloudHeight = shader->cloudHeight;
    const MaterialProgram material = makeSkyProgram(*shader, chosen);
    if (!material.visible) return nullptr;
    osg::ref_ptr state = new osg::StateSet;
    state->setName(shader->name);
    for (std::size_t u = 0; u < material.units.size(); ++u) {
        state->setTextureAttribute(static_cast<unsigned>(u), unitTexture(material.units[u], key));
        state->addUniform(new osg::Uniform(("unit" + std::to_string(u)).c_str(), static_cast<int>(u)));
    }
    state->setAttributeAndModes(program(material, shader->name));
    state->setAttributeAndModes(new osg::Depth(osg::Depth::LEQUAL, 0.0, 1.0, false));
    state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    state->setRenderBinDetails(5, "RenderBin");
    osg::ref_ptr geode = new osg::Geode;
    geode->setName("sky");
    geode->setCullingActive(false);
    const osg::ref_ptr<osg::Geometry> cube = makeCube();
    cube->setStateSet(state);
    geode->addDrawable(cube);
    return geode;
}

} // namespace osgpie
