#pragma once
// A level as the rest of pie sees it, whatever format it came from: surfaces in world space with resolved shaders,
// textures, lightmaps, entities, and the spatial tree. Immutable after loading.

#include "pie/core/result.h"
#include "pie/core/vec.h"
#include "pie/level/bsp.h"
#include "pie/level/entities.h"
#include "pie/level/image.h"
#include "pie/level/shader.h"
#include "pie/level/vfs.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace pie::level {

struct Vertex {
    Vec3 position, normal; ///< normal is unit length
    Vec2 texture, lightmap;
    Rgba8 colour{255};
};

enum class SurfaceKind : std::uint8_t { Polygon, Patch, Mesh };

inline constexpr std::int32_t noLightmap = -1;
inline constexpr std::int32_t vertexLit = -3;

struct Surface {
    std::uint32_t shader = 0;           ///< Level::shaders
    std::int32_t lightmap = noLightmap; ///< Level::lightmaps, or noLightmap, or vertexLit
    std::uint32_t model = 0;            ///< Level::models; 0 is the world
    std::int32_t fog = -1;              ///< Level::fogs
    SurfaceKind kind = SurfaceKind::Polygon;
    std::uint32_t firstVertex = 0, vertexCount = 0;
    std::uint32_t firstIndex = 0, indexCount = 0; ///< triangles in Level::indices; those hold absolute vertex numbers,
                                                  ///< counter-clockwise from the front
};

/// A submodel ("*3"): doors, platforms, fans. Its vertices already stand at `origin`.
struct Model {
    Vec3 origin{0.0F};
    std::int32_t entity = -1; ///< Level::entities; -1 for the world and for models that nothing refers to
    Box bounds;               ///< in world space, of its drawn and undrawn surfaces
    bool drawn = true;        ///< false for triggers and other brush entities that the game never shows
};

struct Plane {
    Vec3 normal{0.0F};
    float distance = 0;
}; ///< points with dot(normal, p) == distance

/// Binary space partition of the world model. Empty for formats without one.
struct Tree {
    struct Node {
        std::uint32_t plane = 0;
        std::array<std::int32_t, 2> children{};
        Box bounds;
    }; ///< child < 0: leaf -(child+1); front child first
    struct Leaf {
        std::int32_t cluster = -1, area = -1;
        Box bounds;
    };
    /// What clusters of leaves may see of each other, as the level compiler worked it out: never too little. No
    /// clusters where it did not.
    struct Visibility {
        std::size_t clusters = 0, bytesPerCluster = 0;
        std::vector<std::uint8_t> bits; ///< a row per cluster, bit c: may see cluster c
        /// Both below `clusters`.
        [[nodiscard]] bool sees(std::size_t from, std::size_t to) const {
            return (bits[from * bytesPerCluster + to / 8] >> (to % 8) & 1U) != 0;
        }
    };
    std::vector<Plane> planes;
    std::vector<Node> nodes;
    std::vector<Leaf> leaves;
    Visibility visibility;
    /// The leaf that holds the point; leaves.size() must not be 0.
    [[nodiscard]] std::size_t leafAt(const Vec3& point) const;
};

struct Lightmap {
    int width = 0, height = 0;
    bool external = false;
    std::vector<std::uint8_t> rgb;
    std::string name;
};

struct FogVolume {
    std::string shader;
    FogKeys keys;
    Box bounds;
    std::optional<Plane> visiblePlane;
};

/// An image that some shader names.
struct Texture {
    std::string name;                   ///< as written in the shader
    std::string path;                   ///< in the file system; empty: missing
    std::shared_ptr<const Image> image; ///< null: missing or not loaded
    bool clamp = false;
};

/// Names a stage of the load (file, parse, shaders, surfaces, images) and how long it took.
using StageTime = std::pair<std::string, double>; ///< milliseconds

struct LoadStatistics {
    std::string dialect;
    std::vector<std::pair<std::string, std::size_t>> lumps;        ///< record counts in file order
    std::size_t polygons = 0, patches = 0, meshes = 0, flares = 0; ///< faces of the file
    std::size_t drawnTriangles = 0;
    double drawnArea = 0;
    Box drawnBounds; ///< after meshverts and patches, of drawn surfaces
    std::vector<std::string> missingTextures;
    std::vector<std::string> warnings; ///< defects in the content, one line each
    std::vector<StageTime> times;
};

struct LoadOptions {
    bool images = true;          ///< decode the pictures (false: names and paths only)
    bool deluxe = true;          ///< recognise interleaved deluxe lightmaps
    float patchTolerance = 1.0F; ///< units, see tessellate()
};

struct Level {
    std::string name; ///< "oa_dm1"
    std::string file; ///< where it was found
    std::shared_ptr<const Vfs> files;
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;
    std::vector<Surface> surfaces; ///< drawn and undrawn ones (sky, nodraw): see Shader::drawn and Model::drawn
    std::vector<Shader> shaders;
    /// Every image named by a stage, an editor image, a light image or a sky box, and the one named like the shader.
    /// Decoded are those that a drawn or sky shader shows and each shader's `lightImage`.
    std::vector<Texture> textures;
    std::map<std::string, std::size_t, std::less<>> textureIndex; ///< name as written -> textures
    std::vector<Lightmap> lightmaps;                              ///< without the deluxe ones
    std::vector<Model> models;
    std::vector<FogVolume> fogs;
    std::vector<Entity> entities;
    /// Light entities (class names that start with "light"), the level's own or else of the .map beside it, and behind
    /// them the entities they target. `lightEntitySource` names the file they come from; empty if there are none.
    std::vector<Entity> lightEntities;
    std::string lightEntitySource;
    Tree tree;
    LoadStatistics statistics;

    /// The texture a stage or key names, or null.
    [[nodiscard]] const Texture* texture(std::string_view imageName) const;
    /// The image that stands for the surface's colour: q3map_lightimage, else first usable stage, else sky box up, else
    /// editor image, else the image named like the shader. Null: none of them exists.
    [[nodiscard]] const Texture* lightImage(const Shader& shader) const;
    /// The .map on disk that holds `lightEntities`, for saving changes to them; else an Error that says why there is
    /// none.
    [[nodiscard]] Result<std::filesystem::path> lightEntityFile() const;
    /// First player start with its yaw in degrees; a point inside the level with yaw 0 if there is none.
    struct View {
        Vec3 eye{0.0F};
        float yaw = 0;
    };
    [[nodiscard]] View firstView() const;
};

/// The six pictures of a sky box in the game's order (rt bk lf ft up dn), from the base name in Shader::skyBox.
[[nodiscard]] std::array<std::string, 6> skyBoxImages(std::string_view base);

/// What a reader of any format hands over: records as of a BSP file, the scripts they refer to, and what it has to say.
struct LevelRecords {
    Bsp bsp;
    ShaderLibrary shaders;
    std::string dialect;
    std::vector<std::string> warnings;
    std::vector<StageTime> times; ///< of its own stages
};
/// Finds pictures, tessellates patches, places submodels: what is the same for every format.
[[nodiscard]] Result<Level> makeLevel(LevelRecords records, Location location, const LoadOptions& options = {});

/// Reads a level and everything it refers to. Missing pictures are warnings, damaged structure is an Error.
[[nodiscard]] Result<Level> loadLevel(Location location, const LoadOptions& options = {});
/// The same from bytes (streams, tests): `location.name` is used for messages and for finding what lies beside it.
[[nodiscard]] Result<Level> loadLevel(std::span<const std::byte> bytes, Location location,
                                      const LoadOptions& options = {});

} // namespace pie::level
