#include "apps/pieprobe/surface.h"

#include "pie/core/parallel.h"
#include "pie/lights/light.h"

#include <fmt/format.h>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace pieprobe {
namespace {

using glm::dvec3;
using pie::Vec3;
using pie::scene::Scene;

/// Cosine between a point's normal and its surface's: vertices of curves have normals of their own.
constexpr double smallestFacing = 0.3;
constexpr int probes = 16;

/// Nearest point of a triangle.
dvec3 nearestOn(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& p) {
    const dvec3 normal = glm::cross(b - a, c - a);
    const std::array<dvec3, 3> corners{a, b, c};
    bool inside = true;
    dvec3 best = a;
    double least = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < 3; ++i) {
        const dvec3& from = corners[i];
        const dvec3 along = corners[(i + 1) % 3] - from;
        if (glm::dot(glm::cross(normal, along), p - from) < 0.0) inside = false;
        const double squared = glm::dot(along, along);
        const double share = squared > 0.0 ? std::clamp(glm::dot(p - from, along) / squared, 0.0, 1.0) : 0.0;
        const dvec3 q = from + share * along;
        const double distance = glm::dot(p - q, p - q);
        if (distance < least) {
            least = distance;
            best = q;
        }
    }
    const double squared = glm::dot(normal, normal);
    return inside && squared > 0.0 ? p - normal * (glm::dot(p - a, normal) / squared) : best;
}

class Finder {
public:
    Finder(const Scene& scene, double tolerance, double inset) : scene_(scene), tolerance_(tolerance), inset_(inset) {
        for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
            pie::Box box;
            for (int i = 0; i < 3; ++i) box.extend(scene.corner(t, i));
            boxes_.push_back(box);
        }
    }

    [[nodiscard]] Placed operator()(const Point& point) const {
        const auto finite = [](const Vec3& v) { return std::isfinite(v.x + v.y + v.z); };
        if (!finite(point.position) || !finite(point.normal)) return {Status::NotFinite, "is not finite", {}};
        const float length = glm::length(point.normal);
        if (!(length > 1e-6F)) return {Status::BadNormal, "the normal is zero", {}};
        const Vec3 normal = point.normal / length;
        const auto near = within(point.position, tolerance_ + 2 * inset_);
        const dvec3 p(point.position);
        std::uint32_t best = none;
        double least = std::numeric_limits<double>::max();
        double turned = 1;
        bool any = false;
        for (const std::uint32_t t : near) {
            const double distance = glm::length(nearest(t, p) - p);
            if (distance > tolerance_) continue;
            const auto cosine = static_cast<double>(glm::dot(scene_.normals[t], normal));
            const double facing = scene_.material(t).twoSided ? std::abs(cosine) : cosine;
            turned = any ? std::max(turned, facing) : facing;
            any = true;
            // Of surfaces that meet at the point, the one that faces it most.
            const double cost = distance - 1e-3 * tolerance_ * facing;
            if (facing < smallestFacing || cost >= least) continue;
            least = cost;
            best = t;
        }
        if (!any) return {Status::OffSurface, fmt::format("no surface within {:g} units", tolerance_), {}};
        if (best == none)
            return {Status::BadNormal,
                    fmt::format("no surface there faces the normal (the cosine is {:.2f} at most)", turned),
                    {}};
        return {Status::Ok, {}, receiver(point, normal, best, near)};
    }

private:
    static constexpr std::uint32_t none = 0xffffffffU;

    [[nodiscard]] dvec3 nearest(std::uint32_t t, const dvec3& p) const {
        return nearestOn(dvec3(scene_.corner(t, 0)), dvec3(scene_.corner(t, 1)), dvec3(scene_.corner(t, 2)), p);
    }
    [[nodiscard]] std::vector<std::uint32_t> within(const Vec3& p, double reach) const {
        std::vector<std::uint32_t> result;
        const auto r = static_cast<float>(reach * 1.001);
        for (std::uint32_t t = 0; t < boxes_.size(); ++t) {
            const pie::Box& box = boxes_[t];
            if (glm::any(glm::lessThan(p + r, box.lower)) || glm::any(glm::greaterThan(p - r, box.upper))) continue;
            if (scene_.normals[t] == Vec3(0.0F)) continue;
            if (scene_.material(t).interaction != pie::scene::Interaction::Sky) result.push_back(t);
        }
        return result;
    }

    [[nodiscard]] pie::scene::Receiver receiver(const Point& point, const Vec3& normal, std::uint32_t triangle,
                                                const std::vector<std::uint32_t>& near) const {
        const bool twoSided = scene_.material(triangle).twoSided;
        dvec3 up(scene_.normals[triangle]);
        if (glm::dot(up, dvec3(normal)) < 0.0) up = -up;
        std::vector<std::uint32_t> same; // the surface around it, bent at most a little
        for (const std::uint32_t t : near)
            if (std::abs(glm::dot(dvec3(scene_.normals[t]), up)) > 0.9 &&
                (twoSided || glm::dot(dvec3(scene_.normals[t]), up) > 0.0))
                same.push_back(t);
        const dvec3 foot = nearest(triangle, dvec3(point.position));
        const double height = std::max(0.0, glm::dot(dvec3(point.position) - foot, up));
        pie::scene::Receiver result;
        result.position = height > 0.0 ? point.position : Vec3(foot);
        result.normal = normal;
        result.inset = Vec3(inward(foot, up, same) + height * up);
        result.twoSided = twoSided;
        return result;
    }

    [[nodiscard]] bool onSurface(const dvec3& p, const std::vector<std::uint32_t>& surface, double reach) const {
        return std::any_of(surface.begin(), surface.end(),
                           [&](std::uint32_t t) { return glm::length(nearest(t, p) - p) <= reach; });
    }

    /// `foot`, or a point beside it away from the border of its surface.
    [[nodiscard]] dvec3 inward(const dvec3& foot, const dvec3& up, const std::vector<std::uint32_t>& surface) const {
        const pie::Frame frame{Vec3(up)};
        constexpr int halvings = 7; // to less than a hundredth
        double r = inset_;
        for (int halving = 0; halving < halvings; ++halving, r *= 0.5) {
            dvec3 sum(0.0);
            int found = 0;
            for (int i = 0; i < probes; ++i) {
                const double angle = 2 * std::numbers::pi * (i + 0.5) / probes;
                const dvec3 way = std::cos(angle) * dvec3(frame.tangent) + std::sin(angle) * dvec3(frame.bitangent);
                if (!onSurface(foot + r * way, surface, 0.1 * r)) continue;
                sum += way;
                ++found;
            }
            if (found == probes) return foot;
            const double length = glm::length(sum);
            if (found > 0 && length > 1e-3 && onSurface(foot + r / length * sum, surface, 0.1 * r))
                return foot + r / length * sum;
        }
        return foot;
    }

    const Scene& scene_;
    double tolerance_;
    double inset_;
    std::vector<pie::Box> boxes_;
};

} // namespace

double defaultTolerance(const Scene& scene) {
    if (scene.bounds.empty()) return 0.0;
    const double diagonal = double{glm::length(scene.bounds.size())};
    return std::max(std::min(2.0, diagonal / 512),
                    8e-6 * double{pie::lights::largestCoordinate(scene.bounds, Vec3(0.0F))});
}

double insetFor(const Scene& scene, bool reference) {
    const double diagonal = scene.bounds.empty() ? 0.0 : double{glm::length(scene.bounds.size())};
    return std::min(1.0, diagonal / 1024) * (reference ? 0.125 : 1.0);
}

std::vector<Placed> place(const Scene& scene, const std::vector<Point>& points, double tolerance, double inset) {
    const Finder find(scene, tolerance, inset);
    std::vector<Placed> placed(points.size());
    pie::parallelChunks(points.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) placed[i] = find(points[i]);
    });
    return placed;
}

} // namespace pieprobe
