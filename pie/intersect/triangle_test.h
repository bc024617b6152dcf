#pragma once
// One ray against one triangle, watertight: rays through a shared edge or vertex hit at least one of the triangles that
// share it (Woop, Benthin, Wald 2013). Brute force and the BSP tree use the same test, so they agree to the bit. Not
// for use outside pie/intersect.

#include "pie/intersect/intersector.h"

#include <glm/vec3.hpp>

#include <array>
#include <cmath>

namespace pie::intersect {

/// False for rays that can hit nothing: a direction that is zero or not finite, an origin that is not finite, limits
/// that are not numbers or leave no room.
[[nodiscard]] inline bool usable(const Ray& ray) {
    const Vec3& d = ray.direction;
    const Vec3& o = ray.origin;
    return std::isfinite(d.x + d.y + d.z) && std::isfinite(o.x) && std::isfinite(o.y) && std::isfinite(o.z) &&
           (d.x != 0.0F || d.y != 0.0F || d.z != 0.0F) && ray.tMin < ray.tMax && 0.0F < ray.tMax;
}

/// A ray made ready: the shear that turns its direction into the z axis.
class PreparedRay {
public:
    explicit PreparedRay(const Ray& ray) : origin_(ray.origin), direction_(ray.direction) {
        // Without branches: which axis is the main one is anybody's guess.
        const Vec3 size = glm::abs(ray.direction);
        const int notX = static_cast<int>(size.x < size.y) | static_cast<int>(size.x < size.z);
        z_ = notX * (2 - static_cast<int>(size.y >= size.z));
        const int turned = static_cast<int>(ray.direction[z_] < 0.0F);
        x_ = afterwards[z_ + turned];
        y_ = afterwards[z_ + 1 - turned];
        shearX_ = ray.direction[x_] / ray.direction[z_];
        shearY_ = ray.direction[y_] / ray.direction[z_];
    }

    /// Distance and barycentric weights of corners 1 and 2 where the line of the ray meets the triangle.
    struct Meeting {
        float t = 0, u = 0, v = 0;
    };
    /// True when it meets it at tMin <= t < tMax.
    [[nodiscard]] bool meets(const std::array<Vec3, 3>& corners, float tMin, float tMax, Meeting& meeting) const {
        const Vec3 a = corners[0] - origin_;
        const Vec3 b = corners[1] - origin_;
        const Vec3 c = corners[2] - origin_;
        const float ax = a[x_] - shearX_ * a[z_];
        const float ay = a[y_] - shearY_ * a[z_];
        const float bx = b[x_] - shearX_ * b[z_];
        const float by = b[y_] - shearY_ * b[z_];
        const float cx = c[x_] - shearX_ * c[z_];
        const float cy = c[y_] - shearY_ * c[z_];
        float wa = cx * by - cy * bx;
        float wb = ax * cy - ay * cx;
        float wc = bx * ay - by * ax;
        if (wa == 0.0F || wb == 0.0F || wc == 0.0F) {
            // On an edge as far as floats can tell: doubles decide, the same way for both triangles of the edge.
            wa = difference(cx, by, cy, bx);
            wb = difference(ax, cy, ay, cx);
            wc = difference(bx, ay, by, ax);
        }
        if ((wa < 0.0F || wb < 0.0F || wc < 0.0F) && (wa > 0.0F || wb > 0.0F || wc > 0.0F)) return false;
        return meetsPlane(origin_, direction_, corners, {wa, wb, wc}, meeting) && meeting.t >= tMin && meeting.t < tMax;
    }

    /// The end of the test, for a line that passes within a triangle: `weights` are of its corners, none of them of
    /// another sign than the rest. False where it lies in the plane.
    [[nodiscard]] static bool meetsPlane(const Vec3& origin, const glm::dvec3& direction,
                                         const std::array<Vec3, 3>& corners, const Vec3& weights, Meeting& meeting) {
        const float sum = weights.x + weights.y + weights.z;
        if (sum == 0.0F) return false;
        // The weights say where the ray passes, not how far that is: for slivers they are differences of nearly equal
        // products. The plane is exact there too.
        const glm::dvec3 first(corners[0] - origin);
        const glm::dvec3 normal =
            glm::cross(glm::dvec3(corners[1] - origin) - first, glm::dvec3(corners[2] - origin) - first);
        const double slope = glm::dot(normal, direction);
        if (slope == 0.0) return false;
        const auto t = static_cast<float>(glm::dot(normal, first) / slope);
        const float perSum = 1.0F / sum;
        meeting = {t, weights.y * perSum, weights.z * perSum};
        return true;
    }

    /// The two that a triangle is looked at along, and the main one.
    [[nodiscard]] std::array<std::uint32_t, 3> axes() const {
        return {static_cast<std::uint32_t>(x_), static_cast<std::uint32_t>(y_), static_cast<std::uint32_t>(z_)};
    }
    [[nodiscard]] float shearX() const { return shearX_; }
    [[nodiscard]] float shearY() const { return shearY_; }

private:
    static float difference(float a, float b, float c, float d) {
        return static_cast<float>(double{a} * double{b} - double{c} * double{d});
    }

    static constexpr std::array<int, 4> afterwards{1, 2, 0, 1}; ///< the axes after an axis

    Vec3 origin_;
    glm::dvec3 direction_;
    int x_ = 0, y_ = 1, z_ = 2;
    float shearX_ = 0, shearY_ = 0;
};

/// Keeps the nearer hit; of two at the same distance, the triangle with the lower number, whatever the order of asking.
class Nearest {
public:
    Nearest(const Ray& ray, Hit& hit)
        : prepared_(ray), tMin_(ray.tMin > 0.0F ? ray.tMin : 0.0F), tMax_(ray.tMax), hit_(hit) {
        hit_ = Hit{};
    }

    void test(std::uint32_t triangle, const std::array<Vec3, 3>& corners) {
        PreparedRay::Meeting meeting;
        const float limit = hit_.found() ? std::nextafter(hit_.t, std::numeric_limits<float>::infinity()) : tMax_;
        if (!prepared_.meets(corners, tMin_, limit, meeting)) return;
        if (hit_.found() && meeting.t == hit_.t && triangle >= hit_.triangle) return;
        hit_ = {triangle, meeting.t, meeting.u, meeting.v};
    }
    /// Nothing beyond it matters any more.
    [[nodiscard]] float limit() const { return hit_.found() ? hit_.t : tMax_; }

private:
    PreparedRay prepared_;
    float tMin_, tMax_;
    Hit& hit_;
};

} // namespace pie::intersect
