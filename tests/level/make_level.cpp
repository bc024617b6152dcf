#include "tests/level/make_level.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pie::test {

using namespace level;

LevelBuilder::LevelBuilder(const Pairs& worldspawn) {
    Pairs pairs = {{"classname", "worldspawn"}};
    pairs.insert(pairs.end(), worldspawn.begin(), worldspawn.end());
    entity(pairs);
    bsp_.models.emplace_back();
}

int LevelBuilder::shader(const std::string& name, std::int32_t surfaceFlags, std::int32_t contentFlags) {
    for (std::size_t i = 0; i < bsp_.shaders.size(); ++i) {
        const BspShader& s = bsp_.shaders[i];
        if (s.name == name && s.surfaceFlags == surfaceFlags && s.contentFlags == contentFlags)
            return static_cast<int>(i);
    }
    bsp_.shaders.push_back({name, surfaceFlags, contentFlags});
    return static_cast<int>(bsp_.shaders.size()) - 1;
}

void LevelBuilder::entity(const Pairs& pairs) {
    bsp_.entities += "{\n";
    for (const auto& [key, value] : pairs) bsp_.entities += fmt::format("\"{}\" \"{}\"\n", key, value);
    bsp_.entities += "}\n";
}

int LevelBuilder::submodel() {
    BspModel model;
    model.firstFace = static_cast<std::int32_t>(bsp_.faces.size());
    bsp_.models.push_back(model);
    return static_cast<int>(bsp_.models.size()) - 1;
}

int LevelBuilder::polygon(int shader, const std::vector<Vec3>& corners, int lightmap) {
    BspFace face;
    face.shader = shader;
    face.lightmap = lightmap;
    face.firstVertex = static_cast<std::int32_t>(bsp_.vertices.size());
    face.vertexCount = static_cast<std::int32_t>(corners.size());
    face.firstMeshVertex = static_cast<std::int32_t>(bsp_.meshVertices.size());
    face.meshVertexCount = 3 * (face.vertexCount - 2);
    const Vec3 normal = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    face.normal = normal;
    for (const Vec3& corner : corners) {
        BspVertex v;
        v.position = corner;
        v.texture = Vec2(corner.x, corner.y) / 64.0F;
        v.lightmap = Vec2(0.5F);
        v.normal = normal;
        bsp_.vertices.push_back(v);
    }
    for (std::int32_t i = 2; i < face.vertexCount; ++i)
        for (const std::int32_t corner : {0, i, i - 1}) bsp_.meshVertices.push_back(corner);
    bsp_.faces.push_back(face);
    ++bsp_.models.back().faceCount;
    return static_cast<int>(bsp_.faces.size()) - 1;
}

int LevelBuilder::patch(int shader, int width, int height, const std::vector<Vec3>& controls, int lightmap) {
    BspFace face;
    face.shader = shader;
    face.type = BspFaceType::Patch;
    face.lightmap = lightmap;
    face.firstVertex = static_cast<std::int32_t>(bsp_.vertices.size());
    face.vertexCount = width * height;
    face.patchSize = {width, height};
    for (std::size_t i = 0; i < controls.size(); ++i) {
        BspVertex v;
        v.position = controls[i];
        const std::size_t row = i / static_cast<std::size_t>(width);
        v.texture = Vec2(static_cast<float>(i % static_cast<std::size_t>(width)), static_cast<float>(row));
        v.normal = Vec3(0, 0, 1);
        bsp_.vertices.push_back(v);
    }
    bsp_.faces.push_back(face);
    ++bsp_.models.back().faceCount;
    return static_cast<int>(bsp_.faces.size()) - 1;
}

void LevelBuilder::room(const Vec3& a, const Vec3& b, const std::array<int, 6>& shaders, int lightmap) {
    const std::array<std::vector<Vec3>, 6> walls = {{
        {{a.x, a.y, a.z}, {a.x, b.y, a.z}, {a.x, b.y, b.z}, {a.x, a.y, b.z}},
        {{b.x, b.y, a.z}, {b.x, a.y, a.z}, {b.x, a.y, b.z}, {b.x, b.y, b.z}},
        {{b.x, a.y, a.z}, {a.x, a.y, a.z}, {a.x, a.y, b.z}, {b.x, a.y, b.z}},
        {{a.x, b.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z}},
        {{a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, b.y, a.z}, {a.x, b.y, a.z}},
        {{a.x, b.y, b.z}, {b.x, b.y, b.z}, {b.x, a.y, b.z}, {a.x, a.y, b.z}},
    }};
    for (std::size_t i = 0; i < walls.size(); ++i) polygon(shaders.at(i), walls.at(i), lightmap);
}

int LevelBuilder::brush(int shader, const Vec3& lower, const Vec3& upper) {
    BspBrush added{static_cast<std::int32_t>(bsp_.brushSides.size()), 6, shader};
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {-1.0F, 1.0F}) {
            Vec3 normal(0.0F);
            normal[axis] = sign;
            bsp_.brushSides.push_back({static_cast<std::int32_t>(bsp_.planes.size()), shader});
            bsp_.planes.push_back({normal, sign < 0 ? -lower[axis] : upper[axis]});
        }
    bsp_.brushes.push_back(added);
    return static_cast<int>(bsp_.brushes.size()) - 1;
}

void LevelBuilder::effect(const std::string& shader, int brush, int visibleSide) {
    bsp_.effects.push_back({shader, brush, visibleSide});
}

Bsp LevelBuilder::build() const {
    Bsp bsp = bsp_;
    for (BspModel& model : bsp.models) {
        Box bounds;
        for (std::int32_t f = model.firstFace; f < model.firstFace + model.faceCount; ++f) {
            const BspFace& face = bsp.faces[static_cast<std::size_t>(f)];
            for (std::int32_t v = 0; v < face.vertexCount; ++v)
                bounds.extend(
                    bsp.vertices[static_cast<std::size_t>(face.firstVertex) + static_cast<std::size_t>(v)].position);
        }
        model.mins = bounds.empty() ? Vec3(0.0F) : bounds.lower;
        model.maxs = bounds.empty() ? Vec3(0.0F) : bounds.upper;
    }
    const BspModel& world = bsp.models.front();
    const auto corner = [](const Vec3& v) {
        return std::array{static_cast<std::int32_t>(v.x), static_cast<std::int32_t>(v.y),
                          static_cast<std::int32_t>(v.z)};
    };
    BspLeaf leaf;
    leaf.mins = corner(world.mins);
    leaf.maxs = corner(world.maxs);
    leaf.leafFaceCount = world.faceCount;
    leaf.leafBrushCount = static_cast<std::int32_t>(bsp.brushes.size());
    for (std::int32_t f = 0; f < world.faceCount; ++f) bsp.leafFaces.push_back(f);
    for (std::int32_t b = 0; b < leaf.leafBrushCount; ++b) bsp.leafBrushes.push_back(b);
    BspLeaf solid;
    solid.cluster = -1;
    bsp.leaves = {leaf, solid};
    bsp.planes.push_back({Vec3(0, 0, 1), world.mins.z - 1});
    BspNode node;
    node.plane = static_cast<std::int32_t>(bsp.planes.size()) - 1;
    node.children = {-1, -2};
    node.mins = leaf.mins;
    node.maxs = leaf.maxs;
    bsp.nodes.push_back(node);
    return bsp;
}

std::vector<Vec3> controlGrid(int width, int height, float step, const std::function<float(int, int)>& z) {
    std::vector<Vec3> controls;
    controls.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column)
            controls.emplace_back(step * static_cast<float>(column), step * static_cast<float>(row), z(column, row));
    return controls;
}

Bytes toBytes(std::string_view text) {
    Bytes bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
    return bytes;
}

Location inMemory(const Bsp& bsp, std::vector<std::pair<std::string, Bytes>> files, const std::string& name) {
    Location location;
    location.name = name;
    files.emplace_back(name, writeBsp(bsp));
    location.files.mountMemory("memory", std::move(files));
    return location;
}

Bytes makeTga(int width, int height, const std::function<Rgba8(int, int)>& pixel, bool topDown) {
    Bytes bytes(18);
    const auto set = [&](std::size_t at, int value) { bytes[at] = static_cast<std::byte>(value); };
    set(2, 2);
    set(12, width & 255);
    set(13, width >> 8);
    set(14, height & 255);
    set(15, height >> 8);
    set(16, 32);
    set(17, 8 | (topDown ? 0x20 : 0));
    for (int row = 0; row < height; ++row)
        for (int x = 0; x < width; ++x) {
            const Rgba8 p = pixel(x, topDown ? row : height - 1 - row);
            for (const std::uint8_t channel : {p.b, p.g, p.r, p.a}) bytes.push_back(static_cast<std::byte>(channel));
        }
    return bytes;
}

} // namespace pie::test
