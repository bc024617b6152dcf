#include "pie/gather/area_shape.h"

#include "pie/gather/numbers.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pie::gather {
namespace {

using glm::dvec2;

/// Gauss-Legendre, 8 points on [0, 1].
struct Node {
    double place, weight;
};
constexpr std::array<Node, 8> gaussLegendre{{{0.019855071751231884, 0.050614268145188130},
                                             {0.101666761293186630, 0.111190517226687240},
                                             {0.237233795041835510, 0.156853322938943640},
                                             {0.408282678752175100, 0.181341891689180990},
                                             {0.591717321247824900, 0.181341891689180990},
                                             {0.762766204958164500, 0.156853322938943640},
                                             {0.898333238706813400, 0.111190517226687240},
                                             {0.980144928248768100, 0.050614268145188130}}};

} // namespace

double PlaneKernel::sectorPerRadian(double distanceSquared) const {
    const double scale = 1 / (radius * radius);
    const double t = height * height * scale;
    if (kernel == Kernel::Constant) return 0.5 * distanceSquared;
    if (kernel == Kernel::Epanechnikov) return distanceSquared * (0.5 * (1 - t) - 0.25 * distanceSquared * scale);
    return 0.5 * radius * radius * (primitive(kernel, t + distanceSquared * scale) - primitive(kernel, t));
}

double PlaneKernel::triangle(const dvec2& a, const dvec2& b) const {
    const double twice = cross(a, b);
    if (kernel == Kernel::Constant) return 0.5 * twice;
    if (kernel == Kernel::Epanechnikov) {
        // The second moment of the triangle (0, a, b) about 0 is cross/12 (a·a + a·b + b·b).
        const double moment = twice / 12 * (glm::dot(a, a) + glm::dot(a, b) + glm::dot(b, b));
        return 0.5 * twice * (1 - height * height / (radius * radius)) - moment / (radius * radius);
    }
    // With ρ the distance of a point of the edge, dθ = cross(a, b)/ρ² ds.
    double sum = 0;
    for (const Node& node : gaussLegendre) {
        const dvec2 p = a + node.place * (b - a);
        const double distanceSquared = glm::dot(p, p);
        sum += node.weight * (distanceSquared > 0 ? sectorPerRadian(distanceSquared) / distanceSquared : 0);
    }
    return twice * sum;
}

double integrate(const PlaneKernel& kernel, std::span<const dvec2> polygon) {
    const double discSquared = kernel.radius * kernel.radius - kernel.height * kernel.height;
    if (!(discSquared > 0) || polygon.size() < 3) return 0;
    const double perRadian = kernel.sectorPerRadian(discSquared);
    double angle = 0; // of the parts where the disc, not the polygon, is the border
    double sum = 0;
    const auto sector = [&](const dvec2& a, const dvec2& b) { angle += std::atan2(cross(a, b), glm::dot(a, b)); };
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const dvec2& a = polygon[i];
        const dvec2& b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        const dvec2 along = b - a;
        const double lengthSquared = glm::dot(along, along);
        if (lengthSquared <= 0) continue;
        // |a + t along|² = disc² at t = middle ± half.
        const double middle = -glm::dot(a, along) / lengthSquared;
        const double offset = cross(a, along);
        const double half = std::sqrt(std::max(0.0, discSquared - offset * offset / lengthSquared) / lengthSquared);
        const double enter = std::max(0.0, middle - half);
        const double leave = std::min(1.0, middle + half);
        if (!(enter < leave)) {
            sector(a, b);
            continue;
        }
        const dvec2 p = a + enter * along;
        const dvec2 q = leave < 1 ? a + leave * along : b;
        if (enter > 0) sector(a, p);
        sum += kernel.triangle(p, q);
        if (leave < 1) sector(q, b);
    }
    return sum + angle * perRadian;
}

FlatPolygon::FlatPolygon(std::span<const dvec2> corners) : corners_(corners) {
    bool inside = true;
    nearestSquared_ = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const dvec2& a = corners[i];
        const dvec2& b = corners[i + 1 < corners.size() ? i + 1 : 0];
        const dvec2 along = b - a;
        const double turn = cross(a, b);
        area_ += 0.5 * turn;
        moment_ += turn / 12 * (glm::dot(a, a) + glm::dot(a, b) + glm::dot(b, b));
        inside = inside && turn >= 0;
        farthestSquared_ = std::max(farthestSquared_, glm::dot(a, a));
        const double lengthSquared = glm::dot(along, along);
        const double t = lengthSquared > 0 ? std::clamp(-glm::dot(a, along) / lengthSquared, 0.0, 1.0) : 0.0;
        const dvec2 nearest = a + t * along;
        nearestSquared_ = std::min(nearestSquared_, glm::dot(nearest, nearest));
    }
    if (inside) nearestSquared_ = 0;
}

double FlatPolygon::integral(const PlaneKernel& kernel) const {
    const double radiusSquared = kernel.radius * kernel.radius;
    const double heightSquared = kernel.height * kernel.height;
    const double discSquared = radiusSquared - heightSquared;
    if (!(discSquared > nearestSquared_)) return 0;
    if (farthestSquared_ <= discSquared) {
        if (kernel.kernel == Kernel::Constant) return area_;
        if (kernel.kernel == Kernel::Epanechnikov)
            return area_ * (1 - heightSquared / radiusSquared) - moment_ / radiusSquared;
    }
    return integrate(kernel, corners_);
}

} // namespace pie::gather
