#pragma once
// A camera that goes along a recorded way: a centripetal Catmull-Rom curve through the keyframes, walked at an even
// pace (by arc length), so that frames of a film and measurements along it do not depend on how densely it was
// recorded.

#include "apps/support/camera.h"

#include <vector>

namespace pieview {

using apps::Camera;

class CameraPath {
public:
    explicit CameraPath(std::vector<Camera> keys);
    /// Units, along the curve. Turning on the spot counts a unit a degree, so that it takes time, too.
    [[nodiscard]] float length() const { return lengths_.empty() ? 0.0F : lengths_.back(); }
    /// At `distance` from the start, cut to the curve. There must be a key.
    [[nodiscard]] Camera at(float distance) const;
    [[nodiscard]] bool empty() const { return keys_.empty(); }

private:
    [[nodiscard]] Camera point(float key) const; ///< by number of the key, with fractions
    std::vector<Camera> keys_;                   ///< yaw without jumps
    std::vector<float> lengths_;                 ///< up to step i of stepsPerKey a key
};

} // namespace pieview
