#pragma once
// Where the view is and how it moves. Pure functions of numbers: no window, no scene. Lengths are level units, angles
// degrees as the game prints them: yaw counter-clockwise from +x, pitch positive downwards.

#include "pie/core/vec.h"

#include <optional>
#include <string>

namespace apps {

using pie::Vec2;
using pie::Vec3;

struct Camera {
    Vec3 eye{0.0F};
    float yaw = 0, pitch = 0;
    bool operator==(const Camera&) const = default;
};

[[nodiscard]] Vec3 ahead(const Camera& camera);
[[nodiscard]] Vec3 right(const Camera& camera); ///< level: without roll
[[nodiscard]] Vec3 above(const Camera& camera); ///< perpendicular to both

/// Turned by so many degrees; pitch stays within ±89, yaw within ±180.
[[nodiscard]] Camera turned(Camera camera, float yaw, float pitch);
/// Which way keys push: x right, y ahead, z up, each −1 to 1.
[[nodiscard]] Camera flown(Camera camera, const Vec3& push, float distance);
/// Turned about the point `distance` ahead, which stays there.
[[nodiscard]] Camera orbited(const Camera& camera, float distance, float yaw, float pitch);

/// Size of the picture in pixels; `fieldOfView` is horizontal, degrees.
struct Lens {
    float fieldOfView = 90;
    int width = 1, height = 1;
    [[nodiscard]] float aspect() const { return static_cast<float>(width) / static_cast<float>(height); }
    /// Half the picture's width and height at distance 1.
    [[nodiscard]] Vec2 half() const;
};
/// Unit direction through a pixel; (0, 0) is the upper left corner of the picture.
[[nodiscard]] Vec3 rayThrough(const Camera& camera, const Lens& lens, const Vec2& pixel);
/// The pixel a point is seen at; nothing behind the eye.
[[nodiscard]] std::optional<Vec2> pixelOf(const Camera& camera, const Lens& lens, const Vec3& point);

/// "x y z yaw pitch", the last two optional.
[[nodiscard]] std::optional<Camera> parseCamera(const std::string& text);
[[nodiscard]] std::string cameraText(const Camera& camera);

} // namespace apps
