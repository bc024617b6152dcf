#include "pie/intersect/overlap.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

namespace pie::intersect {
namespace {

/// A triangle seen along the axis that its normal is near to.
struct Flat {
    std::uint32_t triangle = 0;
    int axis = 0;
    double height = 0; ///< of its plane above the origin
    Vec3 normal{0.0F}; ///< turned towards the positive axis
    std::array<glm::dvec2, 3> corners;
    glm::dvec2 lower{0.0}, upper{0.0};
};

/// Not the largest component: noise must not part normals between two axes.
int axisOf(const Vec3& normal) {
    for (int axis = 0; axis < 2; ++axis)
        if (std::abs(normal[axis]) > 0.56F) return axis;
    return 2;
}

Flat flatten(const scene::Scene& scene, std::uint32_t t) {
    Flat flat;
    flat.triangle = t;
    flat.normal = scene.normals[t];
    flat.axis = axisOf(flat.normal);
    if (flat.normal[flat.axis] < 0.0F) flat.normal = -flat.normal;
    flat.height = glm::dot(glm::dvec3(flat.normal), glm::dvec3(scene.corner(t, 0)));
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 p(scene.corner(t, i));
        flat.corners[static_cast<std::size_t>(i)] = {p[(flat.axis + 1) % 3], p[(flat.axis + 2) % 3]};
    }
    flat.lower = glm::min(flat.corners[0], glm::min(flat.corners[1], flat.corners[2]));
    flat.upper = glm::max(flat.corners[0], glm::max(flat.corners[1], flat.corners[2]));
    return flat;
}

/// True when an edge of `a` has all of `b` on its far side, but for `slack`.
bool separates(const Flat& a, const Flat& b, double slack) {
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 p = a.corners[i];
        const glm::dvec2 along = a.corners[(i + 1) % 3] - p;
        const double length = glm::length(along);
        if (!(length > 0)) continue;
        const glm::dvec2 across = glm::dvec2(-along.y, along.x) / length;
        const double inside = glm::dot(across, a.corners[(i + 2) % 3] - p) > 0 ? 1 : -1;
        if (std::all_of(b.corners.begin(), b.corners.end(),
                        [&](const glm::dvec2& q) { return inside * glm::dot(across, q - p) <= slack; }))
            return true;
    }
    return false;
}

struct Pair {
    std::uint32_t a = 0, b = 0;
};

/// Finds the overlaps among triangles whose planes are equally high.
void sweep(std::span<Flat> flats, double slack, std::vector<std::uint32_t>& counts, std::vector<Pair>& pairs) {
    std::sort(flats.begin(), flats.end(), [](const Flat& a, const Flat& b) {
        return a.lower.x != b.lower.x ? a.lower.x < b.lower.x : a.triangle < b.triangle;
    });
    for (std::size_t i = 0; i < flats.size(); ++i) {
        const Flat& a = flats[i];
        for (std::size_t j = i + 1; j < flats.size() && flats[j].lower.x < a.upper.x - slack; ++j) {
            const Flat& b = flats[j];
            if (counts[a.triangle] >= Overlaps::most || counts[b.triangle] >= Overlaps::most) continue;
            if (b.lower.y >= a.upper.y - slack || a.lower.y >= b.upper.y - slack) continue;
            if (glm::dot(a.normal, b.normal) < 0.9999F) continue;
            if (separates(a, b, slack) || separates(b, a, slack)) continue;
            pairs.push_back({a.triangle, b.triangle});
            ++counts[a.triangle];
            ++counts[b.triangle];
        }
    }
}

} // namespace

Overlaps findOverlaps(const scene::Scene& scene) {
    Overlaps overlaps;
    overlaps.begin.assign(scene.triangles.size() + 1, 0);
    if (scene.bounds.empty()) return overlaps;
    const Vec3 far = glm::max(glm::abs(scene.bounds.lower), glm::abs(scene.bounds.upper));
    const double extent = glm::max(far.x, glm::max(far.y, far.z));
    // Positions are rounded to 6e-8 of their size, planes through them somewhat more.
    const double slack = 4e-6 * extent;
    std::vector<Flat> flats;
    flats.reserve(scene.triangles.size());
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t)
        if (scene.normals[t] != Vec3(0.0F)) flats.push_back(flatten(scene, t));
    std::sort(flats.begin(), flats.end(), [](const Flat& a, const Flat& b) {
        if (a.axis != b.axis) return a.axis < b.axis;
        return a.height != b.height ? a.height < b.height : a.triangle < b.triangle;
    });
    std::vector<std::uint32_t> counts(scene.triangles.size(), 0);
    std::vector<Pair> pairs;
    for (std::size_t begin = 0, end = 0; begin < flats.size(); begin = end) {
        for (end = begin + 1; end < flats.size() && flats[end].axis == flats[begin].axis &&
                              flats[end].height - flats[end - 1].height <= slack;)
            ++end;
        sweep(std::span(flats).subspan(begin, end - begin), slack, counts, pairs);
    }
    std::inclusive_scan(counts.begin(), counts.end(), overlaps.begin.begin() + 1);
    overlaps.others.resize(2 * pairs.size());
    std::vector<std::uint32_t> next(overlaps.begin.begin(), overlaps.begin.end() - 1);
    for (const Pair& pair : pairs) {
        overlaps.others[next[pair.a]++] = pair.b;
        overlaps.others[next[pair.b]++] = pair.a;
    }
    return overlaps;
}

} // namespace pie::intersect
