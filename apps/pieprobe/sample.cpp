#include "apps/pieprobe/sample.h"

#include "pie/sampling/directions.h"
#include "pie/sampling/hash.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <iterator>
#include <vector>

namespace pieprobe {

std::string randomPoints(const pie::scene::Scene& scene, std::size_t count, std::uint64_t seed) {
    std::vector<double> sums;
    double area = 0;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
        const glm::dvec3 a(scene.corner(t, 0));
        if (scene.material(t).interaction != pie::scene::Interaction::Sky)
            area +=
                0.5 * glm::length(glm::cross(glm::dvec3(scene.corner(t, 1)) - a, glm::dvec3(scene.corner(t, 2)) - a));
        sums.push_back(area);
    }
    fmt::memory_buffer text;
    const auto to = std::back_inserter(text);
    fmt::format_to(to, "x,y,z,nx,ny,nz\n");
    for (std::uint64_t i = 0; i < count && area > 0; ++i) {
        const auto random = [&](std::uint64_t number) {
            return pie::sampling::hash01(seed ^ 0x706f696e7473U, 3 * i + number);
        };
        const double wanted = (static_cast<double>(i) + double{random(0)}) / static_cast<double>(count) * area;
        const auto found = std::upper_bound(sums.begin(), sums.end(), wanted);
        const auto t = static_cast<std::uint32_t>(
            std::min<std::size_t>(static_cast<std::size_t>(found - sums.begin()), sums.size() - 1));
        const pie::Vec2 w = pie::sampling::uniformTriangle({random(1), random(2)});
        const pie::Vec3 a = scene.corner(t, 0);
        const pie::Vec3 p = a + w.x * (scene.corner(t, 1) - a) + w.y * (scene.corner(t, 2) - a);
        const pie::Vec3& n = scene.normals[t];
        fmt::format_to(to, "{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}\n", p.x, p.y, p.z, n.x, n.y, n.z);
    }
    return fmt::to_string(text);
}

} // namespace pieprobe
