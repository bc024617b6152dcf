#include "apps/pieview/light_picking.h"

#include <cmath>

namespace pieview {
namespace {

/// Along the unit `axis` by as much as the picture of the move follows the picture of the axis.
float share(const Vec2& axisInPicture, const Vec2& move) {
    const float squared = glm::dot(axisInPicture, axisInPicture);
    return squared > 1e-6F ? glm::dot(axisInPicture, move) / squared : 0.0F;
}

} // namespace

std::optional<std::size_t> pickLight(const LightEdits& lights, const apps::Camera& camera, const apps::Lens& lens,
                                     const Vec2& pixel, float reach) {
    constexpr float samePlace = 2; // pixels
    std::optional<std::size_t> best;
    float bestAway = reach;
    float bestDepth = 0;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const auto position = positionOf(lights.light(i));
        if (!position) continue;
        const auto place = apps::pixelOf(camera, lens, *position);
        if (!place) continue;
        const float away = glm::length(*place - pixel);
        const float depth = glm::length(*position - camera.eye);
        const bool nearer =
            best ? away < bestAway - samePlace || (away < bestAway + samePlace && depth < bestDepth) : away <= reach;
        if (!nearer || away > reach) continue;
        best = i;
        bestAway = away;
        bestDepth = depth;
    }
    return best;
}

Vec3 dragged(const Vec3& position, const apps::Camera& camera, const apps::Lens& lens, const Vec2& from, const Vec2& to,
             DragAlong along) {
    const float depth = glm::dot(position - camera.eye, apps::ahead(camera));
    if (depth <= 0.0F) return position;
    // Units that a pixel is at this depth; the same across and up.
    const float unitsPerPixel = 2.0F * depth * lens.half().x / static_cast<float>(lens.width);
    const Vec2 move((to.x - from.x) * unitsPerPixel, (from.y - to.y) * unitsPerPixel);
    const auto inPicture = [&](const Vec3& axis) {
        return Vec2(glm::dot(axis, apps::right(camera)), glm::dot(axis, apps::above(camera)));
    };
    switch (along) {
    case DragAlong::Picture: return position + apps::right(camera) * move.x + apps::above(camera) * move.y;
    case DragAlong::Vertical: return position + Vec3(0, 0, share(inPicture({0, 0, 1}), move));
    case DragAlong::Axis: break;
    }
    const float alongX = share(inPicture({1, 0, 0}), move);
    const float alongY = share(inPicture({0, 1, 0}), move);
    // The axis whose picture the move follows more.
    const auto follows = [&](const Vec2& axis) {
        const float length = glm::length(axis);
        return length > 1e-3F ? std::abs(glm::dot(axis, move)) / length : 0.0F;
    };
    return follows(inPicture({1, 0, 0})) >= follows(inPicture({0, 1, 0})) ? position + Vec3(alongX, 0, 0)
                                                                          : position + Vec3(0, alongY, 0);
}

} // namespace pieview
