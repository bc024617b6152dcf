#include "pie/brushes/texture_axes.h"

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>

namespace pie::brushes {
namespace {

double scaleOf(double scale) { return scale == 0 ? 1 : scale; }

struct BaseAxes {
    glm::dvec3 normal, s, t;
};
/// Faces take their texture along the axes of the nearest of six directions: floor, ceiling, west, east, south, north.
const std::array<BaseAxes, 6> baseAxes{{{{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},
                                        {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}},
                                        {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
                                        {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
                                        {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}},
                                        {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}}}};

TextureMapping mapping(const ShiftedTexture& text, const glm::dvec3& normal, int width, int height) {
    const BaseAxes* best = baseAxes.data();
    double nearest = 0;
    for (const BaseAxes& axes : baseAxes)
        // Slopes of exactly 45 degrees go to the earlier direction, as in the level compiler.
        if (const double facing = glm::dot(normal, axes.normal); facing > nearest + 1e-4) {
            nearest = facing;
            best = &axes;
        }
    const double angle = glm::radians(text.rotate);
    // Quarter turns are exact.
    const double quarter = text.rotate / 90;
    const bool whole = quarter == std::round(quarter);
    const double sine = whole ? std::round(std::sin(angle)) : std::sin(angle);
    const double cosine = whole ? std::round(std::cos(angle)) : std::cos(angle);
    // Rotation acts on coordinates: on the component each axis runs along, whatever its sign.
    const auto along = [](const glm::dvec3& axis) { return axis.x != 0 ? 0 : axis.y != 0 ? 1 : 2; };
    const int sv = along(best->s);
    const int tv = along(best->t);
    TextureMapping result;
    const std::array<const glm::dvec3*, 2> axes{&best->s, &best->t};
    const std::array<double, 2> size{static_cast<double>(width), static_cast<double>(height)};
    for (std::size_t i = 0; i < 2; ++i) {
        glm::dvec3 turned = *axes.at(i);
        const double s = cosine * turned[sv] - sine * turned[tv];
        const double t = sine * turned[sv] + cosine * turned[tv];
        turned[sv] = s;
        turned[tv] = t;
        result.axes.at(i) = turned / (scaleOf(text.scale.at(i)) * size.at(i));
        result.shift.at(i) = text.shift.at(i) / size.at(i);
    }
    return result;
}

TextureMapping mapping(const AxisTexture& text, const glm::dvec3& /*normal*/, int width, int height) {
    TextureMapping result;
    const std::array<double, 2> size{static_cast<double>(width), static_cast<double>(height)};
    for (std::size_t i = 0; i < 2; ++i) {
        result.axes.at(i) = text.axes.at(i) / (scaleOf(text.scale.at(i)) * size.at(i));
        result.shift.at(i) = text.shift.at(i) / size.at(i);
    }
    return result;
}

TextureMapping mapping(const MatrixTexture& text, const glm::dvec3& normal, int /*width*/, int /*height*/) {
    // The face's own axes: the direction turned about z and then about y (GtkRadiant's ComputeAxisBase).
    glm::dvec3 n = normal;
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(n[axis]) < 1e-6) n[axis] = 0;
    const double aboutY = -std::atan2(n.z, std::hypot(n.x, n.y));
    const double aboutZ = std::atan2(n.y, n.x);
    const glm::dvec3 x(-std::sin(aboutZ), std::cos(aboutZ), 0);
    const glm::dvec3 y(-std::sin(aboutY) * std::cos(aboutZ), -std::sin(aboutY) * std::sin(aboutZ), -std::cos(aboutY));
    TextureMapping result;
    for (std::size_t i = 0; i < 2; ++i) {
        const glm::dvec3& row = text.rows.at(i);
        result.axes.at(i) = row.x * x + row.y * y;
        result.shift.at(i) = row.z;
    }
    return result;
}

} // namespace

glm::dvec2 TextureMapping::at(const glm::dvec3& p) const {
    return {glm::dot(axes[0], p) + shift[0], glm::dot(axes[1], p) + shift[1]};
}

TextureMapping makeMapping(const TextureText& text, const glm::dvec3& normal, int width, int height) {
    return std::visit([&](const auto& form) { return mapping(form, normal, std::max(1, width), std::max(1, height)); },
                      text);
}

} // namespace pie::brushes
