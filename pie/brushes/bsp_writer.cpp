#include "pie/brushes/bsp_writer.h"

#include "pie/level/level.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace pie::brushes {
namespace {

constexpr double weldCell = 0.25;     // units
constexpr double weldDistance = 0.01; // corners nearer than this are one, in all brushes

Vec3 toFloat(const glm::dvec3& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Coordinates that editors write lie in the middle of a cell.
std::int64_t along(double x) { return static_cast<std::int64_t>(std::floor(x / weldCell + 0.5)); }
std::int64_t cellNumber(std::int64_t x, std::int64_t y, std::int64_t z) { return (z * 2097143 + y) * 2097143 + x; }

} // namespace

/// The corner that was there first, of all within reach: neighbours of different brushes meet in the same bits.
glm::dvec3 BspWriter::weld(const glm::dvec3& p) {
    const glm::dvec3 lower = p - weldDistance;
    const glm::dvec3 upper = p + weldDistance;
    for (std::int64_t z = along(lower.z); z <= along(upper.z); ++z)
        for (std::int64_t y = along(lower.y); y <= along(upper.y); ++y)
            for (std::int64_t x = along(lower.x); x <= along(upper.x); ++x)
                for (std::uint32_t at = cells_.first(cellNumber(x, y, z)); at != ChainedIndex::none;
                     at = cells_.next(at))
                    if (glm::length(corners_[at] - p) < weldDistance) return corners_[at];
    cells_.add(cellNumber(along(p.x), along(p.y), along(p.z)));
    corners_.push_back(p);
    return p;
}

std::int32_t BspWriter::shader(std::uint32_t mapShader) {
    if (places_.size() <= mapShader) places_.resize(shaders_.size(), -1);
    std::int32_t& place = places_[mapShader];
    if (place < 0) {
        place = static_cast<std::int32_t>(bsp.shaders.size());
        const MapShader& from = shaders_[mapShader];
        bsp.shaders.push_back({from.shader.name, from.surfaceFlags, from.contentFlags});
    }
    return place;
}

void BspWriter::addPolygon(const Polygon& polygon, const Side& side, const FaceText& text, const glm::dvec3& origin,
                           std::int32_t effect) {
    Polygon corners;
    for (const glm::dvec3& p : polygon)
        if (const glm::dvec3 corner = weld(p);
            corners.empty() || (corner != corners.back() && corner != corners.front()))
            corners.add(corner);
    if (corners.size() < 3) return;
    const glm::dvec3& normal = planes_[side.plane].normal;
    const std::array<int, 2> size = shaders_.size(side.shader);
    const TextureMapping mapping = makeMapping(text.texture, normal, size[0], size[1]);
    // Whole repeats are taken off, so that coordinates stay small and exact far from the origin.
    const glm::dvec2 first = mapping.at(corners.front());
    const glm::dvec2 repeats(std::floor(first.x), std::floor(first.y));

    level::BspFace face;
    face.shader = shader(side.shader);
    face.effect = effect;
    face.firstVertex = static_cast<std::int32_t>(bsp.vertices.size());
    face.vertexCount = static_cast<std::int32_t>(corners.size());
    face.firstMeshVertex = static_cast<std::int32_t>(bsp.meshVertices.size());
    face.lightmap = level::vertexLit;
    face.normal = toFloat(normal);
    // The file keeps corners clockwise.
    std::reverse(corners.begin(), corners.end());
    for (const glm::dvec3& corner : corners) {
        const glm::dvec2 st = mapping.at(corner) - repeats;
        level::BspVertex vertex;
        vertex.position = toFloat(corner - origin);
        vertex.texture = Vec2(static_cast<float>(st.x), static_cast<float>(st.y));
        vertex.normal = face.normal;
        bsp.vertices.push_back(vertex);
    }
    for (std::int32_t i = 2; i < face.vertexCount; ++i) {
        for (const std::int32_t corner : {0, i - 1, i}) bsp.meshVertices.push_back(corner);
        face.meshVertexCount += 3;
    }
    bsp.faces.push_back(face);
}

void BspWriter::addPatch(const PatchText& patch, std::uint32_t mapShader, const glm::dvec3& origin,
                         std::int32_t effect) {
    level::BspFace face;
    face.shader = shader(mapShader);
    face.effect = effect;
    face.type = level::BspFaceType::Patch;
    face.firstVertex = static_cast<std::int32_t>(bsp.vertices.size());
    face.vertexCount = static_cast<std::int32_t>(patch.controls.size());
    face.firstMeshVertex = static_cast<std::int32_t>(bsp.meshVertices.size());
    face.lightmap = level::vertexLit;
    face.patchSize = {patch.width, patch.height};
    const auto at = [&](int x, int y) -> const glm::dvec3& { return patch.at(x, y).position; };
    glm::dvec3 lower(1e30);
    glm::dvec3 upper(-1e30);
    for (int y = 0; y < patch.height; ++y)
        for (int x = 0; x < patch.width; ++x) {
            const PatchText::Control& control = patch.at(x, y);
            // Along the grid's two directions, over the nearest neighbours that are elsewhere.
            const auto along = [&](int dx, int dy) {
                int back = 0;
                int ahead = 0;
                const auto inside = [&](int step) {
                    return x + step * dx >= 0 && x + step * dx < patch.width && y + step * dy >= 0 &&
                           y + step * dy < patch.height;
                };
                while (inside(ahead + 1) && at(x + ahead * dx, y + ahead * dy) == control.position) ++ahead;
                while (inside(back - 1) && at(x + back * dx, y + back * dy) == control.position) --back;
                return at(x + ahead * dx, y + ahead * dy) - at(x + back * dx, y + back * dy);
            };
            const glm::dvec3 normal = glm::cross(along(1, 0), along(0, 1));
            const double length = glm::length(normal);
            level::BspVertex vertex;
            vertex.position = toFloat(control.position - origin);
            vertex.texture = Vec2(static_cast<float>(control.texture[0]), static_cast<float>(control.texture[1]));
            vertex.normal = length > 0 ? toFloat(normal / length) : Vec3(0.0F); // the tessellation mends it
            bsp.vertices.push_back(vertex);
            lower = glm::min(lower, control.position - origin);
            upper = glm::max(upper, control.position - origin);
        }
    // The game culls patches by these.
    face.lightmapVectors = {toFloat(lower), toFloat(upper)};
    bsp.faces.push_back(face);
}

void BspWriter::addMesh(const Part::Mesh& mesh, const glm::dvec3& origin, std::int32_t effect) {
    constexpr std::int32_t mostVertices = 999;
    constexpr std::int32_t mostIndices = 5997;
    constexpr std::int32_t none = -1;
    std::vector<std::int32_t> places(mesh.vertices.size(), none); // in the piece
    level::BspFace face;
    const auto begin = [&] {
        face = {};
        face.shader = shader(mesh.shader);
        face.effect = effect;
        face.type = level::BspFaceType::Mesh;
        face.firstVertex = static_cast<std::int32_t>(bsp.vertices.size());
        face.firstMeshVertex = static_cast<std::int32_t>(bsp.meshVertices.size());
        face.lightmap = level::vertexLit;
        std::fill(places.begin(), places.end(), none);
    };
    begin();
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        if (face.vertexCount + 3 > mostVertices || face.meshVertexCount + 3 > mostIndices) {
            bsp.faces.push_back(face);
            begin();
        }
        // The file keeps corners clockwise.
        for (const std::size_t corner : {i, i + 2, i + 1}) {
            const ModelVertex& from = mesh.vertices[mesh.indices[corner]];
            std::int32_t& place = places[mesh.indices[corner]];
            if (place == none) {
                place = face.vertexCount++;
                level::BspVertex vertex;
                vertex.position = toFloat(from.position - origin);
                vertex.texture = Vec2(static_cast<float>(from.texture.x), static_cast<float>(from.texture.y));
                const double length = glm::length(from.normal);
                vertex.normal = length > 0 ? toFloat(from.normal / length) : Vec3(0, 0, 1);
                bsp.vertices.push_back(vertex);
            }
            bsp.meshVertices.push_back(place);
            ++face.meshVertexCount;
        }
    }
    if (face.meshVertexCount > 0) bsp.faces.push_back(face);
}

std::int32_t BspWriter::addBrush(const Brush& brush, const glm::dvec3& origin) {
    level::BspBrush written;
    written.firstSide = static_cast<std::int32_t>(bsp.brushSides.size());
    written.shader = shader(brush.sides.front().shader);
    const auto moved = [&](std::uint32_t plane) {
        if (origin == glm::dvec3(0)) return plane;
        Plane shifted = planes_[plane];
        shifted.distance -= glm::dot(shifted.normal, origin);
        return planes_.find(shifted);
    };
    std::vector<bool> used(brush.sides.size(), false);
    // The game takes a brush's bounds from its first six sides: −x +x −y +y −z +z, added where the brush has none.
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            std::size_t found = brush.sides.size();
            for (std::size_t s = 0; s < brush.sides.size(); ++s)
                if (planes_[brush.sides[s].plane].normal[axis] == sign) found = s;
            if (found < brush.sides.size()) {
                used[found] = true;
                const Side& side = brush.sides[found];
                bsp.brushSides.push_back({static_cast<std::int32_t>(moved(side.plane)), shader(side.shader)});
                continue;
            }
            Plane bevel;
            bevel.normal[axis] = sign;
            bevel.distance = sign > 0 ? brush.bounds.upper[axis] : -brush.bounds.lower[axis];
            bevel.distance -= glm::dot(bevel.normal, origin);
            bsp.brushSides.push_back({static_cast<std::int32_t>(planes_.find(bevel)), written.shader});
        }
    for (std::size_t s = 0; s < brush.sides.size(); ++s)
        if (!used[s])
            bsp.brushSides.push_back(
                {static_cast<std::int32_t>(moved(brush.sides[s].plane)), shader(brush.sides[s].shader)});
    written.sideCount = static_cast<std::int32_t>(bsp.brushSides.size()) - written.firstSide;
    bsp.brushes.push_back(written);
    return static_cast<std::int32_t>(bsp.brushes.size()) - 1;
}

} // namespace pie::brushes
