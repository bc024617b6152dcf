#include "pie/maps/partition.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pie::maps {
namespace {

/// Cosines that differ by less may be each other's rounding.
constexpr float rounding = 1e-5F;
const level::Tree noTree;

std::uint8_t classOf(const Vec3& normal) {
    const Vec3 size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const auto third = [&](int other) {
        // NaN, of a normal of length 0, goes to the middle.
        const float place = 1.5F * normal[other] / size[axis];
        return place < -0.5F ? 0 : (place > 0.5F ? 2 : 1);
    };
    const int face = 2 * axis + (normal[axis] < 0.0F ? 1 : 0);
    return static_cast<std::uint8_t>(9 * face + 3 * third((axis + 1) % 3) + third((axis + 2) % 3));
}

float liftIn(const scene::Scene& scene) {
    const float largest =
        std::max({std::abs(scene.bounds.lower.x), std::abs(scene.bounds.lower.y), std::abs(scene.bounds.lower.z),
                  std::abs(scene.bounds.upper.x), std::abs(scene.bounds.upper.y), std::abs(scene.bounds.upper.z)});
    return std::max(std::min(0.25F, 1e-4F * glm::length(scene.bounds.size())), 4e-6F * largest);
}

} // namespace

Partition::Partition(const scene::Scene& scene, const level::Tree& tree, SplitBy by)
    : scene_(scene), by_(by), cells_(by == SplitBy::Cell || by == SplitBy::Both ? tree : noTree), lift_(liftIn(scene)) {
    if (byNormal()) classify();
}

void Partition::classify() {
    std::array<Box, mostClasses> boxes;
    classes_.resize(scene_.triangles.size());
    for (std::uint32_t t = 0; t < classes_.size(); ++t) {
        classes_[t] = {classOf(normalOf(t)), classOf(-normalOf(t))};
        if (normalOf(t) == Vec3(0.0F)) continue; // nothing meets it
        boxes[classes_[t][0]].extend(normalOf(t));
        if (scene_.material(t).twoSided) boxes[classes_[t][1]].extend(-normalOf(t));
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t c = 0; c < mostClasses; ++c) {
            const float nan = std::numeric_limits<float>::quiet_NaN();
            normals_[0][axis][c] = boxes[c].empty() ? nan : boxes[c].lower[static_cast<int>(axis)];
            normals_[1][axis][c] = boxes[c].empty() ? nan : boxes[c].upper[static_cast<int>(axis)];
        }
}

Partition::Place Partition::placeOf(const photons::Photon& photon) const {
    Place place;
    const Vec3& normal = normalOf(photon.triangle);
    const bool back = scene_.material(photon.triangle).twoSided && glm::dot(photon.direction, normal) > 0.0F;
    if (byNormal()) place.normal = classes_[photon.triangle][back ? 1 : 0];
    if (cells_.size() > 1)
        place.cell = static_cast<std::uint8_t>(cells_.cellAt(photon.position + (back ? -lift_ : lift_) * normal));
    return place;
}

VisibilityCells::Set Partition::cellsSeenFrom(const scene::Receiver& at) const {
    if (cells_.size() < 2) return ~VisibilityCells::Set{0};
    const Vec3 off = lift_ * at.normal;
    VisibilityCells::Set cells = cells_.seenFrom(at.inset + off);
    if (at.twoSided) cells |= cells_.seenFrom(at.inset - off);
    return cells;
}

Partition::Seen Partition::seenFrom(const scene::Receiver& at, float minCosine) const {
    Seen seen;
    seen.cells = cellsSeenFrom(at);
    if (!byNormal()) return seen;
    // The least and the largest cosine come from opposite corners of a class's box: which, the receiver's normal says
    // for all classes, so that these loops have no branches.
    std::array<float, mostClasses> least; // NOLINT(cppcoreguidelines-pro-type-member-init): filled at once
    std::array<float, mostClasses> most;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    const auto sum = [&](std::size_t corner, std::array<float, mostClasses>& cosines) {
        const auto& x = normals_[at.normal.x >= 0.0F ? corner : 1 - corner][0];
        const auto& y = normals_[at.normal.y >= 0.0F ? corner : 1 - corner][1];
        const auto& z = normals_[at.normal.z >= 0.0F ? corner : 1 - corner][2];
        for (std::size_t c = 0; c < mostClasses; ++c)
            cosines[c] = x[c] * at.normal.x + y[c] * at.normal.y + z[c] * at.normal.z;
    };
    sum(0, least);
    sum(1, most);
    const float possible = minCosine - rounding;
    const float certain = minCosine + rounding;
    std::uint64_t front = 0;
    std::uint64_t back = 0;
    std::uint64_t doubtful = 0;
    for (std::size_t c = 0; c < mostClasses; ++c) {
        front |= std::uint64_t{most[c] > possible} << c;
        back |= std::uint64_t{-least[c] > possible} << c;
        doubtful |= std::uint64_t{!(least[c] > certain)} << c;
    }
    seen.classes = front | (at.twoSided ? back : 0);
    seen.allFace = !at.twoSided && (front & doubtful) == 0;
    return seen;
}

std::vector<VisibilityCells::Piece> Partition::cut(std::uint32_t triangle, bool back) const {
    std::vector<glm::dvec3> corners(3);
    for (int i = 0; i < 3; ++i) corners[static_cast<std::size_t>(i)] = glm::dvec3(scene_.corner(triangle, i));
    return cells_.cut(std::move(corners), glm::dvec3((back ? -lift_ : lift_) * normalOf(triangle)));
}

std::size_t Partition::bytes() const {
    return cells_.bytes() + classes_.capacity() * sizeof(classes_[0]) + sizeof(normals_);
}

} // namespace pie::maps
