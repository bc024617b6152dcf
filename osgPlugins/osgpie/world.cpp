#include "osgPlugins/osgpie/world.h"

#include "osgPlugins/osgpie/callbacks.h"
#include "osgPlugins/osgpie/sprites.h"
#include "osgPlugins/osgpie/to_osg.h"
#include "pie/scene/cells.h"

#include <osg/Geode>
#include <osg/Notify>

#include <exception>
#include <map>

namespace osgpie {
namespace {

/// Makes the drawables of one mesh.
class Builder {
public:
    Builder(std::shared_ptr<pie::engine::Engine> engine, StateSets& states)
        : engine_(std::move(engine)), level_(engine_->level()), mesh_(engine_->mesh()), states_(states),
          placeOfVertex_(mesh_.vertices.size(), unused), placeOfReceiver_(engine_->receivers().points.size(), unused) {}

    World build() {
        const auto wanted = static_cast<std::size_t>(engine_->settings().cellTriangles);
        world_.root = makeNode(pie::scene::makeCells(mesh_, level_, wanted), "world");
        return std::move(world_);
    }

private:
    static constexpr std::uint32_t unused = 0xffffffffU;

    std::shared_ptr<pie::engine::Engine> engine_;
    const pie::level::Level& level_;
    const pie::scene::Mesh& mesh_;
    StateSets& states_;
    World world_;
    /// Scratch: place of each mesh vertex (receiver) in the drawable being made; reset after use by whoever wrote it.
    std::vector<std::uint32_t> placeOfVertex_, placeOfReceiver_;

    osg::ref_ptr<osg::Node> makeNode(const pie::scene::CellNode& cell, const std::string& name) {
        if (cell.children.empty()) return makeGeode(cell, name);
        osg::ref_ptr group = new osg::Group;
        group->setName(name);
        for (const auto& child : cell.children)
            if (const osg::ref_ptr<osg::Node> node = makeNode(child, "cell")) group->addChild(node);
        return group->getNumChildren() > 0 ? group : nullptr;
    }

    osg::ref_ptr<osg::Geode> makeGeode(const pie::scene::CellNode& cell, const std::string& name) {
        std::map<StateKey, std::vector<std::uint32_t>> byState;
        for (const std::uint32_t t : cell.triangles) {
            const auto& surface = level_.surfaces[mesh_.triangles[t].surface];
            if (isSprite(level_.shaders[surface.shader])) continue;
            byState[{surface.shader, surface.lightmap, surface.fog}].push_back(t);
        }
        osg::ref_ptr geode = new osg::Geode;
        geode->setName(name);
        for (const auto& [key, triangles] : byState) {
            const StateSets::Entry& entry = states_.get(key);
            if (entry.state) geode->addDrawable(makeGeometry(entry, triangles));
        }
        return geode->getNumDrawables() > 0 ? geode : nullptr;
    }

    osg::ref_ptr<osg::Geometry> makeGeometry(const StateSets::Entry& entry,
                                             const std::vector<std::uint32_t>& triangles) {
        osg::ref_ptr geometry = new osg::Geometry;
        geometry->setName(entry.state->getName());
        std::vector<std::uint32_t> vertices; // of the mesh, in the drawable's order
        osg::ref_ptr indices = new osg::DrawElementsUInt(GL_TRIANGLES);
        indices->reserve(3 * triangles.size());
        for (const std::uint32_t t : triangles)
            for (const std::uint32_t v : mesh_.triangles[t].vertices) {
                if (placeOfVertex_[v] == unused) {
                    placeOfVertex_[v] = static_cast<std::uint32_t>(vertices.size());
                    vertices.push_back(v);
                }
                indices->push_back(placeOfVertex_[v]);
            }
        for (const std::uint32_t v : vertices) placeOfVertex_[v] = unused;

        osg::ref_ptr positions = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
        osg::ref_ptr normals = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
        osg::ref_ptr texture = new osg::Vec2Array(osg::Array::BIND_PER_VERTEX);
        osg::ref_ptr lightmap = new osg::Vec2Array(osg::Array::BIND_PER_VERTEX);
        osg::ref_ptr colours = new osg::Vec4Array(osg::Array::BIND_PER_VERTEX);
        for (const std::uint32_t v : vertices) {
            const pie::level::Vertex& vertex = mesh_.vertices[v];
            positions->push_back(toOsg(vertex.position));
            normals->push_back(toOsg(vertex.normal));
            texture->push_back(toOsg(vertex.texture));
            lightmap->push_back(toOsg(vertex.lightmap));
            colours->push_back(vertexColour(vertex, entry.light));
        }
        geometry->setVertexArray(positions);
        geometry->setNormalArray(normals);
        geometry->setTexCoordArray(0, texture);
        if (entry.lightmapCoordinates) geometry->setTexCoordArray(1, lightmap);
        geometry->setColorArray(colours);
        if (entry.baked) geometry->setSecondaryColorArray(bakedColours(vertices));
        geometry->addPrimitiveSet(indices);
        world_.states.emplace_back(geometry, entry.state);
        geometry->setUseDisplayList(false);
        geometry->setUseVertexBufferObjects(true);
        if (entry.lit && entry.light == LightSource::Irradiance) light(*geometry, vertices, colours);
        return geometry;
    }

    /// The level's own light at vertices.
    [[nodiscard]] osg::ref_ptr<osg::Vec3Array> bakedColours(const std::vector<std::uint32_t>& vertices) const {
        osg::ref_ptr baked = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
        baked->reserve(vertices.size());
        for (const std::uint32_t v : vertices) {
            const auto& c = mesh_.vertices[v].colour;
            baked->push_back(toOsg(gameLight(pie::Rgb(c.r, c.g, c.b), largestLight(engine_->settings()))));
        }
        return baked;
    }

    /// Vertex colours before any light: the level's own, or none.
    [[nodiscard]] osg::Vec4 vertexColour(const pie::level::Vertex& vertex, LightSource source) const {
        const float alpha = static_cast<float>(vertex.colour.a) / 255.0F;
        const float overbright = largestLight(engine_->settings());
        if (source == LightSource::Irradiance || source == LightSource::None) return {1.0F, 1.0F, 1.0F, alpha};
        const pie::Rgb light = gameLight(pie::Rgb(vertex.colour.r, vertex.colour.g, vertex.colour.b), overbright);
        return {light.x, light.y, light.z, alpha};
    }

    void light(osg::Geometry& geometry, const std::vector<std::uint32_t>& vertices,
               const osg::ref_ptr<osg::Vec4Array>& colours) {
        geometry.setDataVariance(osg::Object::DYNAMIC); // also before there is light: optimisers then leave it alone
        const pie::scene::Receivers& receivers = engine_->receivers();
        if (receivers.ofVertex.empty()) return;
        std::vector<std::uint32_t> used;
        std::vector<std::uint32_t> ofVertex;
        for (const std::uint32_t v : vertices) {
            const std::uint32_t receiver = receivers.ofVertex[v];
            if (receiver == pie::scene::noReceiver) continue;
            if (placeOfReceiver_[receiver] == unused) {
                placeOfReceiver_[receiver] = static_cast<std::uint32_t>(used.size());
                used.push_back(receiver);
            }
        }
        // A lit state on a surface without receivers (or with some missing) keeps its white vertices.
        bool complete = true;
        for (const std::uint32_t v : vertices) {
            const std::uint32_t receiver = receivers.ofVertex[v];
            complete = complete && receiver != pie::scene::noReceiver;
            ofVertex.push_back(receiver == pie::scene::noReceiver ? 0 : placeOfReceiver_[receiver]);
        }
        for (const std::uint32_t receiver : used) placeOfReceiver_[receiver] = unused;
        if (used.empty() || !complete) return;
        // 64 U show the texture as it is (LEVELS in doc/manual.md).
        const auto& settings = engine_->settings();
        const std::shared_ptr<ViewSwitch>& views = states_.viewSwitch();
        const float scale = (views ? 1.0F : settings.exposure) / (64.0F * largestLight(settings));
        // A buffer of its own: only the colours are sent again when the light changes.
        osg::ref_ptr buffer = new osg::VertexBufferObject;
        buffer->setUsage(GL_DYNAMIC_DRAW);
        colours->setVertexBufferObject(buffer);
        geometry.setDrawCallback(
            new IrradianceCallback(engine_, std::move(used), std::move(ofVertex), colours, scale, views));
    }
};

} // namespace

void World::attachStates() {
    for (auto& [geometry, state] : states) geometry->setStateSet(state);
    states.clear();
}

World makeWorld(const std::shared_ptr<pie::engine::Engine>& engine, StateSets& states) {
    return Builder(engine, states).build();
}

RefinedWorld::RefinedWorld(std::shared_ptr<pie::engine::Engine> engine, std::unique_ptr<StateSets> states,
                           const osg::ref_ptr<osg::Group>& place)
    : engine_(std::move(engine)), states_(std::move(states)), place_(place),
      job_([this](const std::stop_token& stop) { work(stop); }) {}

void RefinedWorld::work(const std::stop_token& stop) {
    try {
        engine_->complete(stop);
        if (stop.stop_requested()) return;
        world_ = makeWorld(engine_, *states_);
        if (world_.root) world_.root->getBound(); // computed once, and kept
    } catch (const std::exception& error) {
        failure_ = error.what();
    }
    done_ = true;
}

void RefinedWorld::show() {
    job_.wait();
    if (!failure_.empty()) {
        OSG_WARN << "[pie] " << engine_->level().name << ": stays as it is in the file: " << failure_ << std::endl;
        return;
    }
    world_.attachStates();
    place_->removeChildren(0, place_->getNumChildren());
    if (world_.root) place_->addChild(world_.root);
}

} // namespace osgpie
