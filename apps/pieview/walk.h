#pragma once
// Walking: a player as large as Quake 3's (30 × 30 units, eyes 50 above the floor) that falls, climbs steps, slides
// along walls and never passes through them. What is solid is asked through rays, so that a test can walk in a room of
// its own making.

#include "apps/support/camera.h"

#include <functional>
#include <optional>

namespace pieview {

using apps::Camera;
using pie::Vec3;

struct Obstacle {
    float distance = 0;
    Vec3 normal{0.0F}; ///< unit, of either side
};
/// The nearest solid thing from `origin` in the unit direction `direction`, nearer than `reach`.
using Trace = std::function<std::optional<Obstacle>(const Vec3& origin, const Vec3& direction, float reach)>;

struct Walker {
    static constexpr float eyeHeight = 50, halfWidth = 15, headroom = 6;    ///< eye over feet; head over eye
    static constexpr float stepHeight = 18, gravity = 800, jumpSpeed = 270; ///< as the game's
    float fallSpeed = 0;                                                    ///< units per second, downwards
    bool onGround = false;
};

/// Moves for `seconds`. `push` as for flown(), without its z; `speed` in units per second.
[[nodiscard]] Camera walked(const Camera& camera, Walker& walker, const Trace& trace, const Vec3& push, float speed,
                            float seconds);
/// Leaves the ground if standing on it.
void jump(Walker& walker);

} // namespace pieview
