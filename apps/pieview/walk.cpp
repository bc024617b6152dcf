#include "apps/pieview/walk.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pieview {
namespace {

constexpr float skin = 0.25F; ///< that is kept between the player and what is solid

/// How far the player may go from `feet` in the unit direction `way`, and what stops it: rays from the front edge at
/// several heights, the lowest above what is a step.
std::optional<Obstacle> ahead(const Trace& trace, const Vec3& feet, const Vec3& way, float distance) {
    const Vec3 side(-way.y, way.x, 0.0F);
    constexpr std::array heights{Walker::stepHeight + 1.0F, 36.0F, Walker::eyeHeight + Walker::headroom - 1.0F};
    constexpr std::array offsets{-Walker::halfWidth + skin, 0.0F, Walker::halfWidth - skin};
    const float reach = distance + Walker::halfWidth + skin;
    std::optional<Obstacle> nearest;
    for (const float height : heights)
        for (const float offset : offsets) {
            const auto hit = trace(feet + Vec3(0, 0, height) + side * offset, way, reach);
            if (hit && (!nearest || hit->distance < nearest->distance)) nearest = hit;
        }
    if (nearest) nearest->distance = std::max(0.0F, nearest->distance - Walker::halfWidth - skin);
    return nearest;
}

/// Slides along what is in the way, along two walls at most.
Vec3 slide(const Trace& trace, Vec3 feet, Vec3 move) {
    constexpr int mostWalls = 3;
    for (int i = 0; i < mostWalls; ++i) {
        const float distance = glm::length(move);
        if (distance < 1e-4F) break;
        const Vec3 way = move / distance;
        const auto hit = ahead(trace, feet, way, distance);
        if (!hit || hit->distance >= distance) return feet + move;
        feet += way * hit->distance;
        Vec3 normal(hit->normal.x, hit->normal.y, 0.0F);
        const float flat = glm::length(normal);
        if (flat < 1e-3F) break;
        normal /= flat;
        if (glm::dot(normal, way) > 0.0F) normal = -normal;
        const Vec3 rest = way * (distance - hit->distance);
        move = rest - normal * glm::dot(rest, normal);
    }
    return feet;
}

/// How far below `feet` + a step the ground is, under the middle and the corners.
std::optional<float> drop(const Trace& trace, const Vec3& feet, float reach) {
    constexpr float r = Walker::halfWidth * 0.7F;
    constexpr std::array<std::array<float, 2>, 5> places{{{0, 0}, {r, r}, {r, -r}, {-r, r}, {-r, -r}}};
    std::optional<float> nearest;
    for (const auto& [x, y] : places) {
        const auto hit = trace(feet + Vec3(x, y, Walker::stepHeight), Vec3(0, 0, -1), Walker::stepHeight + reach);
        if (hit && (!nearest || hit->distance < *nearest)) nearest = hit->distance;
    }
    return nearest;
}

} // namespace

Camera walked(const Camera& camera, Walker& walker, const Trace& trace, const Vec3& push, float speed, float seconds) {
    Camera moved = camera;
    Vec3 feet = camera.eye - Vec3(0, 0, Walker::eyeHeight);
    Camera level = camera;
    level.pitch = 0;
    Vec3 move = apps::right(level) * push.x + apps::ahead(level) * push.y;
    const float length = glm::length(move);
    if (length > 0.0F) feet = slide(trace, feet, move * (speed * seconds / std::max(1.0F, length)));

    walker.fallSpeed = walker.onGround ? 0.0F : walker.fallSpeed + Walker::gravity * seconds;
    float fall = walker.fallSpeed * seconds;
    if (fall < 0.0F) { // upwards
        const auto head = trace(feet + Vec3(0, 0, Walker::eyeHeight), Vec3(0, 0, 1), Walker::headroom - fall);
        if (head) {
            fall = -std::max(0.0F, head->distance - Walker::headroom);
            walker.fallSpeed = 0;
        }
        feet.z -= fall;
        walker.onGround = false;
    } else {
        // On the ground a step down is walked, not fallen.
        const float reach = walker.onGround ? Walker::stepHeight : fall;
        const auto ground = drop(trace, feet, reach + skin);
        walker.onGround = ground.has_value();
        feet.z -= ground ? *ground - Walker::stepHeight : fall;
        if (walker.onGround) walker.fallSpeed = 0;
    }
    moved.eye = feet + Vec3(0, 0, Walker::eyeHeight);
    return moved;
}

void jump(Walker& walker) {
    if (!walker.onGround) return;
    walker.onGround = false;
    walker.fallSpeed = -Walker::jumpSpeed;
}

} // namespace pieview
