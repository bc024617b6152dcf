#pragma once
// What gets through from a point to a light. Internal to this folder.

#include "pie/intersect/intersector.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <span>
#include <vector>

namespace pie::reference {

/// Rays with what they are to reach, and the answers.
struct ShadowRays {
    std::vector<intersect::Ray> rays;
    std::vector<std::uint8_t> toSky; ///< counts only where the first thing that is no filter is the front of a sky
    std::vector<Rgb> through;

    void clear() {
        rays.clear();
        toSky.clear();
    }
};

/// Fills `through`.
void trace(const intersect::Intersector& intersector, const scene::Scene& scene, ShadowRays& shadows);

/// Off a surface, against rounding: see lights::surfaceOffset.
[[nodiscard]] float offsetAt(const scene::Scene& scene, const Vec3& point);
/// tMin of a ray that goes on behind a filter at `t`; `again`: that filter came back by rounding.
[[nodiscard]] float behind(float t, bool again);

} // namespace pie::reference
