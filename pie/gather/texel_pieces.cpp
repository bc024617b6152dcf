#include "pie/gather/texel_pieces.h"

#include "pie/core/parallel.h"
#include "pie/gather/cell_split.h"

#include <algorithm>

namespace pie::gather {
namespace {

void cutTriangle(const scene::Scene& scene, std::uint32_t triangle, const glm::dvec3& origin, double scale,
                 unsigned direction, std::vector<TexelPiece>& out) {
    CellPolygon polygon;
    for (int i = 0; i < 3; ++i) polygon.add((glm::dvec3(scene.corner(triangle, i)) - origin) * scale);
    const bool twoSided = scene.material(triangle).twoSided;
    forEachCell(polygon, [&](const glm::ivec3& cell, const CellPolygon& part) {
        for (std::size_t i = 2; i < part.count; ++i) {
            TexelPiece piece;
            const glm::dvec3 side1 = (part.corners[i - 1] - part.corners[0]) / scale;
            const glm::dvec3 side2 = (part.corners[i] - part.corners[0]) / scale;
            piece.area = static_cast<float>(0.5 * glm::length(glm::cross(side1, side2)));
            if (!(piece.area > 0.0F)) continue;
            piece.triangle = triangle;
            piece.key = texelKey(cell, direction);
            piece.corner = Vec3(part.corners[0] / scale + origin);
            piece.side1 = Vec3(side1);
            piece.side2 = Vec3(side2);
            out.push_back(piece);
            if (!twoSided) continue;
            piece.key = texelKey(cell, direction ^ 1U);
            piece.back = true;
            out.push_back(piece);
        }
    });
}

} // namespace

unsigned facing(const glm::dvec3& normal) {
    const glm::dvec3 size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return static_cast<unsigned>(2 * axis) + (normal[axis] < 0 ? 1U : 0U);
}

std::uint64_t texelKey(const glm::ivec3& cell, unsigned direction) {
    const auto bits = [](int c) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(c) & 0xfffffU); };
    return bits(cell.x) | bits(cell.y) << 20U | bits(cell.z) << 40U | std::uint64_t{direction} << 60U;
}

glm::ivec3 texelCell(std::uint64_t key) {
    const auto coordinate = [](std::uint64_t bits) { return static_cast<int>(bits & 0xfffffU); };
    return {coordinate(key), coordinate(key >> 20U), coordinate(key >> 40U)};
}

bool keepsLight(const scene::Scene& scene, std::size_t triangle) {
    return scene.material(triangle).interaction != scene::Interaction::Sky && scene.normals[triangle] != Vec3(0.0F);
}

bool cutAll(const scene::Scene& scene, const glm::dvec3& origin, double scale, std::span<const std::uint8_t> direction,
            std::size_t most, std::vector<TexelPiece>& pieces) {
    constexpr std::size_t trianglesPerTask = 256;
    const std::size_t count = scene.triangles.size();
    std::vector<std::vector<TexelPiece>> parts((count + trianglesPerTask - 1) / trianglesPerTask);
    parallelChunks(count, trianglesPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t)
            if (direction[t] != 255)
                cutTriangle(scene, static_cast<std::uint32_t>(t), origin, scale, direction[t],
                            parts[begin / trianglesPerTask]);
    });
    std::size_t size = 0;
    for (const auto& part : parts) size += part.size();
    if (size > most * 8) return false;
    pieces.clear();
    pieces.reserve(size);
    for (const auto& part : parts) pieces.insert(pieces.end(), part.begin(), part.end());
    return true;
}

std::size_t cellsOf(std::span<const TexelPiece> pieces) {
    std::vector<std::uint64_t> keys;
    keys.reserve(pieces.size());
    for (const TexelPiece& piece : pieces) keys.push_back(piece.key);
    std::sort(keys.begin(), keys.end());
    return static_cast<std::size_t>(std::unique(keys.begin(), keys.end()) - keys.begin());
}

} // namespace pie::gather
