#include "apps/pietrade/sample.h"

#include "pie/core/parallel.h"
#include "pie/sampling/directions.h"
#include "pie/sampling/hash.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <map>

namespace pietrade {
namespace {

using pie::Vec3;
using pie::scene::Mesh;
using pie::scene::Receivers;

Vec3 corner(const Mesh& mesh, std::uint32_t triangle, std::size_t i) {
    return mesh.vertices[mesh.triangles[triangle].vertices[i]].position;
}

std::optional<std::array<std::uint32_t, 3>> receiversOf(const Mesh& mesh, const Receivers& receivers,
                                                        std::uint32_t triangle) {
    std::array<std::uint32_t, 3> found{};
    for (std::size_t i = 0; i < 3; ++i) {
        found[i] = receivers.ofVertex[mesh.triangles[triangle].vertices[i]];
        if (found[i] == pie::scene::noReceiver) return std::nullopt;
    }
    return found;
}

/// Barycentric weights of the nearest point of the triangle's plane; none without area.
std::optional<glm::dvec3> weightsAt(const Mesh& mesh, std::uint32_t triangle, const glm::dvec3& p, double& height) {
    const glm::dvec3 a(corner(mesh, triangle, 0));
    const glm::dvec3 b(corner(mesh, triangle, 1));
    const glm::dvec3 c(corner(mesh, triangle, 2));
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double squared = glm::dot(n, n);
    if (!(squared > 0.0)) return std::nullopt;
    height = std::abs(glm::dot(p - a, n)) / std::sqrt(squared);
    const double u = glm::dot(glm::cross(p - a, c - a), n) / squared;
    const double v = glm::dot(glm::cross(b - a, p - a), n) / squared;
    return glm::dvec3(1 - u - v, u, v);
}

SurfacePoint pointOn(const Mesh& mesh, const Receivers& receivers, std::uint32_t triangle, const pie::Vec2& u) {
    const pie::Vec2 w = pie::sampling::uniformTriangle(u);
    const Vec3 weights(1 - w.x - w.y, w.x, w.y);
    SurfacePoint point;
    point.surface = mesh.triangles[triangle].surface;
    const auto corners = *receiversOf(mesh, receivers, triangle);
    Vec3 position(0.0F);
    Vec3 normal(0.0F);
    Vec3 centre(0.0F);
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 at = corner(mesh, triangle, i);
        position += weights[static_cast<int>(i)] * at;
        centre += at / 3.0F;
        normal += weights[static_cast<int>(i)] * receivers.points[corners[i]].normal;
    }
    point.receiver.position = position;
    point.receiver.normal = glm::length(normal) > 0.0F ? glm::normalize(normal) : receivers.points[corners[0]].normal;
    // A hand's breadth away from the border, which may be another surface's.
    constexpr float inset = 0.125F;
    const float distance = glm::length(centre - position);
    point.receiver.inset = position + (centre - position) * (distance > inset ? inset / distance : 0.0F);
    point.receiver.twoSided = receivers.points[corners[0]].twoSided;
    return point;
}

} // namespace

Sample draw(const Mesh& mesh, const Receivers& receivers, const View& view, std::size_t count, std::uint64_t seed) {
    Sample sample;
    const std::uint64_t key = pie::sampling::mix(seed ^ 0x7472616465U);
    for (std::uint64_t i = 0; i < std::min(count, view.receivers.size()); ++i)
        sample.vertices.push_back(view.receivers[pie::sampling::permuted(i, view.receivers.size(), key)]);
    std::vector<std::uint32_t> lit;
    std::vector<double> sums;
    double area = 0;
    for (const std::uint32_t t : view.triangles) {
        if (!receiversOf(mesh, receivers, t)) continue;
        const glm::dvec3 a(corner(mesh, t, 0));
        area += 0.5 * glm::length(glm::cross(glm::dvec3(corner(mesh, t, 1)) - a, glm::dvec3(corner(mesh, t, 2)) - a));
        lit.push_back(t);
        sums.push_back(area);
    }
    for (std::uint64_t i = 0; i < count && area > 0; ++i) {
        const auto random = [&](std::uint64_t n) { return pie::sampling::hash01(key + 1, 3 * i + n); };
        // One from every span of the area, so that no surface is left out by chance.
        const double wanted = (static_cast<double>(i) + double{random(0)}) / static_cast<double>(count) * area;
        const auto found = static_cast<std::size_t>(std::upper_bound(sums.begin(), sums.end(), wanted) - sums.begin());
        sample.points.push_back(pointOn(mesh, receivers, lit[std::min(found, lit.size() - 1)], {random(1), random(2)}));
    }
    return sample;
}

std::vector<std::optional<Place>> locate(const Mesh& mesh, const Receivers& receivers,
                                         const std::vector<SurfacePoint>& points) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> onSurface;
    for (const SurfacePoint& point : points) onSurface[point.surface];
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (const auto found = onSurface.find(mesh.triangles[t].surface); found != onSurface.end())
            found->second.push_back(t);
    std::vector<std::optional<Place>> places(points.size());
    pie::parallelChunks(points.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const glm::dvec3 p(points[i].receiver.position);
            double least = std::numeric_limits<double>::max();
            for (const std::uint32_t t : onSurface.at(points[i].surface)) {
                double height = 0;
                const auto weights = weightsAt(mesh, t, p, height);
                if (!weights) continue;
                // In units of length, both: how far outside the triangle, and off its plane.
                const double size = double{glm::length(corner(mesh, t, 1) - corner(mesh, t, 0))};
                const double outside = -std::min({weights->x, weights->y, weights->z, 0.0}) * size + height;
                if (outside >= least) continue;
                const auto corners = receiversOf(mesh, receivers, t);
                if (!corners) continue;
                least = outside;
                const glm::dvec3 inside = glm::max(*weights, glm::dvec3(0.0));
                places[i] = Place{*corners, Vec3(inside / (inside.x + inside.y + inside.z))};
            }
            constexpr double tolerance = 1;
            if (least > tolerance) places[i].reset();
        }
    });
    return places;
}

} // namespace pietrade
