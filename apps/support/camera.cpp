#include "apps/support/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace apps {
namespace {

float radians(float degrees) { return degrees * std::numbers::pi_v<float> / 180.0F; }

} // namespace

Vec3 ahead(const Camera& camera) {
    const float yaw = radians(camera.yaw);
    const float pitch = radians(camera.pitch);
    return {std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), -std::sin(pitch)};
}

Vec3 right(const Camera& camera) {
    const float yaw = radians(camera.yaw);
    return {std::sin(yaw), -std::cos(yaw), 0.0F};
}

Vec3 above(const Camera& camera) { return glm::cross(right(camera), ahead(camera)); }

Camera turned(Camera camera, float yaw, float pitch) {
    constexpr float steepest = 89;
    camera.yaw = std::remainder(camera.yaw + yaw, 360.0F);
    camera.pitch = std::clamp(camera.pitch + pitch, -steepest, steepest);
    return camera;
}

Camera flown(Camera camera, const Vec3& push, float distance) {
    const Vec3 way = right(camera) * push.x + ahead(camera) * push.y + Vec3(0, 0, push.z);
    const float length = glm::length(way);
    if (length > 0.0F) camera.eye += way * (distance / std::max(1.0F, length));
    return camera;
}

Camera orbited(const Camera& camera, float distance, float yaw, float pitch) {
    const Vec3 centre = camera.eye + ahead(camera) * distance;
    Camera moved = turned(camera, yaw, pitch);
    moved.eye = centre - ahead(moved) * distance;
    return moved;
}

Vec2 Lens::half() const {
    const float x = std::tan(radians(fieldOfView) / 2.0F);
    return {x, x / aspect()};
}

Vec3 rayThrough(const Camera& camera, const Lens& lens, const Vec2& pixel) {
    const Vec2 half = lens.half();
    const float x = (2.0F * pixel.x / static_cast<float>(lens.width) - 1.0F) * half.x;
    const float y = (1.0F - 2.0F * pixel.y / static_cast<float>(lens.height)) * half.y;
    return glm::normalize(ahead(camera) + right(camera) * x + above(camera) * y);
}

std::optional<Vec2> pixelOf(const Camera& camera, const Lens& lens, const Vec3& point) {
    const Vec3 way = point - camera.eye;
    const float depth = glm::dot(way, ahead(camera));
    if (depth <= 0.0F) return std::nullopt;
    const Vec2 half = lens.half();
    const float x = glm::dot(way, right(camera)) / (depth * half.x);
    const float y = glm::dot(way, above(camera)) / (depth * half.y);
    return Vec2((x + 1.0F) * 0.5F * static_cast<float>(lens.width),
                (1.0F - y) * 0.5F * static_cast<float>(lens.height));
}

std::optional<Camera> parseCamera(const std::string& text) {
    std::istringstream stream(text);
    Camera camera;
    std::string rest;
    if (!(stream >> camera.eye.x >> camera.eye.y >> camera.eye.z)) return std::nullopt;
    if (stream >> camera.yaw) stream >> camera.pitch;
    stream.clear();
    if (stream >> rest) return std::nullopt;
    for (const float value : {camera.eye.x, camera.eye.y, camera.eye.z, camera.yaw, camera.pitch})
        if (!std::isfinite(value)) return std::nullopt;
    return turned(camera, 0, 0);
}

std::string cameraText(const Camera& camera) {
    return fmt::format("{:.1f} {:.1f} {:.1f} {:.1f} {:.1f}", camera.eye.x, camera.eye.y, camera.eye.z, camera.yaw,
                       camera.pitch);
}

} // namespace apps
