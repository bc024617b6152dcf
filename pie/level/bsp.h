#pragma once
// The Quake 3 BSP file, version 46 ("IBSP"): 17 lumps of little-endian records. `readBsp` checks every index and count
// so that nobody after it has to; `writeBsp` is its inverse and lets tests and tools make levels.
//
// Other dialects (IBSP 47, RBSP, FBSP, VBSP …) are recognised and named in the error. Non-finite positions are an
// error, non-finite lightmap coordinates (18 of 85 shipped levels have them) become 0 and are counted.

#include "pie/core/result.h"
#include "pie/core/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pie::level {

enum class Lump {
    Entities,
    Shaders,
    Planes,
    Nodes,
    Leaves,
    LeafFaces,
    LeafBrushes,
    Models,
    Brushes,
    BrushSides,
    Vertices,
    MeshVertices,
    Effects,
    Faces,
    Lightmaps,
    LightVolumes,
    Visibility
};
inline constexpr int lumpCount = 17;
[[nodiscard]] std::string_view lumpName(Lump lump);

struct BspShader {
    std::string name;
    std::int32_t surfaceFlags = 0;
    std::int32_t contentFlags = 0;
};
struct BspPlane {
    Vec3 normal;
    float distance = 0;
};
/// children: >= 0 a node, < 0 the leaf -(child + 1).
struct BspNode {
    std::int32_t plane = 0;
    std::array<std::int32_t, 2> children{};
    std::array<std::int32_t, 3> mins{}, maxs{};
};
struct BspLeaf {
    std::int32_t cluster = 0, area = 0;
    std::array<std::int32_t, 3> mins{}, maxs{};
    std::int32_t firstLeafFace = 0, leafFaceCount = 0, firstLeafBrush = 0, leafBrushCount = 0;
};
struct BspModel {
    Vec3 mins, maxs;
    std::int32_t firstFace = 0, faceCount = 0, firstBrush = 0, brushCount = 0;
};
struct BspBrush {
    std::int32_t firstSide = 0, sideCount = 0, shader = 0;
};
struct BspBrushSide {
    std::int32_t plane = 0, shader = 0;
};
struct BspVertex {
    Vec3 position;
    Vec2 texture, lightmap;
    Vec3 normal;
    Rgba8 colour{255};
};
struct BspEffect {
    std::string shader;
    std::int32_t brush = 0, visibleSide = -1;
};
enum class BspFaceType : std::int32_t { Polygon = 1, Patch = 2, Mesh = 3, Flare = 4 };
struct BspFace {
    std::int32_t shader = 0, effect = -1;
    BspFaceType type = BspFaceType::Polygon;
    std::int32_t firstVertex = 0, vertexCount = 0, firstMeshVertex = 0, meshVertexCount = 0;
    std::int32_t lightmap = -1; ///< -3: vertex colours; other negatives: none
    std::array<std::int32_t, 2> lightmapStart{}, lightmapSize{};
    Vec3 lightmapOrigin;
    std::array<Vec3, 2> lightmapVectors{};
    Vec3 normal;
    std::array<std::int32_t, 2> patchSize{};
};
inline constexpr int lightmapSide = 128;
using BspLightmap = std::array<std::uint8_t, std::size_t{lightmapSide} * lightmapSide * 3>;
struct BspLightVolume {
    std::array<std::uint8_t, 3> ambient{}, directed{};
    std::array<std::uint8_t, 2> direction{};
};
struct BspVisibility {
    std::int32_t clusterCount = 0, bytesPerCluster = 0;
    std::vector<std::uint8_t> bits;
};

struct Bsp {
    std::string entities;
    std::vector<BspShader> shaders;
    std::vector<BspPlane> planes;
    std::vector<BspNode> nodes;
    std::vector<BspLeaf> leaves;
    std::vector<std::int32_t> leafFaces, leafBrushes;
    std::vector<BspModel> models;
    std::vector<BspBrush> brushes;
    std::vector<BspBrushSide> brushSides;
    std::vector<BspVertex> vertices;
    std::vector<std::int32_t> meshVertices;
    std::vector<BspEffect> effects;
    std::vector<BspFace> faces;
    std::vector<BspLightmap> lightmaps;
    std::vector<BspLightVolume> lightVolumes;
    BspVisibility visibility;
    std::size_t nonFiniteLightmapCoordinates = 0; ///< vertices mended while reading
};

/// `fileName` is used in messages only. The Error names lump, record index and field.
[[nodiscard]] Result<Bsp> readBsp(std::span<const std::byte> bytes, const std::string& fileName);
[[nodiscard]] std::vector<std::byte> writeBsp(const Bsp& bsp);
/// What a file that starts with these bytes is; at least the first 8 are looked at. Only Quake3 is read here; a Source
/// level ("VBSP") is for OSG's own reader.
enum class Format { Quake3, QuakeLiveOrWolfenstein, Quake2, Quake1, Raven, Fusion, Source, Text, Archive, Unknown };
[[nodiscard]] Format recognise(std::span<const std::byte> bytes);
/// "IBSP 46" and the like, with the game it belongs to; says what it saw when the magic is unknown.
[[nodiscard]] std::string dialect(std::span<const std::byte> bytes);

} // namespace pie::level
