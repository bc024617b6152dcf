#include "pie/scene/scene.h"

#include "pie/core/parallel.h"
#include "pie/scene/geometry.h"
#include "pie/scene/position_index.h"
#include "pie/scene/reflectance.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace pie::scene {
namespace {

using level::Level;
using level::Shader;

/// A picture laid over a wall: every stage blends and polygonOffset keeps it in front. What lies behind stops the
/// light.
bool decal(const Shader& shader) {
    return shader.polygonOffset && !shader.stages.empty() &&
           std::all_of(shader.stages.begin(), shader.stages.end(), [](const level::Stage& stage) {
               return !stage.blend.opaque() && stage.alphaTest == level::AlphaTest::None;
           });
}

/// Nothing: light does not notice the surface (the level compiler's rules).
std::optional<Interaction> interaction(const Shader& shader) {
    const level::SurfaceParms& parms = shader.parms;
    if (parms.sky || !shader.skyBox.empty()) return Interaction::Sky;
    if (parms.noDraw || parms.fog || !shader.drawn()) return std::nullopt;
    if (parms.alphaShadow || parms.lightFilter) return Interaction::Filter;
    if (parms.translucent || decal(shader)) return std::nullopt;
    return Interaction::Opaque;
}

/// The materials of a level, made for the shaders that some surface uses.
class MaterialTable {
public:
    MaterialTable(const Level& level, const SceneOptions& options) : material_(level.shaders.size(), unused) {
        std::vector<bool> used(level.shaders.size(), false);
        for (const level::Surface& surface : level.surfaces)
            if (surface.indexCount >= 3 && surface.shader < used.size()) used[surface.shader] = true;
        for (std::size_t i = 0; i < used.size(); ++i) {
            if (!used[i]) continue;
            const std::optional<Interaction> kind = interaction(level.shaders[i]);
            if (!kind) continue;
            material_[i] = static_cast<std::uint32_t>(materials.size());
            materials.emplace_back().interaction = *kind;
            materials.back().shader = static_cast<std::uint32_t>(i);
        }
        parallelChunks(materials.size(), 1,
                       [&](std::size_t begin, std::size_t) { describe(materials[begin], level, options); });
    }

    std::vector<Material> materials;

    [[nodiscard]] std::optional<std::uint32_t> of(std::uint32_t shader) const {
        if (shader >= material_.size() || material_[shader] == unused) return std::nullopt;
        return material_[shader];
    }

private:
    static constexpr std::uint32_t unused = 0xffffffffU;

    static void describe(Material& material, const Level& level, const SceneOptions& options) {
        const Shader& shader = level.shaders[material.shader];
        const level::Texture* texture = level.lightImage(shader);
        const std::shared_ptr<const level::Image> image = texture != nullptr ? texture->image : nullptr;
        material.twoSided = shader.twoSided();
        if (material.interaction == Interaction::Filter) {
            material.alphaOnly = !shader.parms.lightFilter;
            const bool usable = image && image->width > 0 && image->height > 0;
            if (usable) material.filter = image;
            // Without a picture nothing says what passes: the compiler then stops the light.
            else
                material.interaction = Interaction::Opaque;
        }
        material.reflectance = material.interaction == Interaction::Sky
                                   ? Rgb(0.0F)
                                   : reflectanceOf(shader, texture, material.interaction, options);
    }

    std::vector<std::uint32_t> material_;
};

/// Appends triangles; keeps positions welded and the sums up to date.
class Builder {
public:
    Builder(Scene& scene, std::size_t expectedTriangles) : scene_(scene), index_(expectedTriangles) {
        scene.triangles.reserve(expectedTriangles);
        scene.normals.reserve(expectedTriangles);
        scene.positions.reserve(expectedTriangles);
    }

    void add(const std::array<Vec3, 3>& corners, std::uint32_t material, std::uint32_t surface) {
        Triangle& triangle = scene_.triangles.emplace_back();
        triangle.material = material;
        triangle.surface = surface;
        for (std::size_t i = 0; i < 3; ++i) {
            triangle.vertices[i] = index_.add(scene_.positions, corners[i]);
            if (finite(corners[i])) scene_.bounds.extend(corners[i]);
        }
        const bool flat = withoutArea(corners[0], corners[1], corners[2]);
        const glm::dvec3 across = flat ? glm::dvec3(0.0) : areaVector(corners[0], corners[1], corners[2]);
        scene_.normals.push_back(flat ? Vec3(0.0F) : Vec3(glm::normalize(across)));
        if (scene_.materials[material].interaction != Interaction::Sky) scene_.area += 0.5 * glm::length(across);
    }

private:
    Scene& scene_;
    PositionIndex index_;
};

/// The game repeats pictures; coordinates are far from zero on large floors and may be anything in a damaged file.
int wrapped(float coordinate, int size) {
    const float share = coordinate - std::floor(coordinate);
    if (!(share >= 0.0F && share < 1.0F)) return 0;
    return std::min(static_cast<int>(share * static_cast<float>(size)), size - 1);
}

bool filters(const std::vector<Material>& materials) {
    return std::any_of(materials.begin(), materials.end(),
                       [](const Material& material) { return material.interaction == Interaction::Filter; });
}

} // namespace

Rgb Scene::transmittance(std::size_t triangle, float u, float v) const {
    const Material& surface = material(triangle);
    if (surface.interaction == Interaction::Opaque) return Rgb(0.0F);
    if (surface.interaction == Interaction::Sky) return Rgb(1.0F);
    if (!surface.filter || surface.filter->pixels.empty() || textureCoordinates.empty()) return Rgb(0.0F);
    const Vec2* corner = &textureCoordinates[3 * triangle];
    const Vec2 at = (1.0F - u - v) * corner[0] + u * corner[1] + v * corner[2];
    // One texel, not a blend of four: that is what the level compiler does, and shadows are to fall where its fell.
    const level::Image& image = *surface.filter;
    const int x = wrapped(at.x, image.width);
    const int y = wrapped(at.y, image.height);
    const Rgba8 texel =
        image.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)];
    if (surface.alphaOnly) return Rgb(1.0F - static_cast<float>(texel.w) / 255.0F);
    return Rgb(texel.x, texel.y, texel.z) / 255.0F;
}

bool Scene::has(Interaction kind) const {
    const auto isKind = [&](const Material& material) { return material.interaction == kind; };
    if (std::none_of(materials.begin(), materials.end(), isKind)) return false;
    return std::any_of(triangles.begin(), triangles.end(),
                       [&](const Triangle& triangle) { return isKind(materials[triangle.material]); });
}

Scene makeScene(const Level& level, const SceneOptions& options, std::size_t* dropped) {
    Scene scene;
    MaterialTable table(level, options);
    scene.materials = std::move(table.materials);
    const bool textured = filters(scene.materials);
    std::size_t withoutAreaCount = 0;
    Builder builder(scene, level.indices.size() / 3);
    for (std::size_t s = 0; s < level.surfaces.size(); ++s) {
        const level::Surface& surface = level.surfaces[s];
        if (surface.model < level.models.size() && !level.models[surface.model].drawn) continue;
        const std::optional<std::uint32_t> material = table.of(surface.shader);
        if (!material) continue;
        for (std::size_t i = surface.firstIndex; i + 2 < std::size_t{surface.firstIndex} + surface.indexCount; i += 3) {
            const std::array<const level::Vertex*, 3> corners{&level.vertices[level.indices[i]],
                                                              &level.vertices[level.indices[i + 1]],
                                                              &level.vertices[level.indices[i + 2]]};
            if (withoutArea(corners[0]->position, corners[1]->position, corners[2]->position)) {
                ++withoutAreaCount;
                continue;
            }
            builder.add({corners[0]->position, corners[1]->position, corners[2]->position}, *material,
                        static_cast<std::uint32_t>(s));
            if (textured)
                for (const level::Vertex* corner : corners) scene.textureCoordinates.push_back(corner->texture);
        }
    }
    if (dropped != nullptr) *dropped = withoutAreaCount;
    return scene;
}

Scene makeScene(std::span<const Vec3> corners, std::span<const std::uint32_t> materialOfTriangle,
                std::vector<Material> materials) {
    Scene scene;
    scene.materials = std::move(materials);
    if (scene.materials.empty()) scene.materials.emplace_back();
    const bool textured = filters(scene.materials);
    const std::size_t count = corners.size() / 3;
    Builder builder(scene, count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t wanted = i < materialOfTriangle.size() ? materialOfTriangle[i] : 0U;
        builder.add({corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]},
                    wanted < scene.materials.size() ? wanted : 0U, 0);
        if (textured) scene.textureCoordinates.insert(scene.textureCoordinates.end(), {{0, 0}, {1, 0}, {0, 1}});
    }
    return scene;
}

} // namespace pie::scene
