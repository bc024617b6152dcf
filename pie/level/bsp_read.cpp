// One small function per lump. Records are read first and checked in a second pass (bsp_check.cpp), when all lumps they
// may point into are known. Exceptions (Damage) do not leave readBsp.

#include "pie/level/bsp.h"
#include "pie/level/bsp_check.h"
#include "pie/level/bsp_format.h"
#include "pie/level/byte_reader.h"

#include <fmt/format.h>

#include <cmath>

namespace pie::level {
namespace {

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
        checkBsp(bsp);
    } catch (const Damage& damage) {
        return Error{fileName, damage.place, damage.what(), ""};
    }
    return bsp;
}

} // namespace pie::level
