#include "pie/level/assemble.h"
#include "pie/level/image.h"
#include "pie/level/names.h"
#include "pie/level/patch.h"

#include "pie/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace pie::level {
namespace {

constexpr std::size_t maxPatchVertices = std::size_t{1} << 25; ///< of all patches together, after tessellation

/// Shaders in the order in which surfaces first use them. A script serves lightmapped and vertex-lit surfaces alike,
/// an image makes two different shaders.
class ShaderTable {
public:
    ShaderTable(Level& level, const AssemblyInput& input)
        : level_(&level), input_(&input), known_(2 * input.bsp.shaders.size(), -1) {}

    std::uint32_t indexOf(const BspFace& face) {
        const bool lightmapped = face.lightmap >= 0;
        std::int64_t& known = known_[2 * static_cast<std::size_t>(face.shader) + (lightmapped ? 1 : 0)];
        if (known < 0) known = add(input_->bsp.shaders[static_cast<std::size_t>(face.shader)], lightmapped);
        return static_cast<std::uint32_t>(known);
    }

private:
    std::int64_t add(const BspShader& entry, bool lightmapped) {
        Shader shader = input_->shaders.resolve(entry.name, lightmapped);
        // The lump may name one shader twice with other flags.
        const std::string key = fmt::format("{} {} {} {}", shader.name, entry.surfaceFlags, entry.contentFlags,
                                            lightmapped || shader.origin != "image");
        const auto [at, isNew] = byKey_.try_emplace(key, static_cast<std::int64_t>(level_->shaders.size()));
        if (!isNew) return at->second;
        if (shader.origin == "image" && findImage(*level_->files, entry.name).empty()) shader.origin = "missing";
        shader.parms.addFlags(entry.surfaceFlags, entry.contentFlags);
        level_->shaders.push_back(std::move(shader));
        return at->second;
    }

    Level* level_;
    const AssemblyInput* input_;
    std::vector<std::int64_t> known_;
    std::unordered_map<std::string, std::int64_t> byKey_;
};

/// In double: damaged normals may be long enough for their square to overflow a float.
Vec3 unitOr(const Vec3& v, const Vec3& fallback) {
    for (const Vec3& candidate : {v, fallback})
        if (const double length = glm::length(glm::dvec3(candidate)); std::isfinite(length) && length > 1e-6)
            return glm::dvec3(candidate) / length;
    return {0, 0, 1};
}

std::span<const BspVertex> verticesOf(const Bsp& bsp, const BspFace& face) {
    return std::span(bsp.vertices)
        .subspan(static_cast<std::size_t>(face.firstVertex), static_cast<std::size_t>(face.vertexCount));
}

PatchMesh tessellateFace(const Bsp& bsp, const BspFace& face, float tolerance) {
    std::vector<PatchVertex> controls;
    controls.reserve(static_cast<std::size_t>(face.vertexCount));
    for (const BspVertex& v : verticesOf(bsp, face))
        controls.push_back({v.position, v.normal, v.texture, v.lightmap, Vec4(v.colour)});
    return tessellate(controls, face.patchSize[0], face.patchSize[1], tolerance);
}

/// All patches of the file at once: they are independent of each other and the costly part of the geometry.
std::vector<PatchMesh> tessellateAll(const Bsp& bsp, const std::vector<std::size_t>& patches, float tolerance) {
    std::vector<PatchMesh> meshes(patches.size());
    parallelChunks(patches.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) meshes[i] = tessellateFace(bsp, bsp.faces[patches[i]], tolerance);
    });
    return meshes;
}

class SurfaceBuilder {
public:
    SurfaceBuilder(Level& level, const AssemblyInput& input) : level_(&level), bsp_(&input.bsp) {}

    void start(const Vec3& origin) { origin_ = origin; }

    void addTriangles(const BspFace& face, Surface& surface) {
        begin(surface);
        for (const BspVertex& v : verticesOf(*bsp_, face))
            level_->vertices.push_back(
                {v.position + origin_, unitOr(v.normal, face.normal), v.texture, v.lightmap, v.colour});
        const auto first = static_cast<std::size_t>(face.firstMeshVertex);
        for (std::size_t i = first; i < first + static_cast<std::size_t>(face.meshVertexCount); i += 3)
            // The file's triangles are clockwise from the front.
            for (const std::size_t corner : {i, i + 2, i + 1})
                level_->indices.push_back(surface.firstVertex + static_cast<std::uint32_t>(bsp_->meshVertices[corner]));
        end(surface);
    }

    void addPatch(const PatchMesh& mesh, Surface& surface) {
        begin(surface);
        for (const PatchVertex& v : mesh.vertices) {
            const Vec4 colour = glm::clamp(v.colour, 0.0F, 255.0F) + 0.5F;
            level_->vertices.push_back({v.position + origin_, v.normal, v.texture, v.lightmap, Rgba8(colour)});
        }
        for (const std::uint32_t index : mesh.indices) level_->indices.push_back(surface.firstVertex + index);
        end(surface);
    }

private:
    void begin(Surface& surface) const {
        surface.firstVertex = static_cast<std::uint32_t>(level_->vertices.size());
        surface.firstIndex = static_cast<std::uint32_t>(level_->indices.size());
    }
    void end(Surface& surface) const {
        surface.vertexCount = static_cast<std::uint32_t>(level_->vertices.size()) - surface.firstVertex;
        surface.indexCount = static_cast<std::uint32_t>(level_->indices.size()) - surface.firstIndex;
    }

    Level* level_;
    const Bsp* bsp_;
    Vec3 origin_{0.0F};
};

/// Which model each face belongs to; faces that no submodel claims are the world's.
std::vector<std::uint32_t> modelOfFaces(const Bsp& bsp) {
    std::vector<std::uint32_t> result(bsp.faces.size(), 0);
    for (std::size_t m = 1; m < bsp.models.size(); ++m)
        std::fill_n(result.begin() + bsp.models[m].firstFace, bsp.models[m].faceCount, static_cast<std::uint32_t>(m));
    return result;
}

void countFace(BspFaceType type, LoadStatistics& statistics) {
    switch (type) {
    case BspFaceType::Polygon: ++statistics.polygons; break;
    case BspFaceType::Patch: ++statistics.patches; break;
    case BspFaceType::Mesh: ++statistics.meshes; break;
    case BspFaceType::Flare: ++statistics.flares; break;
    }
}

SurfaceKind kindOf(BspFaceType type) {
    if (type == BspFaceType::Patch) return SurfaceKind::Patch;
    return type == BspFaceType::Mesh ? SurfaceKind::Mesh : SurfaceKind::Polygon;
}

} // namespace

std::optional<Error> addSurfaces(Level& level, const AssemblyInput& input) {
    const Bsp& bsp = input.bsp;
    std::vector<std::size_t> patches;
    for (std::size_t i = 0; i < bsp.faces.size(); ++i)
        if (bsp.faces[i].type == BspFaceType::Patch) patches.push_back(i);
    const std::vector<PatchMesh> meshes = tessellateAll(bsp, patches, input.options.patchTolerance);
    std::size_t patchVertices = 0;
    for (const PatchMesh& mesh : meshes) patchVertices += mesh.vertices.size();
    if (patchVertices > maxPatchVertices)
        return Error{level.file, "lump faces", fmt::format("its patches make more than {} vertices", maxPatchVertices),
                     ""};

    level.vertices.reserve(bsp.vertices.size() + patchVertices);
    level.indices.reserve(bsp.meshVertices.size() + 6 * patchVertices);
    const std::vector<std::uint32_t> models = modelOfFaces(bsp);
    ShaderTable shaders(level, input);
    SurfaceBuilder builder(level, input);
    std::size_t nextPatch = 0;
    for (std::size_t i = 0; i < bsp.faces.size(); ++i) {
        const BspFace& face = bsp.faces[i];
        countFace(face.type, level.statistics);
        if (face.type == BspFaceType::Flare) continue;
        Surface surface;
        surface.shader = shaders.indexOf(face);
        surface.lightmap = face.lightmap >= 0 ? face.lightmap : face.lightmap == vertexLit ? vertexLit : noLightmap;
        surface.model = models[i];
        surface.fog = face.effect;
        surface.kind = kindOf(face.type);
        builder.start(level.models[surface.model].origin);
        if (face.type == BspFaceType::Patch)
            builder.addPatch(meshes[nextPatch++], surface);
        else
            builder.addTriangles(face, surface);
        level.surfaces.push_back(surface);
    }
    return std::nullopt;
}

void addDrawnStatistics(Level& level) {
    LoadStatistics& s = level.statistics;
    for (const Surface& surface : level.surfaces) {
        if (!level.shaders[surface.shader].drawn() || !level.models[surface.model].drawn) continue;
        s.drawnTriangles += surface.indexCount / 3;
        for (std::size_t i = surface.firstIndex; i < surface.firstIndex + surface.indexCount; i += 3) {
            const Vec3& a = level.vertices[level.indices[i]].position;
            const Vec3& b = level.vertices[level.indices[i + 1]].position;
            const Vec3& c = level.vertices[level.indices[i + 2]].position;
            s.drawnArea += 0.5 * glm::length(glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a)));
            for (const Vec3& corner : {a, b, c}) s.drawnBounds.extend(corner);
        }
    }
}

} // namespace pie::level
