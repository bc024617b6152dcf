// Models of files: what each format says, what damage answers, and how a misc_model places them.

#include "pie/brushes/compile.h"
#include "pie/brushes/model.h"
#include "tests/brushes/make_map.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <random>

namespace {

using namespace pie;
using namespace pie::brushes;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::span<const std::byte> bytesOf(const std::string& text) {
    return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

template <class T> void put(std::string& file, T value) {
    std::array<char, sizeof value> bytes{};
    std::memcpy(bytes.data(), &value, sizeof value);
    file.append(bytes.data(), bytes.size());
}
void putName(std::string& file, std::string name) {
    name.resize(64, '\0');
    file += name;
}

/// A square of two triangles in the xy plane that faces up, from (0 0) to (32 16); its second frame is 8 units higher.
std::string md3() {
    std::string surface = "IDP3";
    putName(surface, "plate");
    constexpr std::int32_t header = 4 + 64 + 10 * 4;
    constexpr std::int32_t shaders = header;
    constexpr std::int32_t triangles = shaders + 68;
    constexpr std::int32_t texture = triangles + 2 * 12;
    constexpr std::int32_t vertices = texture + 4 * 8;
    constexpr std::int32_t end = vertices + 2 * 4 * 8;
    for (const std::int32_t field : {0, 2, 1, 4, 2, triangles, shaders, texture, vertices, end}) put(surface, field);
    putName(surface, "models\\t\\Plate.tga");
    put(surface, std::int32_t{0});
    for (const std::int32_t corner : {0, 2, 1, 0, 3, 2}) put(surface, corner); // clockwise from above
    const std::array<std::array<float, 2>, 4> corners{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    for (const auto& corner : corners)
        for (const float t : corner) put(surface, t);
    for (const int frame : {0, 1})
        for (const auto& corner : corners) {
            put(surface, static_cast<std::int16_t>(corner[0] * 32 * 64));
            put(surface, static_cast<std::int16_t>(corner[1] * 16 * 64));
            put(surface, static_cast<std::int16_t>(frame * 8 * 64));
            put(surface, std::uint16_t{0}); // up
        }
    std::string file = "IDP3";
    put(file, std::int32_t{15});
    putName(file, "t");
    constexpr std::int32_t start = 4 + 4 + 64 + 9 * 4;
    for (const std::int32_t field : {0, 2, 0, 1, 0, start, start, start, start + end}) put(file, field);
    return file + surface;
}

/// The same square, as the level compiler and as the modeller's own exporter write it.
std::string ase(bool normalsFirst) {
    const std::string normals =
        normalsFirst
            ? "*MESH_NORMALS {\n*MESH_FACENORMAL 0 0 0 1\n*MESH_FACENORMAL 1 0 0 1\n*MESH_VERTEXNORMAL 0 0 0 1\n"
              "*MESH_VERTEXNORMAL 1 0 0 1\n*MESH_VERTEXNORMAL 2 0 0 1\n*MESH_VERTEXNORMAL 3 0 0.6 0.8\n}\n"
            : "*MESH_NORMALS {\n*MESH_FACENORMAL 0 0 0 1\n*MESH_VERTEXNORMAL 0 0 0 1\n*MESH_VERTEXNORMAL 1 0 0 1\n"
              "*MESH_VERTEXNORMAL 2 0 0 1\n*MESH_FACENORMAL 1 0 0 1\n*MESH_VERTEXNORMAL 0 0 0 1\n*MESH_VERTEXNORMAL 2 "
              "0 0 1\n*MESH_VERTEXNORMAL 3 0 0.6 0.8\n}\n";
    const std::string lists =
        "*MESH_VERTEX_LIST {\n*MESH_VERTEX 0 0 0 0\n*MESH_VERTEX 1 32 0 0\n*MESH_VERTEX 2 32 16 0\n*MESH_VERTEX 3 0 16 "
        "0\n}\n"
        "*MESH_FACE_LIST {\n*MESH_FACE 0: A: 0 B: 1 C: 2 AB: 1 BC: 1 CA: 0 *MESH_SMOOTHING 0 *MESH_MTLID 1\n"
        "*MESH_FACE 1: A:0 B:2 C:3 AB:1 BC:1 CA:0 *MESH_SMOOTHING 0 *MESH_MTLID 1\n}\n"
        "*MESH_TVERTLIST {\n*MESH_TVERT 0 0 1 0\n*MESH_TVERT 1 1 1 0\n*MESH_TVERT 2 1 0 0\n*MESH_TVERT 3 0 0 0\n}\n"
        "*MESH_TFACELIST {\n*MESH_TFACE 0 0 1 2\n*MESH_TFACE 1 0 2 3\n}\n";
    return "*3DSMAX_ASCIIEXPORT 200\n*MATERIAL_LIST {\n*MATERIAL_COUNT 1\n*MATERIAL 0 {\n*MATERIAL_NAME \"outer\"\n"
           "*NUMSUBMTLS 2\n*SUBMATERIAL 0 {\n*MATERIAL_NAME \"no\"\n}\n*SUBMATERIAL 1 {\n*MATERIAL_NAME \"no\"\n"
           "*MAP_DIFFUSE {\n*BITMAP \"..\\Models\\t\\plate.tga\"\n}\n}\n}\n}\n*GEOMOBJECT {\n*MESH {\n" +
           (normalsFirst ? normals + lists : lists + normals) + "}\n*MATERIAL_REF 0\n}\n";
}

std::string obj() {
    return "# a square\nv 0 0 0\nv 32 0 0\nv 32 16 0\nv 0 16 0\nvt 0 1\nvt 1 1\nvt 1 0\nvt 0 0\nvn 0 0 1\n"
           "usemtl models/t/plate\nf 1/1/1 2/2/1 -2/-2/1 4/4/1\n";
}

/// Area of what faces up, less what faces down; 512 for the square.
double upwards(const Model& model) {
    double sum = 0;
    for (const ModelSurface& surface : model)
        for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
            const auto at = [&](std::size_t k) { return surface.vertices[surface.indices[i + k]].position; };
            sum += 0.5 * glm::cross(at(1) - at(0), at(2) - at(0)).z;
        }
    return sum;
}

TEST(Models, EveryFormatGivesTheSameSquare) {
    const std::vector<std::pair<std::string, std::string>> files{
        {"t.md3", md3()}, {"a.ase", ase(true)}, {"b.ase", ase(false)}, {"t.obj", obj()}};
    for (const auto& [name, text] : files) {
        SCOPED_TRACE(name);
        const Result<Model> model = readModel(bytesOf(text), name);
        ASSERT_TRUE(model) << model.error().message();
        ASSERT_THAT(*model, SizeIs(1));
        EXPECT_EQ(model->front().shader, "models/t/plate");
        EXPECT_DOUBLE_EQ(upwards(*model), 512);
        for (const ModelVertex& vertex : model->front().vertices) {
            EXPECT_NEAR(vertex.texture.x, vertex.position.x / 32, 1e-9);
            EXPECT_NEAR(vertex.texture.y, vertex.position.y / 16, 1e-9);
            const bool bent = name.ends_with(".ase") && vertex.position == glm::dvec3(0, 16, 0);
            EXPECT_NEAR(vertex.normal.z, bent ? 0.8 : 1, 1e-9);
        }
    }
}

TEST(Models, FramesAreChosenAndEndWithTheLast) {
    for (const auto& [frame, height] : {std::pair{0, 0.0}, std::pair{1, 8.0}, std::pair{7, 8.0}}) {
        const Result<Model> model = readModel(bytesOf(md3()), "t.md3", frame);
        ASSERT_TRUE(model);
        EXPECT_EQ(model->front().vertices[0].position.z, height);
    }
}

/// Whatever is cut off or changed: an answer in one line, and nothing that points beyond its list.
TEST(Models, DamagedFilesAreReadOrRefused) {
    std::mt19937 random(9);
    std::size_t refused = 0;
    for (const auto& [name, whole] :
         std::vector<std::pair<std::string, std::string>>{{"t.md3", md3()}, {"t.ase", ase(true)}, {"t.obj", obj()}}) {
        for (int i = 0; i < 3000; ++i) {
            std::string text = whole;
            if (i % 3 == 0) text.resize(random() % text.size());
            for (int k = 0; k < i % 4 && !text.empty(); ++k)
                text[random() % text.size()] = static_cast<char>(random() % 256);
            const Result<Model> model = readModel(bytesOf(text), name);
            if (!model) {
                ++refused;
                EXPECT_EQ(model.error().message().find('\n'), std::string::npos);
                continue;
            }
            for (const ModelSurface& surface : *model)
                for (const std::uint32_t index : surface.indices) ASSERT_LT(index, surface.vertices.size());
        }
    }
    EXPECT_GT(refused, 1000U);
}

using Files = std::vector<std::pair<std::string, std::string>>;
const Files files{{"models/t/plate.md3", md3()}, {"models/t/broken.md3", md3().substr(0, 300)}};

level::Level roomWith(const std::string& entities) {
    Result<level::Level> level = test::loadMapText(
        test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}), {0, 0, 64}) + entities, files);
    EXPECT_TRUE(level) << (level ? "" : level.error().message());
    return level ? std::move(*level) : level::Level{};
}
std::vector<const level::Surface*> meshesOf(const level::Level& level) {
    std::vector<const level::Surface*> meshes;
    for (const level::Surface& surface : level.surfaces)
        if (surface.kind == level::SurfaceKind::Mesh) meshes.push_back(&surface);
    return meshes;
}
constexpr double walls = 2.0 * (256 * 192 + 256 * 128 + 192 * 128);

TEST(PlacedModels, StandTurnedAndScaledWhereTheEntitySays) {
    const level::Level level = roomWith(test::entityText({{"classname", "misc_model"},
                                                          {"model", "models/t/plate.md3"},
                                                          {"origin", "8 0 40"},
                                                          {"angle", "90"},
                                                          {"modelscale_vec", "2 1 1"}}));
    EXPECT_THAT(level.statistics.warnings, IsEmpty());
    const auto meshes = meshesOf(level);
    ASSERT_THAT(meshes, SizeIs(1));
    EXPECT_DOUBLE_EQ(level.statistics.drawnArea, walls + 2 * 512);
    EXPECT_EQ(level.shaders[meshes[0]->shader].name, "models/t/plate");
    // x runs along y after a quarter turn, y along −x.
    Box box;
    for (std::size_t v = 0; v < meshes[0]->vertexCount; ++v) {
        const level::Vertex& vertex = level.vertices[meshes[0]->firstVertex + v];
        box.extend(vertex.position);
        EXPECT_EQ(vertex.normal, Vec3(0, 0, 1));
    }
    EXPECT_EQ(box.lower, Vec3(-8, 0, 40));
    EXPECT_EQ(box.upper, Vec3(8, 64, 40));
}

TEST(PlacedModels, PitchLooksDownAndMirrorsKeepTheirFront) {
    const level::Level pitched = roomWith(test::entityText(
        {{"classname", "misc_model"}, {"model", "models/t/plate.md3"}, {"origin", "0 0 64"}, {"angles", "90 0 0"}}));
    const auto meshes = meshesOf(pitched);
    ASSERT_THAT(meshes, SizeIs(1));
    for (std::size_t v = 0; v < meshes[0]->vertexCount; ++v)
        EXPECT_LE(pitched.vertices[meshes[0]->firstVertex + v].position.z, 64);
    const level::Level mirrored = roomWith(test::entityText({{"classname", "misc_model"},
                                                             {"model", "models/t/plate.md3"},
                                                             {"origin", "0 0 64"},
                                                             {"modelscale_vec", "-1 1 1"}}));
    const level::Surface& surface = *meshesOf(mirrored).at(0);
    for (std::size_t i = surface.firstIndex; i < surface.firstIndex + surface.indexCount; i += 3) {
        const auto at = [&](std::size_t k) { return mirrored.vertices[mirrored.indices[i + k]].position; };
        EXPECT_GT(glm::cross(at(1) - at(0), at(2) - at(0)).z, 0);
    }
}

TEST(PlacedModels, MissingAndDamagedOnesAreNamedOnceAndTheRestLoads) {
    std::string entities;
    for (const char* model : {"models/t/none.md3", "models/t/none.md3", "models/t/broken.md3", "models/t/plate.md3"})
        entities += test::entityText({{"classname", "misc_model"}, {"model", model}, {"origin", "0 0 64"}});
    const level::Level level = roomWith(entities);
    ASSERT_THAT(level.statistics.warnings, SizeIs(2));
    EXPECT_THAT(level.statistics.warnings[0], HasSubstr("the model 'models/t/none.md3' is not there"));
    EXPECT_THAT(level.statistics.warnings[1], HasSubstr("broken.md3"));
    EXPECT_THAT(meshesOf(level), SizeIs(1));
}

TEST(PlacedModels, RemapsNameOtherShaders) {
    const level::Level level = roomWith(test::entityText({{"classname", "misc_model"},
                                                          {"model", "models/t/plate.md3"},
                                                          {"origin", "0 0 64"},
                                                          {"_remap1", "other;textures/t/no"},
                                                          {"_remap2", "plate;textures/t/steel"}}));
    EXPECT_EQ(level.shaders[meshesOf(level).at(0)->shader].name, "textures/t/steel");
}

/// A model moves with the brush entity that it targets, and an entity's own "origin" is where its brushes turn.
TEST(PlacedModels, BelongToTheBrushEntityTheyTarget) {
    const level::Level level = roomWith(
        test::entityText({{"classname", "func_rotating"}, {"targetname", "fan"}, {"origin", "0 0 64"}},
                         test::boxText({-8, -8, 56}, {8, 8, 72})) +
        test::entityText(
            {{"classname", "misc_model"}, {"model", "models/t/plate.md3"}, {"origin", "0 0 90"}, {"target", "fan"}}));
    const level::Surface& surface = *meshesOf(level).at(0);
    EXPECT_EQ(surface.model, 1U);
    EXPECT_EQ(level.models[1].origin, Vec3(0, 0, 64));
    EXPECT_EQ(level.vertices[surface.firstVertex].position.z, 90) << "where the text places it";
    EXPECT_EQ(level.statistics.drawnBounds.upper.z, 128) << "the box stands where the text has it";
}

/// More corners than the game draws at once become several faces; all triangles are there, also after a compile.
TEST(PlacedModels, LargeOnesAreWrittenInPieces) {
    std::string grid = "usemtl models/t/grid\n";
    constexpr int side = 60;
    for (int y = 0; y <= side; ++y)
        for (int x = 0; x <= side; ++x) grid += fmt::format("v {} {} {}\n", x, y, (x * y) % 3);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const int a = y * (side + 1) + x + 1;
            grid += fmt::format("f {} {} {} {}\n", a, a + 1, a + side + 2, a + side + 1);
        }
    const level::Location location = test::mapInMemory(
        test::levelText(test::roomText({-128, -96, 0}, {128, 96, 128}), {0, 0, 64}) +
            test::entityText({{"classname", "misc_model"}, {"model", "grid.obj"}, {"origin", "0 0 40"}}),
        {{"grid.obj", grid}});
    const Result<level::Bytes> text = location.files.read(location.name);
    ASSERT_TRUE(text);
    const Result<MapText> map = parseMap({reinterpret_cast<const char*>(text->data()), text->size()}, "x.map");
    ASSERT_TRUE(map);
    const Result<CompiledMap> compiled = compileMap(*map, "x.map", location.files, level::ShaderLibrary{});
    ASSERT_TRUE(compiled);
    EXPECT_EQ(compiled->models, 1U);
    std::int32_t indices = 0;
    for (const level::BspFace& face : compiled->bsp.faces) {
        if (face.type != level::BspFaceType::Mesh) continue;
        EXPECT_LT(face.vertexCount, 1000);
        EXPECT_LT(face.meshVertexCount, 6000);
        indices += face.meshVertexCount;
    }
    EXPECT_EQ(indices, side * side * 2 * 3);
    const Result<level::Bsp> read = level::readBsp(level::writeBsp(compiled->bsp), "x.bsp");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->meshVertices, compiled->bsp.meshVertices);
}

} // namespace
