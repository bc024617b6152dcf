#include "pie/brushes/level_writer.h"

#include "pie/level/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace pie::brushes {
namespace {

std::array<std::int32_t, 3> whole(const glm::dvec3& v, bool up) {
    std::array<std::int32_t, 3> result{};
    for (int axis = 0; axis < 3; ++axis)
        result.at(static_cast<std::size_t>(axis)) =
            static_cast<std::int32_t>(up ? std::ceil(v[axis]) : std::floor(v[axis]));
    return result;
}

/// A word without quotes may hold one; inside quotes it would end there.
std::string plain(std::string text) {
    std::replace(text.begin(), text.end(), '"', '\'');
    return text;
}

void keepReached(const SolidTree& tree, std::vector<std::uint32_t>& leaves) {
    std::erase_if(leaves, [&](std::uint32_t leaf) { return !tree.leaves()[leaf].reached; });
}

} // namespace

level::Bsp LevelWriter::write(const SolidTree& tree, std::vector<Fragment> structural) {
    kept_.resize(shaders_.size());
    for (std::uint32_t i = 0; i < shaders_.size(); ++i) kept_[i] = shaders_[i].kept ? 1 : 0;
    writeWorld(tree, std::move(structural));
    for (std::size_t i = 1; i < parts_.size(); ++i) writePart(parts_[i]);
    writeTree(tree);
    writeEntities();
    for (std::uint32_t i = 0; i < planes_.size(); ++i)
        writer_.bsp.planes.push_back({Vec3(planes_[i].normal), static_cast<float>(planes_[i].distance)});
    return std::move(writer_.bsp);
}

void LevelWriter::beginModel(const Part& part) {
    level::BspModel model;
    Bounds bounds = part.bounds();
    if (bounds.empty()) bounds.extend(part.origin);
    model.mins = Vec3(bounds.lower - part.origin);
    model.maxs = Vec3(bounds.upper - part.origin);
    model.firstFace = static_cast<std::int32_t>(writer_.bsp.faces.size());
    model.firstBrush = static_cast<std::int32_t>(writer_.bsp.brushes.size());
    writer_.bsp.models.push_back(model);
}

void LevelWriter::endModel() {
    level::BspModel& model = writer_.bsp.models.back();
    model.faceCount = static_cast<std::int32_t>(writer_.bsp.faces.size()) - model.firstFace;
    model.brushCount = static_cast<std::int32_t>(writer_.bsp.brushes.size()) - model.firstBrush;
}

std::vector<LevelWriter::Piece> LevelWriter::cutByFog(Polygon polygon, std::uint32_t plane) const {
    std::vector<Piece> pieces;
    std::vector<Polygon> open;
    open.push_back(std::move(polygon));
    std::vector<Polygon> outside;
    Polygon inside;
    for (const Fog& fog : fogs_) {
        outside.clear();
        // In the volume's own border a face that looks out of it is outside.
        for (Polygon& piece : open)
            if (carve(piece, plane, parts_.front().brushes[fog.brush], planes_, false, inside, outside))
                pieces.push_back({std::move(inside), fog.effect});
            else
                outside.push_back(std::move(piece));
        open.swap(outside);
    }
    for (Polygon& piece : open) pieces.push_back({std::move(piece), -1});
    return pieces;
}

std::int32_t LevelWriter::fogAt(const glm::dvec3& point) const {
    for (const Fog& fog : fogs_) {
        const Brush& brush = parts_.front().brushes[fog.brush];
        if (std::all_of(brush.sides.begin(), brush.sides.end(),
                        [&](const Side& s) { return planes_[s.plane].above(point) < onPlane; }))
            return fog.effect;
    }
    return -1;
}

void LevelWriter::writeBrushes(const SolidTree& tree) {
    const Part& world = parts_.front();
    std::vector<std::uint32_t> leaves;
    for (std::size_t b = 0; b < world.brushes.size(); ++b) {
        const Brush& brush = world.brushes[b];
        const std::int32_t number = writer_.addBrush(brush, glm::dvec3(0));
        leaves.clear();
        tree.leavesNear(brush.bounds, leaves);
        for (const std::uint32_t leaf : leaves) leafBrushes_[leaf].push_back(static_cast<std::uint32_t>(number));
        const level::Shader& shader = shaders_[brush.sides.front().shader].shader;
        if (shader.fog) {
            fogs_.push_back({b, static_cast<std::int32_t>(writer_.bsp.effects.size())});
            writer_.bsp.effects.push_back({shader.name, number, -1});
        }
    }
}

void LevelWriter::writeWorld(const SolidTree& tree, std::vector<Fragment> structural) {
    const Part& world = parts_.front();
    leafFaces_.resize(tree.leaves().size());
    leafBrushes_.resize(tree.leaves().size());
    beginModel(world);
    writeBrushes(tree);
    std::vector<std::uint32_t> leaves;
    for (Fragment& fragment : visibleFragments(world.brushes, planes_, kept_, std::move(structural))) {
        const Brush& brush = world.brushes[fragment.brush];
        const Side& side = brush.sides[fragment.side];
        leaves.clear();
        tree.leavesInFront(fragment.polygon, side.plane, leaves);
        // What stands in the open inside a solid leaf touches nobody's eye either.
        keepReached(tree, leaves);
        if (leaves.empty()) continue;
        for (const Piece& piece : cutByFog(std::move(fragment.polygon), side.plane)) {
            const auto face = static_cast<std::uint32_t>(writer_.bsp.faces.size());
            writer_.addPolygon(piece.polygon, side, brush.text->faces[side.face], glm::dvec3(0), piece.fog);
            if (writer_.bsp.faces.size() > face)
                for (const std::uint32_t leaf : leaves) leafFaces_[leaf].push_back(face);
        }
    }
    // Calls add() for what is in the bounds, if anybody can see it, and lists the faces it wrote in leaves.
    const auto listed = [&](const Bounds& bounds, const auto& add) {
        leaves.clear();
        tree.leavesNear(bounds, leaves);
        keepReached(tree, leaves);
        if (leaves.empty()) return;
        const std::size_t first = writer_.bsp.faces.size();
        add(fogAt(0.5 * (bounds.lower + bounds.upper)));
        for (std::size_t face = first; face < writer_.bsp.faces.size(); ++face)
            for (const std::uint32_t leaf : leaves) leafFaces_[leaf].push_back(static_cast<std::uint32_t>(face));
    };
    for (const Part::Curve& curve : world.patches)
        if (kept_[curve.shader] != 0)
            listed(boundsOf(*curve.text),
                   [&](std::int32_t fog) { writer_.addPatch(*curve.text, curve.shader, glm::dvec3(0), fog); });
    for (const Part::Mesh& mesh : world.meshes)
        if (kept_[mesh.shader] != 0)
            listed(mesh.bounds, [&](std::int32_t fog) { writer_.addMesh(mesh, glm::dvec3(0), fog); });
    endModel();
}

void LevelWriter::writePart(const Part& part) {
    beginModel(part);
    for (const Brush& brush : part.brushes) writer_.addBrush(brush, part.origin);
    for (const Fragment& fragment : visibleFragments(part.brushes, planes_, kept_)) {
        const Brush& brush = part.brushes[fragment.brush];
        const Side& side = brush.sides[fragment.side];
        writer_.addPolygon(fragment.polygon, side, brush.text->faces[side.face], part.origin, -1);
    }
    for (const Part::Curve& curve : part.patches)
        if (kept_[curve.shader] != 0) writer_.addPatch(*curve.text, curve.shader, part.origin, -1);
    for (const Part::Mesh& mesh : part.meshes)
        if (kept_[mesh.shader] != 0) writer_.addMesh(mesh, part.origin, -1);
    endModel();
}

void LevelWriter::writeTree(const SolidTree& tree) {
    level::Bsp& bsp = writer_.bsp;
    for (const SolidTree::Node& node : tree.nodes())
        bsp.nodes.push_back({static_cast<std::int32_t>(node.plane), node.children, whole(node.bounds.lower, false),
                             whole(node.bounds.upper, true)});
    for (std::size_t i = 0; i < tree.leaves().size(); ++i) {
        const SolidTree::Leaf& leaf = tree.leaves()[i];
        level::BspLeaf written;
        written.cluster = leaf.reached ? 0 : -1;
        written.area = leaf.reached ? 0 : -1;
        if (!leaf.bounds.empty()) {
            written.mins = whole(leaf.bounds.lower, false);
            written.maxs = whole(leaf.bounds.upper, true);
        }
        written.firstLeafFace = static_cast<std::int32_t>(bsp.leafFaces.size());
        written.leafFaceCount = static_cast<std::int32_t>(leafFaces_[i].size());
        written.firstLeafBrush = static_cast<std::int32_t>(bsp.leafBrushes.size());
        written.leafBrushCount = static_cast<std::int32_t>(leafBrushes_[i].size());
        bsp.leafFaces.insert(bsp.leafFaces.end(), leafFaces_[i].begin(), leafFaces_[i].end());
        bsp.leafBrushes.insert(bsp.leafBrushes.end(), leafBrushes_[i].begin(), leafBrushes_[i].end());
        bsp.leaves.push_back(written);
    }
    // One cluster that sees itself: everything is visible from everywhere.
    bsp.visibility.clusterCount = 1;
    bsp.visibility.bytesPerCluster = 8;
    bsp.visibility.bits.assign(8, 0);
    bsp.visibility.bits.front() = 1;
}

void LevelWriter::writeEntities() {
    std::vector<std::size_t> modelOf(map_.entities.size(), 0);
    for (std::size_t model = 1; model < parts_.size(); ++model) modelOf[parts_[model].entity] = model;
    std::string& text = writer_.bsp.entities;
    for (std::size_t i = 0; i < map_.entities.size(); ++i) {
        const level::Entity& entity = map_.entities[i].entity;
        if (isGroup(entity)) continue;
        text += "{\n";
        const std::size_t model = modelOf[i];
        const bool placed = model > 0 && parts_[model].origin != glm::dvec3(0);
        for (const auto& [key, value] : entity.pairs) {
            if (model > 0 && level::equalNoCase(key, "model")) continue;
            if (placed && level::equalNoCase(key, "origin")) continue;
            text += fmt::format("\"{}\" \"{}\"\n", plain(key), plain(value));
        }
        if (model > 0) text += fmt::format("\"model\" \"*{}\"\n", model);
        if (placed) {
            const glm::dvec3& o = parts_[model].origin;
            text += fmt::format("\"origin\" \"{:g} {:g} {:g}\"\n", o.x, o.y, o.z);
        }
        text += "}\n";
    }
}

} // namespace pie::brushes
