#include "pie/level/bsp_check.h"
#include "pie/level/bsp_format.h"
#include "pie/level/byte_reader.h"

#include <fmt/format.h>

#include <cmath>

namespace pie::level {
namespace {

bool finite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

std::string recordOf(Lump lump, std::size_t index) { return fmt::format("lump {}, record {}", lumpName(lump), index); }

/// The record that is being checked; its messages name lump, index and field.
class Record {
public:
    Record(Lump lump, std::size_t index) : lump_(lump), index_(index) {}

    [[noreturn]] void fail(const std::string& why) const { throw Damage(recordOf(lump_, index_), why); }

    void index(const char* field, std::int64_t value, std::size_t count, Lump target, std::int64_t lowest = 0) const {
        if (value < lowest || value >= static_cast<std::int64_t>(count))
            fail(fmt::format("{} {} is not one of the {} records of lump {}", field, value, count, lumpName(target)));
    }
    void range(const char* field, std::int64_t first, std::int64_t count, std::size_t size, Lump target) const {
        if (first < 0 || count < 0 || first + count > static_cast<std::int64_t>(size))
            fail(fmt::format("{} {} with count {} leaves the {} records of lump {}", field, first, count, size,
                             lumpName(target)));
    }
    void finiteVector(const char* field, const Vec3& v) const {
        if (!finite(v)) fail(fmt::format("{} is not finite", field));
    }

private:
    Lump lump_;
    std::size_t index_;
};

template <class T, class Check> void forEach(Lump lump, const std::vector<T>& records, Check check) {
    for (std::size_t i = 0; i < records.size(); ++i) check(Record(lump, i), records[i]);
}

void checkPlanes(const Bsp& bsp) {
    forEach(Lump::Planes, bsp.planes, [](const Record& record, const BspPlane& p) {
        record.finiteVector("normal", p.normal);
        if (!std::isfinite(p.distance)) record.fail("distance is not finite");
    });
}

/// Every node has one parent at most and node 0 none, so a walk from node 0 meets each node once and ends.
void checkNodes(const Bsp& bsp) {
    std::vector<bool> reached(bsp.nodes.size());
    if (!reached.empty()) reached[0] = true;
    forEach(Lump::Nodes, bsp.nodes, [&](const Record& record, const BspNode& node) {
        record.index("plane", node.plane, bsp.planes.size(), Lump::Planes);
        for (const std::int32_t child : node.children) {
            if (child < 0) {
                record.index("child leaf", -(std::int64_t{child} + 1), bsp.leaves.size(), Lump::Leaves);
                continue;
            }
            record.index("child", child, bsp.nodes.size(), Lump::Nodes);
            const auto c = static_cast<std::size_t>(child);
            if (reached[c])
                record.fail(fmt::format("child {} is reached twice: the tree has a cycle or shares a node", child));
            reached[c] = true;
        }
    });
}

void checkLeaves(const Bsp& bsp) {
    forEach(Lump::Leaves, bsp.leaves, [&](const Record& record, const BspLeaf& leaf) {
        record.range("first leaf face", leaf.firstLeafFace, leaf.leafFaceCount, bsp.leafFaces.size(), Lump::LeafFaces);
        record.range("first leaf brush", leaf.firstLeafBrush, leaf.leafBrushCount, bsp.leafBrushes.size(),
                     Lump::LeafBrushes);
        if (bsp.visibility.clusterCount > 0 && leaf.cluster >= bsp.visibility.clusterCount)
            record.fail(fmt::format("cluster {} is not one of the {} clusters of lump {}", leaf.cluster,
                                    bsp.visibility.clusterCount, lumpName(Lump::Visibility)));
    });
    forEach(Lump::LeafFaces, bsp.leafFaces, [&](const Record& record, std::int32_t face) {
        record.index("face", face, bsp.faces.size(), Lump::Faces);
    });
    forEach(Lump::LeafBrushes, bsp.leafBrushes, [&](const Record& record, std::int32_t brush) {
        record.index("brush", brush, bsp.brushes.size(), Lump::Brushes);
    });
}

void checkModels(const Bsp& bsp) {
    if (bsp.models.empty())
        throw Damage(fmt::format("lump {}", lumpName(Lump::Models)), "is empty, so there is no world");
    forEach(Lump::Models, bsp.models, [&](const Record& record, const BspModel& model) {
        record.finiteVector("mins", model.mins);
        record.finiteVector("maxs", model.maxs);
        record.range("first face", model.firstFace, model.faceCount, bsp.faces.size(), Lump::Faces);
        record.range("first brush", model.firstBrush, model.brushCount, bsp.brushes.size(), Lump::Brushes);
    });
}

void checkBrushes(const Bsp& bsp) {
    forEach(Lump::Brushes, bsp.brushes, [&](const Record& record, const BspBrush& brush) {
        record.range("first side", brush.firstSide, brush.sideCount, bsp.brushSides.size(), Lump::BrushSides);
        record.index("shader", brush.shader, bsp.shaders.size(), Lump::Shaders);
    });
    forEach(Lump::BrushSides, bsp.brushSides, [&](const Record& record, const BspBrushSide& side) {
        record.index("plane", side.plane, bsp.planes.size(), Lump::Planes);
        record.index("shader", side.shader, bsp.shaders.size(), Lump::Shaders);
    });
}

void checkVertices(const Bsp& bsp) {
    forEach(Lump::Vertices, bsp.vertices,
            [](const Record& record, const BspVertex& v) { record.finiteVector("position", v.position); });
}

void checkEffects(const Bsp& bsp) {
    forEach(Lump::Effects, bsp.effects, [&](const Record& record, const BspEffect& effect) {
        // A fog of the whole level (worldspawn _foghull) has no brush.
        record.index("brush", effect.brush, bsp.brushes.size(), Lump::Brushes, -1);
        if (effect.brush < 0) return;
        const BspBrush& brush = bsp.brushes[static_cast<std::size_t>(effect.brush)];
        if (effect.visibleSide < -1 || effect.visibleSide >= brush.sideCount)
            record.fail(fmt::format("visible side {} is not one of the {} sides of brush {}", effect.visibleSide,
                                    brush.sideCount, effect.brush));
    });
}

void checkPatch(const Record& record, const BspFace& face) {
    const auto [width, height] = face.patchSize;
    if (width < 3 || height < 3 || width % 2 == 0 || height % 2 == 0)
        record.fail(fmt::format("patch size {}x{} must be odd and at least 3 both ways", width, height));
    if (width > maxPatchSide || height > maxPatchSide || std::int64_t{width} * height > maxPatchControls)
        record.fail(fmt::format("patch size {}x{} is beyond the limit of {} a side and {} points", width, height,
                                maxPatchSide, maxPatchControls));
    if (std::int64_t{width} * height != face.vertexCount)
        record.fail(fmt::format("patch size {}x{} does not fit its vertex count {}", width, height, face.vertexCount));
}

void checkTriangles(const Record& record, const BspFace& face, const Bsp& bsp) {
    record.range("first mesh vertex", face.firstMeshVertex, face.meshVertexCount, bsp.meshVertices.size(),
                 Lump::MeshVertices);
    if (face.meshVertexCount % 3 != 0)
        record.fail(fmt::format("mesh vertex count {} is not a multiple of 3", face.meshVertexCount));
    for (std::int32_t i = 0; i < face.meshVertexCount; ++i) {
        const auto at = static_cast<std::size_t>(face.firstMeshVertex) + static_cast<std::size_t>(i);
        const std::int32_t vertex = bsp.meshVertices[at];
        if (vertex < 0 || vertex >= face.vertexCount)
            record.fail(
                fmt::format("mesh vertex {} holds {}, but the face has {} vertices", at, vertex, face.vertexCount));
    }
}

void checkFace(const Record& record, const BspFace& face, const Bsp& bsp) {
    record.index("shader", face.shader, bsp.shaders.size(), Lump::Shaders);
    record.index("effect", face.effect, bsp.effects.size(), Lump::Effects, -1);
    record.range("first vertex", face.firstVertex, face.vertexCount, bsp.vertices.size(), Lump::Vertices);
    if (!bsp.lightmaps.empty() && face.lightmap >= 0)
        record.index("lightmap", face.lightmap, bsp.lightmaps.size(), Lump::Lightmaps);
    if (face.lightmap > maxExternalLightmap)
        record.fail(fmt::format("lightmap {} is beyond the limit of {}", face.lightmap, maxExternalLightmap));
    switch (face.type) {
    case BspFaceType::Polygon:
    case BspFaceType::Mesh: checkTriangles(record, face, bsp); return;
    case BspFaceType::Patch: checkPatch(record, face); return;
    case BspFaceType::Flare: return;
    }
    record.fail(fmt::format("type {} is none of 1 (polygon), 2 (patch), 3 (mesh), 4 (flare)",
                            static_cast<std::int32_t>(face.type)));
}

void checkFaces(const Bsp& bsp) {
    std::int64_t vertices = 0;
    std::int64_t meshVertices = 0;
    forEach(Lump::Faces, bsp.faces, [&](const Record& record, const BspFace& face) {
        checkFace(record, face, bsp);
        vertices += face.vertexCount;
        if (face.type != BspFaceType::Patch && face.type != BspFaceType::Flare) meshVertices += face.meshVertexCount;
        // Damaged faces may all claim the same large range.
        if (vertices > maxFaceVertices || meshVertices > maxFaceMeshVertices)
            record.fail(
                fmt::format("all faces up to here use {} vertices and {} mesh vertices, beyond the limits of {} and {}",
                            vertices, meshVertices, maxFaceVertices, maxFaceMeshVertices));
    });
}

} // namespace

void checkBsp(const Bsp& bsp) {
    for (const auto check :
         {checkPlanes, checkNodes, checkLeaves, checkModels, checkBrushes, checkVertices, checkEffects, checkFaces})
        check(bsp);
}

} // namespace pie::level
