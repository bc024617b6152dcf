// One small function per lump. Records are read first and checked in a second pass, when all lumps they may point into
// are known. Exceptions (Damage) stay inside this file.

#include "pie/level/bsp.h"
#include "pie/level/bsp_format.h"
#include "pie/level/byte_reader.h"

#include <fmt/format.h>

#include <cmath>

namespace pie::level {
namespace {

bool finite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

std::string recordOf(Lump lump, std::size_t index) { return fmt::format("lump {}, record {}", lumpName(lump), index); }

/// The bytes of each lump, checked against the file's length and the record's size.
class Directory {
public:
    explicit Directory(std::span<const std::byte> file) : file_(file) {
        if (file.size() < bspHeaderBytes)
            throw Damage("header", fmt::format("the file has {} bytes, its header {}", file.size(), bspHeaderBytes));
    }

    [[nodiscard]] std::span<const std::byte> bytes(Lump lump) const {
        const auto index = static_cast<std::size_t>(lump);
        ByteReader entry(file_.subspan(8 + index * 8, 8));
        const std::int64_t offset = entry.integer();
        const std::int64_t length = entry.integer();
        const std::string place = fmt::format("lump {}", lumpName(lump));
        if (offset < 0 || length < 0)
            throw Damage(place, fmt::format("offset {} and length {} must not be negative", offset, length));
        if (offset + length > static_cast<std::int64_t>(file_.size()))
            throw Damage(place, fmt::format("bytes {} to {} lie behind the end of the file at {}", offset,
                                            offset + length, file_.size()));
        if (static_cast<std::size_t>(length) % bspRecordBytes.at(index) != 0)
            throw Damage(place, fmt::format("length {} is not a multiple of the record size {}", length,
                                            bspRecordBytes.at(index)));
        return file_.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(length));
    }

    /// All records of a lump, each made by `readOne`.
    template <class T, class ReadOne> void records(Lump lump, std::vector<T>& into, ReadOne readOne) const {
        const std::span<const std::byte> content = bytes(lump);
        ByteReader in(content);
        into.reserve(content.size() / bspRecordBytes.at(static_cast<std::size_t>(lump)));
        while (in.left() != 0) into.push_back(readOne(in));
    }

private:
    std::span<const std::byte> file_;
};

void readEntities(const Directory& file, Bsp& bsp) {
    const std::span<const std::byte> text = file.bytes(Lump::Entities);
    bsp.entities = ByteReader(text).name(text.size());
}

void readShaders(const Directory& file, Bsp& bsp) {
    file.records(Lump::Shaders, bsp.shaders, [](ByteReader& in) {
        BspShader s;
        s.name = in.name(bspNameBytes);
        s.surfaceFlags = in.integer();
        s.contentFlags = in.integer();
        return s;
    });
}

void readPlanes(const Directory& file, Bsp& bsp) {
    file.records(Lump::Planes, bsp.planes, [](ByteReader& in) {
        BspPlane p;
        p.normal = in.vec3();
        p.distance = in.real();
        return p;
    });
}

void readNodes(const Directory& file, Bsp& bsp) {
    file.records(Lump::Nodes, bsp.nodes, [](ByteReader& in) {
        BspNode n;
        n.plane = in.integer();
        n.children = in.read<std::array<std::int32_t, 2>>();
        n.mins = in.read<std::array<std::int32_t, 3>>();
        n.maxs = in.read<std::array<std::int32_t, 3>>();
        return n;
    });
}

void readLeaves(const Directory& file, Bsp& bsp) {
    file.records(Lump::Leaves, bsp.leaves, [](ByteReader& in) {
        BspLeaf l;
        l.cluster = in.integer();
        l.area = in.integer();
        l.mins = in.read<std::array<std::int32_t, 3>>();
        l.maxs = in.read<std::array<std::int32_t, 3>>();
        l.firstLeafFace = in.integer();
        l.leafFaceCount = in.integer();
        l.firstLeafBrush = in.integer();
        l.leafBrushCount = in.integer();
        return l;
    });
}

void readModels(const Directory& file, Bsp& bsp) {
    file.records(Lump::Models, bsp.models, [](ByteReader& in) {
        BspModel m;
        m.mins = in.vec3();
        m.maxs = in.vec3();
        m.firstFace = in.integer();
        m.faceCount = in.integer();
        m.firstBrush = in.integer();
        m.brushCount = in.integer();
        return m;
    });
}

void readBrushes(const Directory& file, Bsp& bsp) {
    file.records(Lump::Brushes, bsp.brushes, [](ByteReader& in) {
        BspBrush b;
        b.firstSide = in.integer();
        b.sideCount = in.integer();
        b.shader = in.integer();
        return b;
    });
    file.records(Lump::BrushSides, bsp.brushSides, [](ByteReader& in) {
        BspBrushSide s;
        s.plane = in.integer();
        s.shader = in.integer();
        return s;
    });
}

void readVertices(const Directory& file, Bsp& bsp) {
    file.records(Lump::Vertices, bsp.vertices, [&bsp](ByteReader& in) {
        BspVertex v;
        v.position = in.vec3();
        v.texture = in.vec2();
        v.lightmap = in.vec2();
        v.normal = in.vec3();
        const auto colour = in.read<std::array<std::uint8_t, 4>>();
        v.colour = Rgba8(colour[0], colour[1], colour[2], colour[3]);
        bool mended = false;
        for (float* value :
             {&v.texture.x, &v.texture.y, &v.lightmap.x, &v.lightmap.y, &v.normal.x, &v.normal.y, &v.normal.z})
            if (!std::isfinite(*value)) {
                *value = 0;
                mended = true;
            }
        if (mended) ++bsp.nonFiniteLightmapCoordinates;
        return v;
    });
}

void readEffects(const Directory& file, Bsp& bsp) {
    file.records(Lump::Effects, bsp.effects, [](ByteReader& in) {
        BspEffect e;
        e.shader = in.name(bspNameBytes);
        e.brush = in.integer();
        e.visibleSide = in.integer();
        return e;
    });
}

void readFaces(const Directory& file, Bsp& bsp) {
    file.records(Lump::Faces, bsp.faces, [](ByteReader& in) {
        BspFace f;
        f.shader = in.integer();
        f.effect = in.integer();
        f.type = static_cast<BspFaceType>(in.integer());
        f.firstVertex = in.integer();
        f.vertexCount = in.integer();
        f.firstMeshVertex = in.integer();
        f.meshVertexCount = in.integer();
        f.lightmap = in.integer();
        f.lightmapStart = in.read<std::array<std::int32_t, 2>>();
        f.lightmapSize = in.read<std::array<std::int32_t, 2>>();
        f.lightmapOrigin = in.vec3();
        f.lightmapVectors = {in.vec3(), in.vec3()};
        f.normal = in.vec3();
        f.patchSize = in.read<std::array<std::int32_t, 2>>();
        return f;
    });
}

void readPlainLumps(const Directory& file, Bsp& bsp) {
    const auto integer = [](ByteReader& in) { return in.integer(); };
    file.records(Lump::LeafFaces, bsp.leafFaces, integer);
    file.records(Lump::LeafBrushes, bsp.leafBrushes, integer);
    file.records(Lump::MeshVertices, bsp.meshVertices, integer);
    file.records(Lump::Lightmaps, bsp.lightmaps, [](ByteReader& in) { return in.read<BspLightmap>(); });
    file.records(Lump::LightVolumes, bsp.lightVolumes, [](ByteReader& in) {
        BspLightVolume v;
        v.ambient = in.read<std::array<std::uint8_t, 3>>();
        v.directed = in.read<std::array<std::uint8_t, 3>>();
        v.direction = in.read<std::array<std::uint8_t, 2>>();
        return v;
    });
}

void readVisibility(const Directory& file, Bsp& bsp) {
    const std::span<const std::byte> content = file.bytes(Lump::Visibility);
    if (content.empty()) return;
    const std::string place = fmt::format("lump {}", lumpName(Lump::Visibility));
    if (content.size() < 8) throw Damage(place, fmt::format("{} bytes are less than its header of 8", content.size()));
    ByteReader in(content);
    BspVisibility& v = bsp.visibility;
    v.clusterCount = in.integer();
    v.bytesPerCluster = in.integer();
    if (v.clusterCount < 0 || v.bytesPerCluster < 0)
        throw Damage(place, fmt::format("{} clusters of {} bytes", v.clusterCount, v.bytesPerCluster));
    if (std::int64_t{v.bytesPerCluster} * 8 < v.clusterCount)
        throw Damage(place,
                     fmt::format("{} bytes per cluster cannot hold {} clusters", v.bytesPerCluster, v.clusterCount));
    if (std::int64_t{v.clusterCount} * v.bytesPerCluster > static_cast<std::int64_t>(in.left()))
        throw Damage(place, fmt::format("{} clusters of {} bytes do not fit into its {} bytes", v.clusterCount,
                                        v.bytesPerCluster, in.left()));
    v.bits.resize(in.left());
    in.copy(v.bits.data(), v.bits.size());
}

// Checks -----------------------------------------------------------------------------------------------------------

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

Result<Bsp> readBsp(std::span<const std::byte> bytes, const std::string& fileName) {
    if (recognise(bytes) != Format::Quake3)
        return Error{fileName, "", "is not a Quake 3 level (IBSP 46) but " + dialect(bytes), ""};
    Bsp bsp;
    try {
        const Directory file(bytes);
        for (const auto read : {readEntities, readShaders, readPlanes, readNodes, readLeaves, readModels, readBrushes,
                                readVertices, readEffects, readFaces, readPlainLumps, readVisibility})
            read(file, bsp);
        for (const auto check :
             {checkPlanes, checkNodes, checkLeaves, checkModels, checkBrushes, checkVertices, checkEffects, checkFaces})
            check(bsp);
    } catch (const Damage& damage) {
        return Error{fileName, damage.place, damage.what(), ""};
    }
    return bsp;
}

} // namespace pie::level
