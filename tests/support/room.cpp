#include "tests/support/room.h"

#include "tests/support/picture.h"

#include <stdexcept>

namespace pie::test {
namespace {

/// Axis, sign and the two directions along the wall, so that along × up points into the room.
struct Wall {
    Vec3 normal, along, up;
};
constexpr int roomWalls = 6;

Wall wall(int number) {
    const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const int axis = number / 2;
    const float sign = number % 2 == 0 ? 1.0F : -1.0F; // inwards
    const Vec3 normal = sign * axes[axis];
    const Vec3 along = axes[(axis + 1) % 3];
    return {normal, along, glm::cross(normal, along)};
}

void addWall(level::Bsp& bsp, const Room& room, int number) {
    const Wall w = wall(number);
    const float half = room.side / 2;
    const auto first = static_cast<std::int32_t>(bsp.vertices.size());
    for (const Vec2& corner : {Vec2(-1, -1), Vec2(-1, 1), Vec2(1, 1), Vec2(1, -1)}) {
        level::BspVertex vertex;
        vertex.position = half * (corner.x * w.along + corner.y * w.up - w.normal);
        vertex.texture = 0.5F * corner + Vec2(0.5F);
        vertex.lightmap = vertex.texture;
        vertex.normal = w.normal;
        bsp.vertices.push_back(vertex);
    }
    level::BspFace face;
    face.shader = number;
    face.firstVertex = first;
    face.vertexCount = 4;
    face.firstMeshVertex = static_cast<std::int32_t>(bsp.meshVertices.size());
    face.meshVertexCount = 6;
    face.lightmap = 0;
    face.lightmapSize = {level::lightmapSide, level::lightmapSide};
    face.normal = w.normal;
    for (const int corner : {0, 1, 2, 0, 2, 3}) bsp.meshVertices.push_back(corner); // clockwise from the front
    bsp.shaders.push_back({room.shaders.at(static_cast<std::size_t>(number)), 0, 1});
    bsp.leafFaces.push_back(static_cast<std::int32_t>(bsp.faces.size()));
    bsp.faces.push_back(face);
    bsp.planes.push_back({w.normal, -half});
}

} // namespace

level::Bsp makeRoom(const Room& room, std::uint8_t lightmapByte) {
    level::Bsp bsp;
    bsp.entities = "{\n\"classname\" \"worldspawn\"\n}\n" + room.entities;
    for (int number = 0; number < roomWalls; ++number) addWall(bsp, room, number);
    const auto half = static_cast<std::int32_t>(room.side / 2);
    level::BspNode node;
    node.children = {-1, -2};
    node.mins = {-half, -half, -half};
    node.maxs = {half, half, half};
    bsp.nodes.push_back(node);
    level::BspLeaf inside;
    inside.mins = node.mins;
    inside.maxs = node.maxs;
    inside.leafFaceCount = roomWalls;
    level::BspLeaf solid;
    solid.cluster = -1;
    bsp.leaves = {inside, solid};
    level::BspModel world;
    world.mins = Vec3(-room.side / 2);
    world.maxs = Vec3(room.side / 2);
    world.faceCount = roomWalls;
    bsp.models.push_back(world);
    bsp.lightmaps.emplace_back().fill(lightmapByte);
    return bsp;
}

void writeGame(const TemporaryFolder& folder, const std::string& name, const level::Bsp& bsp,
               const std::vector<std::pair<std::string, Rgba8>>& textures) {
    const std::vector<std::byte> bytes = level::writeBsp(bsp);
    std::string content(bytes.size(), '\0');
    for (std::size_t i = 0; i < bytes.size(); ++i) content[i] = static_cast<char>(bytes[i]);
    static_cast<void>(folder.write("maps/" + name + ".bsp", content));
    constexpr int side = 16;
    for (const auto& [texture, colour] : textures) {
        Picture picture{side, side, {}};
        for (int i = 0; i < side * side; ++i) picture.rgb.insert(picture.rgb.end(), {colour.x, colour.y, colour.z});
        const std::string file = folder.write(texture + ".png", "");
        if (!writePicture(file, picture)) throw std::runtime_error("cannot write " + file);
    }
}

} // namespace pie::test
