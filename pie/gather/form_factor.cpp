#include "pie/gather/form_factor.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pie::gather {
namespace {

using glm::dvec3;

/// Angle between a and b times the sine-weighted height of their plane: one edge's term of Lambert's formula.
double edge(const dvec3& a, const dvec3& b, const dvec3& normal) {
    const dvec3 across = glm::cross(a, b);
    const double length = glm::length(across);
    if (!(length > 0)) return 0; // seen edge on, or from its end
    return std::atan2(length, glm::dot(a, b)) * glm::dot(across, normal) / length;
}

} // namespace

double formFactor(std::span<const Vec3> corners, const Vec3& point, const Vec3& normal) {
    const dvec3 centre(point);
    const dvec3 up(normal);
    // Walks the polygon clipped by the horizon without storing it: `first` and `last` are its corners so far.
    double sum = 0;
    dvec3 first(0);
    dvec3 last(0);
    bool any = false;
    const auto visit = [&](const dvec3& p) {
        if (any)
            sum += edge(last, p, up);
        else
            first = p;
        last = p;
        any = true;
    };
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const dvec3 a = dvec3(corners[i]) - centre;
        const dvec3 b = dvec3(corners[i + 1 < corners.size() ? i + 1 : 0]) - centre;
        const double ha = glm::dot(a, up);
        const double hb = glm::dot(b, up);
        if (ha >= 0) visit(a);
        if ((ha > 0 && hb < 0) || (ha < 0 && hb > 0)) visit(a + (b - a) * (ha / (ha - hb)));
    }
    if (!any) return 0;
    sum += edge(last, first, up);
    const double share = std::abs(sum) / (2 * std::numbers::pi);
    return share <= 1 ? share : share > 1 ? 1.0 : 0.0; // not a number: 0
}

} // namespace pie::gather
