#pragma once
// Vectors, colours and boxes. One length unit is one level unit (Quake 3: 1.5 inch). Right-handed, z up.

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <limits>

namespace pie {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec4 = glm::vec4;
/// Colour or spectral quantity in three channels. Its unit stands in the name or the comment of whatever holds it.
using Rgb = glm::vec3;
/// Colour as stored in files: 0 to 255, no linearisation.
using Rgba8 = glm::u8vec4;

/// Axis-aligned box; empty (lower > upper) until extended.
struct Box {
    Vec3 lower{std::numeric_limits<float>::max()};
    Vec3 upper{std::numeric_limits<float>::lowest()};

    void extend(const Vec3& point) {
        lower = glm::min(lower, point);
        upper = glm::max(upper, point);
    }
    void extend(const Box& other) {
        lower = glm::min(lower, other.lower);
        upper = glm::max(upper, other.upper);
    }
    [[nodiscard]] bool empty() const { return lower.x > upper.x; }
    [[nodiscard]] Vec3 centre() const { return 0.5F * (lower + upper); }
    [[nodiscard]] Vec3 size() const { return empty() ? Vec3(0.0F) : upper - lower; }
};

/// The largest channel of a colour.
[[nodiscard]] inline float maxChannel(const Rgb& c) { return glm::max(c.x, glm::max(c.y, c.z)); }

/// Relative weight of a colour where one number is needed (choosing between lights, Russian roulette): the channel
/// mean.
[[nodiscard]] inline float meanChannel(const Rgb& c) { return (c.x + c.y + c.z) * (1.0F / 3.0F); }

/// Two unit vectors that complete the unit vector `normal` to a right-handed orthonormal frame. Continuous except at
/// normal.z = 0- (Duff et al. 2017).
struct Frame {
    Vec3 tangent;
    Vec3 bitangent;
    Vec3 normal;

    explicit Frame(const Vec3& n) : normal(n) {
        const float sign = n.z >= 0.0F ? 1.0F : -1.0F;
        const float a = -1.0F / (sign + n.z);
        const float b = n.x * n.y * a;
        tangent = Vec3(1.0F + sign * n.x * n.x * a, sign * b, -sign * n.x);
        bitangent = Vec3(b, sign + n.y * n.y * a, -n.y);
    }
    [[nodiscard]] Vec3 toWorld(const Vec3& local) const {
        return tangent * local.x + bitangent * local.y + normal * local.z;
    }
};

} // namespace pie
