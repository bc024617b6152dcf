#include "pie/scene/receivers.h"

#include "pie/core/parallel.h"
#include "pie/scene/geometry.h"
#include "pie/scene/position_index.h"
#include "pie/scene/takes_light.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace pie::scene {
namespace {

struct Treatment {
    bool lit = false, twoSided = false;
};

Vec3 unitNormal(const Mesh& mesh, const MeshTriangle& triangle, std::size_t corner) {
    const Vec3 stored = mesh.vertices[triangle.vertices[corner]].normal;
    const float length = glm::length(stored);
    if (length > 0.0F && std::isfinite(length)) return stored / length;
    const auto at = [&](std::size_t i) { return mesh.vertices[triangle.vertices[i]].position; };
    const glm::dvec3 across = areaVector(at(0), at(1), at(2));
    const double size = glm::length(across);
    return size > 0 && std::isfinite(size) ? Vec3(across / size) : Vec3(0.0F, 0.0F, 1.0F);
}

/// Normals that agree to a thousandth are one: interpolation and rounding make as much of a difference.
glm::ivec3 rounded(const Vec3& normal) {
    return {static_cast<int>(std::lround(normal.x * 1000.0F)), static_cast<int>(std::lround(normal.y * 1000.0F)),
            static_cast<int>(std::lround(normal.z * 1000.0F))};
}

class Finder {
public:
    Finder(std::vector<Receiver>& points, std::size_t expected) : points_(points), index_(expected) {
        points.reserve(expected);
    }

    std::uint32_t add(const Vec3& position, const Vec3& normal, bool twoSided) {
        const glm::ivec3 direction = rounded(normal);
        const std::uint64_t bits =
            static_cast<std::uint64_t>(direction.x + 1024) | static_cast<std::uint64_t>(direction.y + 1024) << 11U |
            static_cast<std::uint64_t>(direction.z + 1024) << 22U | std::uint64_t{twoSided ? 1U : 0U} << 33U;
        const std::uint32_t hash = mixBits(std::uint64_t{hashPosition(position)} << 32U ^ bits * 0x9e3779b97f4a7c15ULL);
        const std::uint32_t known = index_.find(hash, [&](std::uint32_t i) {
            return points_[i].position == position && points_[i].twoSided == twoSided &&
                   rounded(points_[i].normal) == direction;
        });
        if (known != FlatIndex::none) return known;
        const auto number = static_cast<std::uint32_t>(points_.size());
        points_.push_back({position, normal, position, twoSided});
        index_.insert(hash, number);
        return number;
    }

private:
    std::vector<Receiver>& points_;
    FlatIndex index_;
};

/// The corners (3 × triangle + i) that belong to each receiver.
struct Corners {
    std::vector<std::uint32_t> begin, corners;
};

Corners cornersOf(const Mesh& mesh, const Receivers& receivers) {
    Corners result;
    result.begin.assign(receivers.points.size() + 1, 0);
    const auto receiverAt = [&](std::size_t corner) {
        return receivers.ofVertex[mesh.triangles[corner / 3].vertices[corner % 3]];
    };
    const std::size_t count = 3 * mesh.triangles.size();
    for (std::size_t c = 0; c < count; ++c)
        if (receiverAt(c) != noReceiver) ++result.begin[receiverAt(c) + 1];
    for (std::size_t r = 1; r < result.begin.size(); ++r) result.begin[r] += result.begin[r - 1];
    result.corners.resize(result.begin.back());
    std::vector<std::uint32_t> next(result.begin.begin(), result.begin.end() - 1);
    for (std::size_t c = 0; c < count; ++c)
        if (receiverAt(c) != noReceiver) result.corners[next[receiverAt(c)]++] = static_cast<std::uint32_t>(c);
    return result;
}

float cross(const Vec2& a, const Vec2& b) { return a.x * b.y - a.y * b.x; }

/// What one triangle covers around the receiver, in its tangent plane.
struct Wedge {
    Vec3 first, second;                                                       ///< edges from the receiver, in space
    Vec2 flatFirst, flatSecond;                                               ///< the same in the tangent plane
    Vec2 from, to;                                                            ///< unit, counter-clockwise
    [[nodiscard]] Vec2 sum() const { return {to.y - from.y, from.x - to.x}; } ///< of all unit directions in it
};

bool makeWedge(const Mesh& mesh, std::uint32_t corner, const Receiver& receiver, const Frame& frame, Wedge& wedge) {
    const MeshTriangle& triangle = mesh.triangles[corner / 3];
    const auto at = [&](std::uint32_t i) { return mesh.vertices[triangle.vertices[i % 3]].position; };
    wedge.first = at(corner % 3 + 1) - receiver.position;
    wedge.second = at(corner % 3 + 2) - receiver.position;
    const auto flat = [&](const Vec3& v) { return Vec2(glm::dot(v, frame.tangent), glm::dot(v, frame.bitangent)); };
    wedge.flatFirst = flat(wedge.first);
    wedge.flatSecond = flat(wedge.second);
    if (cross(wedge.flatFirst, wedge.flatSecond) < 0.0F) {
        std::swap(wedge.first, wedge.second);
        std::swap(wedge.flatFirst, wedge.flatSecond);
    }
    const float lengthFirst = glm::length(wedge.flatFirst);
    const float lengthSecond = glm::length(wedge.flatSecond);
    if (!(lengthFirst > 0.0F) || !(lengthSecond > 0.0F)) return false;
    wedge.from = wedge.flatFirst / lengthFirst;
    wedge.to = wedge.flatSecond / lengthSecond;
    return true;
}

/// The way from the receiver to the far side of the triangle in a direction of the tangent plane; zero if the triangle
/// does not lie that way.
Vec3 across(const Wedge& wedge, const Vec2& direction) {
    const float size = cross(wedge.flatFirst, wedge.flatSecond);
    if (!(size > 0.0F)) return Vec3(0.0F);
    const float second = cross(wedge.flatFirst, direction) / size;
    const float first = cross(direction, wedge.flatSecond) / size;
    constexpr float slack = -1e-4F; // a direction along a shared edge belongs to both sides
    if (first + second <= 0.0F || first < slack * second || second < slack * first) return Vec3(0.0F);
    return (glm::max(first, 0.0F) * wedge.first + glm::max(second, 0.0F) * wedge.second) /
           (glm::max(first, 0.0F) + glm::max(second, 0.0F));
}

/// Away from the borders: the sum over all directions in which there is surface. It vanishes where the surface closes
/// around the receiver, whatever the triangles are.
Vec3 insetOf(const Mesh& mesh, std::span<const std::uint32_t> corners, const Receiver& receiver) {
    const Frame frame(receiver.normal);
    Vec2 sum(0.0F);
    Wedge wedge;
    Wedge widest;
    float width = -1.0F;
    for (const std::uint32_t corner : corners) {
        if (!makeWedge(mesh, corner, receiver, frame, wedge)) continue;
        const Vec2 own = wedge.sum();
        sum += own;
        if (glm::length(own) > width) {
            width = glm::length(own);
            widest = wedge;
        }
    }
    constexpr float closed = 0.02F;
    if (width < 0.0F || !(glm::length(sum) > closed)) return receiver.position;
    Vec3 way(0.0F);
    for (const std::uint32_t corner : corners) {
        if (!makeWedge(mesh, corner, receiver, frame, wedge)) continue;
        const Vec3 candidate = across(wedge, sum);
        if (glm::dot(candidate, candidate) > glm::dot(way, way)) way = candidate;
    }
    // Pieces that touch in a point only may leave the mean direction without surface.
    if (way == Vec3(0.0F)) way = across(widest, widest.from + widest.to);
    const float length = glm::length(way);
    if (!(length > 0.0F) || !std::isfinite(length)) return receiver.position;
    return receiver.position + way * std::min(insetShare, insetUnits / length);
}

} // namespace

bool takesLight(const level::Shader& shader) {
    if (shader.stages.empty()) return true;
    return std::any_of(shader.stages.begin(), shader.stages.end(), [](const level::Stage& stage) {
        switch (stage.rgbGen) {
        case level::RgbGen::Vertex:
        case level::RgbGen::ExactVertex:
        case level::RgbGen::OneMinusVertex:
        case level::RgbGen::LightingDiffuse: return true;
        default: return stage.source == level::Stage::Source::Lightmap;
        }
    });
}

Receivers makeReceivers(const Mesh& mesh, const level::Level& level) {
    std::vector<Treatment> shaders(level.shaders.size());
    for (std::size_t s = 0; s < shaders.size(); ++s)
        shaders[s] = {takesLight(level.shaders[s]), level.shaders[s].twoSided()};
    Receivers receivers;
    receivers.ofVertex.assign(mesh.vertices.size(), noReceiver);
    Finder finder(receivers.points, mesh.vertices.size());
    for (const MeshTriangle& triangle : mesh.triangles) {
        const std::uint32_t shader =
            triangle.surface < level.surfaces.size() ? level.surfaces[triangle.surface].shader : 0U;
        const bool known = shader < shaders.size();
        if (known && !shaders[shader].lit) continue;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t v = triangle.vertices[i];
            if (receivers.ofVertex[v] != noReceiver) continue;
            receivers.ofVertex[v] =
                finder.add(mesh.vertices[v].position, unitNormal(mesh, triangle, i), known && shaders[shader].twoSided);
        }
    }
    const Corners corners = cornersOf(mesh, receivers);
    parallelChunks(receivers.points.size(), 2048, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) {
            const std::span all(corners.corners);
            receivers.points[r].inset = insetOf(
                mesh, all.subspan(corners.begin[r], corners.begin[r + 1] - corners.begin[r]), receivers.points[r]);
        }
    });
    return receivers;
}

} // namespace pie::scene
