#include "tests/intersect/rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace pie::test {

using intersect::Hit;
using intersect::Ray;

scene::Material material(scene::Interaction interaction) {
    scene::Material made;
    made.interaction = interaction;
    return made;
}

scene::Scene sceneOf(const std::vector<Vec3>& corners, const std::vector<std::uint32_t>& materials,
                     const std::vector<scene::Material>& kinds) {
    return scene::makeScene(corners, materials, kinds);
}

std::vector<Vec3> boxCorners(const Vec3& lower, const Vec3& upper) {
    const auto at = [&](int i) {
        return Vec3((i & 1) != 0 ? upper.x : lower.x, (i & 2) != 0 ? upper.y : lower.y,
                    (i & 4) != 0 ? upper.z : lower.z);
    };
    std::vector<Vec3> corners;
    for (const auto& quad : {std::array{0, 1, 3, 2}, std::array{4, 6, 7, 5}, std::array{0, 2, 6, 4},
                             std::array{1, 5, 7, 3}, std::array{0, 4, 5, 1}, std::array{2, 3, 7, 6}})
        for (const int corner : {0, 1, 2, 0, 2, 3}) corners.push_back(at(quad[static_cast<std::size_t>(corner)]));
    return corners;
}

Furnished furnishedRoom() {
    Furnished made;
    std::vector<Vec3> corners = boxCorners(Vec3(-256, -192, 0), Vec3(256, 192, 160));
    const auto add = [&](const Vec3& lower, const Vec3& upper) {
        const std::vector<Vec3> box = boxCorners(lower, upper);
        corners.insert(corners.end(), box.begin(), box.end());
    };
    // Off the walls by a little: nothing overlaps.
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y) add(Vec3(150 * x - 16, 100 * y - 16, 3), Vec3(150 * x + 16, 100 * y + 16, 150));
    made.scene = sceneOf(corners);
    const auto plane = [&](const Vec3& normal, float distance, std::int32_t front, std::int32_t back) {
        level::Tree::Node& node = made.tree.nodes.emplace_back();
        node.plane = static_cast<std::uint32_t>(made.tree.planes.size());
        node.children = {front, back};
        made.tree.planes.push_back({normal, distance});
    };
    plane({1, 0, 0}, 16, 1, 2);
    plane({0, 1, 0}, -16, 3, -2);
    plane({-1, 0, 0}, 16, -3, 4);
    plane({0, 0, 1}, 3, -4, -5);
    plane({0, std::sqrt(0.5F), std::sqrt(0.5F)}, 40, -6, -7);
    made.tree.leaves.resize(7);
    return made;
}

Vec3 randomDirection(std::mt19937& random) {
    std::normal_distribution<float> normal;
    for (;;) {
        const Vec3 direction(normal(random), normal(random), normal(random));
        const float length = glm::length(direction);
        if (length > 1e-3F) return direction / length;
    }
}

namespace {

Vec3 randomPoint(const scene::Scene& scene, std::mt19937& random) {
    std::uniform_real_distribution<float> share(0.0F, 1.0F);
    return scene.bounds.lower + scene.bounds.size() * Vec3(share(random), share(random), share(random));
}

} // namespace

std::vector<Ray> randomRays(const scene::Scene& scene, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Ray> rays(count);
    for (Ray& ray : rays) {
        ray.origin = randomPoint(scene, random);
        ray.direction = randomDirection(random);
    }
    return rays;
}

std::vector<Ray> coherentRays(const scene::Scene& scene, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> spread(-0.1F, 0.1F);
    std::vector<Ray> rays(count);
    Vec3 origin(0.0F);
    Vec3 axis(0.0F);
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 16 == 0) {
            origin = randomPoint(scene, random);
            axis = randomDirection(random);
        }
        rays[i].origin = origin;
        rays[i].direction = glm::normalize(axis + Vec3(spread(random), spread(random), spread(random)));
    }
    return rays;
}

std::vector<Hit> closest(const intersect::Intersector& intersector, std::span<const Ray> rays) {
    std::vector<Hit> hits(rays.size());
    intersector.closest(rays, hits);
    return hits;
}

std::vector<std::uint8_t> occluded(const intersect::Intersector& intersector, std::span<const Ray> rays) {
    std::vector<std::uint8_t> blocked(rays.size(), 7);
    intersector.occluded(rays, blocked);
    return blocked;
}

std::string Agreement::text() const {
    return fmt::format("{} rays: {} same, {} ties, {} on edges, {} wrong", rays, same, ties, edges, wrong);
}

Agreement compare(std::span<const Hit> a, std::span<const Hit> b) {
    Agreement agreement;
    agreement.rays = a.size();
    const auto onEdge = [](const Hit& hit) {
        return hit.found() && std::min({hit.u, hit.v, 1.0F - hit.u - hit.v}) < 1e-4F;
    };
    for (std::size_t i = 0; i < a.size(); ++i) {
        const bool near = a[i].found() && b[i].found() &&
                          std::abs(a[i].t - b[i].t) <= 1e-4F * std::max(1.0F, std::max(a[i].t, b[i].t));
        if (a[i].triangle == b[i].triangle && (near || !a[i].found()))
            ++agreement.same;
        else if (near)
            ++agreement.ties;
        else if (onEdge(a[i]) || onEdge(b[i]))
            ++agreement.edges;
        else
            ++agreement.wrong;
    }
    return agreement;
}

} // namespace pie::test
