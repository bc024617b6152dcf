#pragma once
// Choosing lights in the picture and moving them by hand. Pure functions.

#include "apps/pieview/light_edits.h"
#include "apps/support/camera.h"

#include <cstdint>

namespace pieview {

using pie::Vec2;

/// The light whose place in the picture is nearest to `pixel`, at most `reach` pixels away; of several in one place the
/// one that is nearest to the eye.
[[nodiscard]] std::optional<std::size_t> pickLight(const LightEdits& lights, const apps::Camera& camera,
                                                   const apps::Lens& lens, const Vec2& pixel, float reach);

/// How a drag moves: in the plane that faces the camera, up and down, or along x or y, whichever the drag follows more.
enum class DragAlong : std::uint8_t { Picture, Vertical, Axis };
/// Where what is at `position` goes when it is dragged from one pixel to another.
[[nodiscard]] Vec3 dragged(const Vec3& position, const apps::Camera& camera, const apps::Lens& lens, const Vec2& from,
                           const Vec2& to, DragAlong along);

} // namespace pieview
