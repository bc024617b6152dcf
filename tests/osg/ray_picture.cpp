#include "tests/osg/ray_picture.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pie::test {
namespace {

using level::Level;
using level::Surface;

constexpr int raysPerSide = 3; ///< of a pixel

struct Triangle {
    Vec3 origin, u, v;
    std::uint32_t surface = 0;
    std::array<std::uint32_t, 3> corners{};
    bool oneSided = true;
};

std::vector<Triangle> drawnTriangles(const Level& level) {
    std::vector<Triangle> triangles;
    for (std::uint32_t s = 0; s < level.surfaces.size(); ++s) {
        const Surface& surface = level.surfaces[s];
        const level::Shader& shader = level.shaders[surface.shader];
        if (!level.models[surface.model].drawn || !(shader.drawn() || shader.parms.sky)) continue;
        for (std::uint32_t i = 0; i < surface.indexCount; i += 3) {
            Triangle t;
            for (std::uint32_t c = 0; c < 3; ++c) t.corners.at(c) = level.indices[surface.firstIndex + i + c];
            t.origin = level.vertices[t.corners[0]].position;
            t.u = level.vertices[t.corners[1]].position - t.origin;
            t.v = level.vertices[t.corners[2]].position - t.origin;
            t.surface = s;
            t.oneSided = !shader.twoSided();
            triangles.push_back(t);
        }
    }
    return triangles;
}

struct Hit {
    const Triangle* triangle = nullptr;
    float distance = std::numeric_limits<float>::max(), a = 0, b = 0;
};

/// Möller and Trumbore 1997.
Hit firstHit(const std::vector<Triangle>& triangles, const Vec3& eye, const Vec3& direction) {
    Hit best;
    for (const Triangle& t : triangles) {
        const Vec3 p = glm::cross(direction, t.v);
        const float determinant = glm::dot(t.u, p);
        if (t.oneSided ? determinant <= 1e-9F : std::abs(determinant) <= 1e-9F) continue;
        const Vec3 s = eye - t.origin;
        const float a = glm::dot(s, p) / determinant;
        if (a < 0 || a > 1) continue;
        const Vec3 q = glm::cross(s, t.u);
        const float b = glm::dot(direction, q) / determinant;
        const float distance = glm::dot(t.v, q) / determinant;
        if (b < 0 || a + b > 1 || distance <= 0 || distance >= best.distance) continue;
        best = {&t, distance, a, b};
    }
    return best;
}

int wrapped(int i, int size) { return ((i % size) + size) % size; }

/// Bilinear between texel centres; `texel(x, y)` is asked with any integers.
template <class Texel> Rgb bilinear(const Vec2& at, int width, int height, Texel texel) {
    const float x = at.x * static_cast<float>(width) - 0.5F;
    const float y = at.y * static_cast<float>(height) - 0.5F;
    const int left = static_cast<int>(std::floor(x));
    const int top = static_cast<int>(std::floor(y));
    const float fx = x - static_cast<float>(left);
    const float fy = y - static_cast<float>(top);
    return glm::mix(glm::mix(texel(left, top), texel(left + 1, top), fx),
                    glm::mix(texel(left, top + 1), texel(left + 1, top + 1), fx), fy);
}

Rgb pictureAt(const level::Image& image, const Vec2& at) {
    return bilinear(at, image.width, image.height, [&](int x, int y) {
        const int column = wrapped(x, image.width);
        const int row = wrapped(y, image.height);
        const Rgba8 p = image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                                     static_cast<std::size_t>(column)];
        return Rgb(p.r, p.g, p.b) / 255.0F;
    });
}

/// 4 · byte / 255, cut at 1 with the hue kept.
Rgb lightAt(const level::Lightmap& lightmap, const Vec2& at) {
    return bilinear(at, lightmap.width, lightmap.height, [&](int x, int y) {
        const auto column = static_cast<std::size_t>(std::clamp(x, 0, lightmap.width - 1));
        const auto row = static_cast<std::size_t>(std::clamp(y, 0, lightmap.height - 1));
        const std::size_t i = 3 * (row * static_cast<std::size_t>(lightmap.width) + column);
        const Rgb light = Rgb(lightmap.rgb[i], lightmap.rgb[i + 1], lightmap.rgb[i + 2]) * (4.0F / 255.0F);
        return light / std::max(1.0F, std::max({light.x, light.y, light.z}));
    });
}

/// Whether the hit is on a picture × lightmap surface, and its colour.
bool shade(const Level& level, const Hit& hit, Rgb& colour) {
    if (!hit.triangle) return false;
    const Surface& surface = level.surfaces[hit.triangle->surface];
    const level::Shader& shader = level.shaders[surface.shader];
    if (shader.origin != "image" || surface.lightmap < 0 || surface.fog >= 0) return false;
    const level::Texture* texture =
        level.texture(shader.stages.back().images.empty() ? shader.name : shader.stages.back().images.front());
    if (!texture || !texture->image) return false;
    const auto& v0 = level.vertices[hit.triangle->corners[0]];
    const auto& v1 = level.vertices[hit.triangle->corners[1]];
    const auto& v2 = level.vertices[hit.triangle->corners[2]];
    const float c = 1 - hit.a - hit.b;
    colour = pictureAt(*texture->image, c * v0.texture + hit.a * v1.texture + hit.b * v2.texture) *
             lightAt(level.lightmaps[static_cast<std::size_t>(surface.lightmap)],
                     c * v0.lightmap + hit.a * v1.lightmap + hit.b * v2.lightmap);
    return true;
}

} // namespace

RayPicture castPicture(const Level& level, const Shot& shot) {
    const std::vector<Triangle> triangles = drawnTriangles(level);
    const osg::Matrixd toWorld = osg::Matrixd::inverse(shot.view * shot.projection);
    const osg::Vec3d eyePlace = osg::Vec3d() * osg::Matrixd::inverse(shot.view);
    const Vec3 eye(eyePlace.x(), eyePlace.y(), eyePlace.z());
    const auto width = static_cast<std::size_t>(shot.width);
    const auto height = static_cast<std::size_t>(shot.height);
    RayPicture result{{shot.width, shot.height, std::vector<std::uint8_t>(3 * width * height)},
                      std::vector<std::uint8_t>(width * height, 1)};
    const auto castPixel = [&](std::size_t x, std::size_t y) {
        Rgb sum(0.0F);
        bool known = true;
        for (int ray = 0; ray < raysPerSide * raysPerSide && known; ++ray) {
            const int row = ray / raysPerSide;
            const double dx = (ray % raysPerSide + 0.5) / raysPerSide;
            const double dy = (row + 0.5) / raysPerSide;
            const osg::Vec3d far = osg::Vec3d(2 * (static_cast<double>(x) + dx) / shot.width - 1,
                                              1 - 2 * (static_cast<double>(y) + dy) / shot.height, 1) *
                                   toWorld;
            const Vec3 direction = glm::normalize(Vec3(far.x(), far.y(), far.z()) - eye);
            Rgb colour(0.0F);
            known = shade(level, firstHit(triangles, eye, direction), colour);
            sum += colour;
        }
        const std::size_t pixel = y * width + x;
        result.known[pixel] = known ? 1 : 0;
        for (int c = 0; c < 3; ++c)
            result.picture.rgb[3 * pixel + static_cast<std::size_t>(c)] =
                static_cast<std::uint8_t>(std::lround(255.0F * sum[c] / static_cast<float>(raysPerSide * raysPerSide)));
    };
    parallelChunks(height, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y)
            for (std::size_t x = 0; x < width; ++x) castPixel(x, y);
    });
    return result;
}

} // namespace pie::test
