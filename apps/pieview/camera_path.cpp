#include "apps/pieview/camera_path.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pieview {
namespace {

constexpr std::size_t stepsPerKey = 64;

/// From b to c as t goes from 0 to 1, with the spans of parameter between the four: equal spans are the uniform curve,
/// which overshoots where keys are close to others that are far apart.
template <class T>
T catmullRom(const T& a, const T& b, const T& c, const T& d, const std::array<float, 3>& span, float t) {
    const auto tangent = [](const T& before, const T& here, const T& after, float first, float second) {
        return (here - before) / first - (after - before) / (first + second) + (after - here) / second;
    };
    const T atB = tangent(a, b, c, span[0], span[1]) * span[1];
    const T atC = tangent(b, c, d, span[1], span[2]) * span[1];
    const float t2 = t * t;
    const float t3 = t2 * t;
    return b * (2 * t3 - 3 * t2 + 1) + atB * (t3 - 2 * t2 + t) + c * (3 * t2 - 2 * t3) + atC * (t3 - t2);
}

float between(const Camera& a, const Camera& b) {
    return glm::length(b.eye - a.eye) + std::abs(b.yaw - a.yaw) + std::abs(b.pitch - a.pitch);
}

} // namespace

CameraPath::CameraPath(std::vector<Camera> keys) : keys_(std::move(keys)) {
    // The short way round.
    for (std::size_t i = 1; i < keys_.size(); ++i)
        keys_[i].yaw = keys_[i - 1].yaw + std::remainder(keys_[i].yaw - keys_[i - 1].yaw, 360.0F);
    if (keys_.empty()) return;
    lengths_.push_back(0);
    Camera last = keys_.front();
    for (std::size_t step = 1; step <= stepsPerKey * (keys_.size() - 1); ++step) {
        const Camera next = point(static_cast<float>(step) / stepsPerKey);
        lengths_.push_back(lengths_.back() + between(last, next));
        last = next;
    }
}

Camera CameraPath::point(float key) const {
    const auto most = static_cast<float>(keys_.size() - 1);
    const float place = std::clamp(key, 0.0F, most);
    const auto from = static_cast<std::size_t>(std::min(place, std::max(0.0F, most - 1.0F)));
    const auto keyAt = [&](std::size_t i) -> const Camera& { return keys_[std::min(i, keys_.size() - 1)]; };
    const Camera& a = keyAt(from == 0 ? 0 : from - 1);
    const Camera& b = keyAt(from);
    const Camera& c = keyAt(from + 1);
    const Camera& d = keyAt(from + 2);
    const float t = place - static_cast<float>(from);
    // Centripetal: spans are the square roots of distances (Yuksel, Schaefer and Keyser 2011: no loops, no cusps).
    const auto span = [](const Camera& p, const Camera& q) { return std::sqrt(std::max(1e-3F, between(p, q))); };
    const std::array<float, 3> spans{span(a, b), span(b, c), span(c, d)};
    return {catmullRom(a.eye, b.eye, c.eye, d.eye, spans, t), catmullRom(a.yaw, b.yaw, c.yaw, d.yaw, spans, t),
            catmullRom(a.pitch, b.pitch, c.pitch, d.pitch, spans, t)};
}

Camera CameraPath::at(float distance) const {
    const float place = std::clamp(distance, 0.0F, length());
    const auto after = std::upper_bound(lengths_.begin(), lengths_.end(), place);
    const auto step = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, after - lengths_.begin() - 1));
    float share = 0;
    if (step + 1 < lengths_.size() && lengths_[step + 1] > lengths_[step])
        share = (place - lengths_[step]) / (lengths_[step + 1] - lengths_[step]);
    return apps::turned(point((static_cast<float>(step) + share) / stepsPerKey), 0, 0);
}

} // namespace pieview
