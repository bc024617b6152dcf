#include "tests/scene/shapes.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

namespace pie::test {
namespace {

using Key = std::tuple<float, float, float>;

Key keyOf(const Vec3& p) { return {p.x, p.y, p.z}; }
Vec3 positionOf(const Key& key) { return {std::get<0>(key), std::get<1>(key), std::get<2>(key)}; }

double distanceToLine(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
    return glm::length(glm::cross(p - a, glm::normalize(b - a)));
}

double shareAlong(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
    return glm::dot(p - a, b - a) / glm::dot(b - a, b - a);
}

/// The corners opposite to an edge.
using Apexes = std::vector<Vec3>;

/// A vertex beside a sliver is its neighbour; one that would turn a triangle over is a T-junction of another edge.
bool ends(const glm::dvec3& a, const glm::dvec3& b, const Apexes& apexes, const glm::dvec3& p) {
    for (const glm::dvec3 c : apexes) {
        const double share = shareAlong(a, b, c);
        if (share > 0.01 && share < 0.99 && distanceToLine(a, b, p) >= 0.25 * distanceToLine(a, b, c)) return false;
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        if (glm::dot(glm::cross(p - a, c - a), normal) <= 0 || glm::dot(glm::cross(b - p, c - p), normal) <= 0)
            return false;
    }
    return true;
}

bool inside(const Vec3& a, const Vec3& b, const Apexes& apexes, const Vec3& p, double tolerance) {
    const double length = glm::length(glm::dvec3(b) - glm::dvec3(a));
    if (!(length > 0)) return false;
    const double reach = std::min(tolerance, 0.01 * length);
    const double at = shareAlong(a, b, p) * length;
    return at > reach && at < length - reach && distanceToLine(a, b, p) < reach && ends(a, b, apexes, p);
}

/// Each position and each edge once, found with ordered containers: slow, and nothing like the code under test.
struct Welded {
    std::vector<Vec3> positions;
    std::map<std::pair<Key, Key>, Apexes> edges;
};

Welded weld(const scene::Mesh& mesh) {
    Welded welded;
    std::set<Key> positions;
    for (const scene::MeshTriangle& triangle : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const Key p = keyOf(mesh.vertices[triangle.vertices[i]].position);
            const Key q = keyOf(mesh.vertices[triangle.vertices[(i + 1) % 3]].position);
            positions.insert(p);
            const Vec3 apex = mesh.vertices[triangle.vertices[(i + 2) % 3]].position;
            welded.edges[{std::min(p, q), std::max(p, q)}].push_back(apex);
        }
    for (const Key& key : positions) welded.positions.push_back(positionOf(key));
    return welded;
}

void addTriangle(scene::Mesh& mesh, const std::array<Vec3, 3>& corners) {
    const Vec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    scene::MeshTriangle& triangle = mesh.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
        triangle.vertices[i] = static_cast<std::uint32_t>(mesh.vertices.size());
        level::Vertex& vertex = mesh.vertices.emplace_back();
        vertex.position = corners[i];
        vertex.normal = across / glm::length(across);
        vertex.texture = Vec2(corners[i]);
    }
}

} // namespace

std::shared_ptr<level::Image> picture(int width, int height, const Rgba8& colour) {
    auto image = std::make_shared<level::Image>();
    image->width = width;
    image->height = height;
    image->hasAlpha = colour.w != 255;
    image->pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), colour);
    return image;
}

LevelMaker::LevelMaker() { level.models.emplace_back(); }

std::uint32_t LevelMaker::shader(const std::string& name, std::shared_ptr<const level::Image> image) {
    level::Shader& made = level.shaders.emplace_back();
    made.name = name;
    made.origin = "image";
    level::Stage lightmap;
    lightmap.source = level::Stage::Source::Lightmap;
    lightmap.tcGen = level::TcGen::Lightmap;
    level::Stage texture;
    texture.images = {name};
    texture.blend = {level::BlendFactor::DestinationColour, level::BlendFactor::Zero};
    made.stages = {lightmap, texture};
    if (image) {
        level.textureIndex[name] = level.textures.size();
        level.textures.push_back({name, name + ".tga", std::move(image), false});
    }
    return static_cast<std::uint32_t>(level.shaders.size() - 1);
}

std::uint32_t LevelMaker::polygon(std::uint32_t shader, const std::vector<Vec3>& corners, std::uint32_t model) {
    level::Surface surface;
    surface.shader = shader;
    surface.model = model;
    surface.lightmap = 0;
    surface.firstVertex = static_cast<std::uint32_t>(level.vertices.size());
    surface.vertexCount = static_cast<std::uint32_t>(corners.size());
    surface.firstIndex = static_cast<std::uint32_t>(level.indices.size());
    const Vec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    for (const Vec3& corner : corners) {
        level::Vertex& vertex = level.vertices.emplace_back();
        vertex.position = corner;
        const float length = glm::length(across);
        vertex.normal = length > 0.0F ? across / length : Vec3(0, 0, 1);
        vertex.texture = Vec2(corner) / 64.0F;
    }
    for (std::uint32_t i = 2; i < corners.size(); ++i)
        for (const std::uint32_t corner : {0U, i - 1, i}) level.indices.push_back(surface.firstVertex + corner);
    surface.indexCount = static_cast<std::uint32_t>(level.indices.size()) - surface.firstIndex;
    level.surfaces.push_back(surface);
    return static_cast<std::uint32_t>(level.surfaces.size() - 1);
}

void LevelMaker::room(std::uint32_t shader, const Vec3& lower, const Vec3& upper) {
    const auto at = [&](int x, int y, int z) {
        return Vec3(x != 0 ? upper.x : lower.x, y != 0 ? upper.y : lower.y, z != 0 ? upper.z : lower.z);
    };
    polygon(shader, {at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0)});
    polygon(shader, {at(0, 0, 1), at(0, 1, 1), at(1, 1, 1), at(1, 0, 1)});
    polygon(shader, {at(0, 0, 0), at(0, 1, 0), at(0, 1, 1), at(0, 0, 1)});
    polygon(shader, {at(1, 0, 0), at(1, 0, 1), at(1, 1, 1), at(1, 1, 0)});
    polygon(shader, {at(0, 0, 0), at(0, 0, 1), at(1, 0, 1), at(1, 0, 0)});
    polygon(shader, {at(0, 1, 0), at(1, 1, 0), at(1, 1, 1), at(0, 1, 1)});
}

scene::Mesh soup(const std::vector<Vec3>& corners) {
    scene::Mesh mesh;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
        addTriangle(mesh, {corners[i], corners[i + 1], corners[i + 2]});
    return mesh;
}

scene::Mesh cutFloor(std::mt19937& random, int cuts, float size, bool snapped) {
    struct Rectangle {
        Vec2 lower, upper;
    };
    std::vector<Rectangle> pieces{{Vec2(0.0F), Vec2(size)}};
    std::uniform_real_distribution<float> share(0.2F, 0.8F);
    for (int i = 0; i < cuts; ++i) {
        const std::size_t which = std::uniform_int_distribution<std::size_t>(0, pieces.size() - 1)(random);
        Rectangle first = pieces[which];
        Rectangle second = first;
        const int axis = first.upper.x - first.lower.x > first.upper.y - first.lower.y ? 0 : 1;
        float at = first.lower[axis] + share(random) * (first.upper[axis] - first.lower[axis]);
        if (snapped) at = std::round(at);
        if (at <= first.lower[axis] + 1.0F || at >= first.upper[axis] - 1.0F) continue;
        first.upper[axis] = at;
        second.lower[axis] = at;
        pieces[which] = first;
        pieces.push_back(second);
    }
    scene::Mesh mesh;
    for (const Rectangle& piece : pieces) {
        const Vec3 a(piece.lower, 0.0F);
        const Vec3 b(piece.upper.x, piece.lower.y, 0.0F);
        const Vec3 c(piece.upper, 0.0F);
        const Vec3 d(piece.lower.x, piece.upper.y, 0.0F);
        addTriangle(mesh, {a, b, c});
        addTriangle(mesh, {a, c, d});
    }
    return mesh;
}

std::size_t countTJunctions(const scene::Mesh& mesh, double tolerance) {
    const Welded welded = weld(mesh);
    std::size_t count = 0;
    for (const auto& [edge, apexes] : welded.edges) {
        const Vec3 a = positionOf(edge.first);
        const Vec3 b = positionOf(edge.second);
        for (const Vec3& p : welded.positions)
            if (inside(a, b, apexes, p, tolerance)) ++count;
    }
    return count;
}

std::size_t countTJunctionsSorted(const scene::Mesh& mesh, double tolerance) {
    const Welded welded = weld(mesh); // positions come out ordered by x
    const auto before = [](const Vec3& p, double x) { return p.x < x; };
    std::size_t count = 0;
    for (const auto& [edge, apexes] : welded.edges) {
        const Vec3 a = positionOf(edge.first);
        const Vec3 b = positionOf(edge.second);
        auto p = std::lower_bound(welded.positions.begin(), welded.positions.end(), a.x - tolerance, before);
        for (; p != welded.positions.end() && p->x <= b.x + tolerance; ++p)
            if (inside(a, b, apexes, *p, tolerance)) ++count;
    }
    return count;
}

double areaOf(const scene::Mesh& mesh) {
    double area = 0;
    for (const scene::MeshTriangle& triangle : mesh.triangles) {
        const auto at = [&](std::size_t i) { return glm::dvec3(mesh.vertices[triangle.vertices[i]].position); };
        area += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
    }
    return area;
}

double longestEdgeOf(const scene::Mesh& mesh) {
    double longest = 0;
    for (const auto& [edge, apexes] : weld(mesh).edges)
        longest =
            std::max(longest, glm::length(glm::dvec3(positionOf(edge.first)) - glm::dvec3(positionOf(edge.second))));
    return longest;
}

std::size_t openEdges(const scene::Mesh& mesh) {
    std::map<std::pair<Key, Key>, int> uses;
    for (const scene::MeshTriangle& triangle : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const Key p = keyOf(mesh.vertices[triangle.vertices[i]].position);
            const Key q = keyOf(mesh.vertices[triangle.vertices[(i + 1) % 3]].position);
            ++uses[{std::min(p, q), std::max(p, q)}];
        }
    return static_cast<std::size_t>(
        std::count_if(uses.begin(), uses.end(), [](const auto& use) { return use.second != 2; }));
}

} // namespace pie::test
