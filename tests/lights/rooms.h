#pragma once
// Small scenes by hand.

#include "pie/lights/light.h"
#include "pie/scene/scene.h"

#include <array>
#include <memory>
#include <vector>

namespace pie::test {

/// Collects quads a b c d (counter-clockwise from the front) with a material each.
struct RoomBuilder {
    std::vector<Vec3> corners;
    std::vector<std::uint32_t> materialOf;
    std::vector<scene::Material> materials;

    std::uint32_t material(const scene::Material& m) {
        materials.push_back(m);
        return static_cast<std::uint32_t>(materials.size() - 1);
    }
    void triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::uint32_t m) {
        corners.insert(corners.end(), {a, b, c});
        materialOf.push_back(m);
    }
    void quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, std::uint32_t m) {
        triangle(a, b, c, m);
        triangle(a, c, d, m);
    }
    /// The inside of a box; `m` for floor, ceiling, -x, +x, -y, +y.
    void inside(const Vec3& lower, const Vec3& upper, const std::array<std::uint32_t, 6>& m) {
        const auto p = [&](int x, int y, int z) {
            return Vec3(x != 0 ? upper.x : lower.x, y != 0 ? upper.y : lower.y, z != 0 ? upper.z : lower.z);
        };
        quad(p(0, 0, 0), p(1, 0, 0), p(1, 1, 0), p(0, 1, 0), m[0]);
        quad(p(0, 0, 1), p(0, 1, 1), p(1, 1, 1), p(1, 0, 1), m[1]);
        quad(p(0, 0, 0), p(0, 1, 0), p(0, 1, 1), p(0, 0, 1), m[2]);
        quad(p(1, 0, 0), p(1, 0, 1), p(1, 1, 1), p(1, 1, 0), m[3]);
        quad(p(0, 0, 0), p(0, 0, 1), p(1, 0, 1), p(1, 0, 0), m[4]);
        quad(p(0, 1, 0), p(1, 1, 0), p(1, 1, 1), p(0, 1, 1), m[5]);
    }
    [[nodiscard]] std::shared_ptr<const scene::Scene> build() const {
        return std::make_shared<scene::Scene>(scene::makeScene(corners, materialOf, materials));
    }
};

inline scene::Material opaque(const Rgb& reflectance) {
    scene::Material material;
    material.reflectance = reflectance;
    return material;
}
inline scene::Material sky() {
    scene::Material material;
    material.interaction = scene::Interaction::Sky;
    return material;
}

/// A lamp without the compiler's liberties.
inline lights::Light lamp(const Vec3& position, const Rgb& watts) {
    lights::PointLight light{position, watts, {}};
    light.falloff.minDistance = 0;
    return light;
}

} // namespace pie::test
