#include "pie/level/bsp.h"
#include "pie/level/bsp_format.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace pie::level {
namespace {

class ByteWriter {
public:
    template <class T> void value(const T& v) {
        static_assert(std::is_trivially_copyable_v<T>);
        raw(&v, sizeof v);
    }
    void value(const Vec2& v) { value(std::array{v.x, v.y}); }
    void value(const Vec3& v) { value(std::array{v.x, v.y, v.z}); }
    void value(const Rgba8& v) { value(std::array{v.r, v.g, v.b, v.a}); }
    void name(const std::string& text) {
        std::array<char, bspNameBytes> field{};
        // The last byte stays NUL: the game reads the field as a C string.
        std::copy_n(text.begin(), std::min(text.size(), bspNameBytes - 1), field.begin());
        value(field);
    }
    void raw(const void* data, std::size_t size) {
        const auto* first = static_cast<const std::byte*>(data);
        bytes_.insert(bytes_.end(), first, first + size);
    }
    void pad() { bytes_.resize((bytes_.size() + 3) / 4 * 4); }
    void patch(std::size_t at, std::int32_t v) { std::memcpy(bytes_.data() + at, &v, sizeof v); }
    [[nodiscard]] std::size_t size() const { return bytes_.size(); }
    [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

private:
    std::vector<std::byte> bytes_;
};

void put(ByteWriter& out, const BspShader& s) {
    out.name(s.name);
    out.value(s.surfaceFlags);
    out.value(s.contentFlags);
}
void put(ByteWriter& out, const BspPlane& p) {
    out.value(p.normal);
    out.value(p.distance);
}
void put(ByteWriter& out, const BspNode& n) {
    out.value(n.plane);
    out.value(n.children);
    out.value(n.mins);
    out.value(n.maxs);
}
void put(ByteWriter& out, const BspLeaf& l) {
    for (const std::int32_t v : {l.cluster, l.area}) out.value(v);
    out.value(l.mins);
    out.value(l.maxs);
    for (const std::int32_t v : {l.firstLeafFace, l.leafFaceCount, l.firstLeafBrush, l.leafBrushCount}) out.value(v);
}
void put(ByteWriter& out, const BspModel& m) {
    out.value(m.mins);
    out.value(m.maxs);
    for (const std::int32_t v : {m.firstFace, m.faceCount, m.firstBrush, m.brushCount}) out.value(v);
}
void put(ByteWriter& out, const BspBrush& b) {
    for (const std::int32_t v : {b.firstSide, b.sideCount, b.shader}) out.value(v);
}
void put(ByteWriter& out, const BspBrushSide& s) {
    out.value(s.plane);
    out.value(s.shader);
}
void put(ByteWriter& out, const BspVertex& v) {
    out.value(v.position);
    out.value(v.texture);
    out.value(v.lightmap);
    out.value(v.normal);
    out.value(v.colour);
}
void put(ByteWriter& out, const BspEffect& e) {
    out.name(e.shader);
    out.value(e.brush);
    out.value(e.visibleSide);
}
void put(ByteWriter& out, const BspFace& f) {
    for (const std::int32_t v : {f.shader, f.effect, static_cast<std::int32_t>(f.type), f.firstVertex, f.vertexCount,
                                 f.firstMeshVertex, f.meshVertexCount, f.lightmap})
        out.value(v);
    out.value(f.lightmapStart);
    out.value(f.lightmapSize);
    out.value(f.lightmapOrigin);
    for (const Vec3& v : f.lightmapVectors) out.value(v);
    out.value(f.normal);
    out.value(f.patchSize);
}
void put(ByteWriter& out, std::int32_t v) { out.value(v); }
void put(ByteWriter& out, const BspLightmap& l) { out.value(l); }
void put(ByteWriter& out, const BspLightVolume& v) {
    out.value(v.ambient);
    out.value(v.directed);
    out.value(v.direction);
}
void put(ByteWriter& out, const BspVisibility& v) {
    if (v.clusterCount == 0 && v.bits.empty()) return;
    out.value(v.clusterCount);
    out.value(v.bytesPerCluster);
    out.raw(v.bits.data(), v.bits.size());
}
void put(ByteWriter& out, const std::string& text) { out.raw(text.c_str(), text.size() + 1); }
template <class T> void put(ByteWriter& out, const std::vector<T>& records) {
    for (const T& record : records) put(out, record);
}

template <class T> void putLump(ByteWriter& out, Lump lump, const T& content) {
    const std::size_t start = out.size();
    put(out, content);
    const std::size_t entry = 8 + static_cast<std::size_t>(lump) * 8;
    out.patch(entry, static_cast<std::int32_t>(start));
    out.patch(entry + 4, static_cast<std::int32_t>(out.size() - start));
    out.pad();
}

} // namespace

std::vector<std::byte> writeBsp(const Bsp& bsp) {
    ByteWriter out;
    out.raw("IBSP", 4);
    out.value(std::int32_t{46});
    const std::array<std::byte, bspHeaderBytes - 8> directory{};
    out.value(directory);
    putLump(out, Lump::Entities, bsp.entities);
    putLump(out, Lump::Shaders, bsp.shaders);
    putLump(out, Lump::Planes, bsp.planes);
    putLump(out, Lump::Nodes, bsp.nodes);
    putLump(out, Lump::Leaves, bsp.leaves);
    putLump(out, Lump::LeafFaces, bsp.leafFaces);
    putLump(out, Lump::LeafBrushes, bsp.leafBrushes);
    putLump(out, Lump::Models, bsp.models);
    putLump(out, Lump::Brushes, bsp.brushes);
    putLump(out, Lump::BrushSides, bsp.brushSides);
    putLump(out, Lump::Vertices, bsp.vertices);
    putLump(out, Lump::MeshVertices, bsp.meshVertices);
    putLump(out, Lump::Effects, bsp.effects);
    putLump(out, Lump::Faces, bsp.faces);
    putLump(out, Lump::Lightmaps, bsp.lightmaps);
    putLump(out, Lump::LightVolumes, bsp.lightVolumes);
    putLump(out, Lump::Visibility, bsp.visibility);
    return out.take();
}

} // namespace pie::level
