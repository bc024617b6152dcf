#pragma once
// The part of space in which photons count for a receiver (pi-engine 3.5.1, fig 3.9). All four are one family with a
// radius r; a search for the k nearest looks for the smallest of the family that holds k photons.
//
//   Sphere     distance <= r. Photons of every surface near by leak in.
//   Slice      the sphere, and height over the receiver's plane <= halfThickness (fig 3.8): the paper's choice.
//   Cylinder   distance from the receiver's axis <= r, height <= halfThickness.
//   Ellipsoid  semi-axes r, r and min(r, halfThickness) along the normal (eq 3.13): the slice with a rounded border.
//
// "Height" is along the receiver's normal, to both sides.

#include "pie/core/vec.h"

#include <algorithm>
#include <cstdint>

namespace pie::gather {

enum class SearchVolume : std::uint8_t { Sphere, Slice, Cylinder, Ellipsoid };

/// The volumes of one receiver.
struct VolumeAt {
    SearchVolume kind;
    float halfThickness; ///< units, 0 to infinity
    Vec3 point;
    Vec3 normal; ///< unit

    /// Square of the radius of the smallest volume that holds the position, whose squared distance from the point is
    /// `distanceSquared`; negative when none does.
    [[nodiscard]] float needed(const Vec3& position, float distanceSquared) const {
        if (kind == SearchVolume::Sphere) return distanceSquared;
        const Vec3 offset = position - point;
        const float height = glm::dot(offset, normal); // eq 3.12
        if (!(height <= halfThickness && height >= -halfThickness)) return -1.0F;
        if (kind == SearchVolume::Slice) return distanceSquared;
        if (kind == SearchVolume::Cylinder) return acrossSquared(offset, height);
        const float thickSquared = halfThickness * halfThickness;
        const float heightSquared = height * height;
        if (distanceSquared <= thickSquared || heightSquared == 0.0F) return distanceSquared;
        // x²/r² + h²/T² = 1 for r; not less than the distance, also after rounding.
        if (!(heightSquared < thickSquared)) return -1.0F;
        return std::max(distanceSquared, acrossSquared(offset, height) / (1.0F - heightSquared / thickSquared));
    }
    /// By how much the squared distance of a position can exceed what is needed to hold it.
    [[nodiscard]] float surplus() const {
        return kind == SearchVolume::Cylinder ? 1.0001F * halfThickness * halfThickness : 0.0F;
    }
    /// The argument of the kernel: 0 at the receiver, 1 on the border of the volume of this radius.
    [[nodiscard]] double t(const Vec3& position, float distanceSquared, double radius) const {
        auto square = static_cast<double>(distanceSquared);
        if (kind == SearchVolume::Cylinder || kind == SearchVolume::Ellipsoid) {
            const Vec3 offset = position - point;
            const float height = glm::dot(offset, normal);
            square = static_cast<double>(acrossSquared(offset, height));
            if (kind == SearchVolume::Ellipsoid && height != 0.0F) {
                const double stretched =
                    static_cast<double>(height) * radius / std::min(radius, static_cast<double>(halfThickness));
                square += stretched * stretched;
            }
        }
        return std::min(1.0, square / (radius * radius));
    }

private:
    [[nodiscard]] float acrossSquared(const Vec3& offset, float height) const {
        const Vec3 across = offset - height * normal;
        return glm::dot(across, across);
    }
};

} // namespace pie::gather
