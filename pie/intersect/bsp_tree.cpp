// The level's own tree, walked front to back (pi-engine, parameter BSP_tree).

#include "pie/intersect/bsp_build.h"
#include "pie/intersect/intersectors.h"
#include "pie/intersect/triangle_test.h"

#include <algorithm>
#include <cmath>

namespace pie::intersect {
namespace {

/// Triangles that a ray has met lately: one that reaches into several leaves is tested once.
class Mailbox {
public:
    Mailbox() { met_.fill(noTriangle); }
    bool add(std::uint32_t triangle) {
        std::uint32_t& slot = met_[triangle % met_.size()];
        if (slot == triangle) return false;
        slot = triangle;
        return true;
    }

private:
    std::array<std::uint32_t, 16> met_{};
};

class BspTree final : public Intersector {
public:
    BspTree(const scene::Scene& scene, const level::Tree& tree) : bsp_(buildBsp(scene, tree)) {
        corners_.reserve(scene.triangles.size());
        for (std::size_t t = 0; t < scene.triangles.size(); ++t)
            corners_.push_back({scene.corner(t, 0), scene.corner(t, 1), scene.corner(t, 2)});
    }

    void closest(std::span<const Ray> rays, std::span<Hit> hits) const override {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            hits[i] = Hit{};
            if (!usable(rays[i])) continue;
            Nearest nearest(rays[i], hits[i]);
            Mailbox mailbox;
            walk(rays[i], [&](const BspNodes::Leaf& leaf) {
                for (std::uint32_t at = leaf.begin; at < leaf.end; ++at) {
                    const std::uint32_t t = bsp_.triangles[at];
                    if (mailbox.add(t)) nearest.test(t, corners_[t]);
                }
                return nearest.limit();
            });
        }
    }

    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const override {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            blocked[i] = 0;
            if (!usable(rays[i])) continue;
            const PreparedRay ray(rays[i]);
            const float tMin = std::max(rays[i].tMin, 0.0F);
            const float tMax = rays[i].tMax;
            PreparedRay::Meeting meeting;
            Mailbox mailbox;
            walk(rays[i], [&](const BspNodes::Leaf& leaf) {
                for (std::uint32_t at = leaf.begin; at < leaf.opaqueEnd; ++at) {
                    const std::uint32_t t = bsp_.triangles[at];
                    if (mailbox.add(t) && ray.meets(corners_[t], tMin, tMax, meeting)) {
                        blocked[i] = 1;
                        return -1.0F;
                    }
                }
                return tMax;
            });
        }
    }

    [[nodiscard]] std::string_view name() const override { return "level BSP"; }
    [[nodiscard]] std::size_t bytes() const override {
        return sizeof(*this) + bsp_.nodes.capacity() * sizeof(BspNodes::Node) +
               bsp_.leaves.capacity() * sizeof(BspNodes::Leaf) + bsp_.triangles.capacity() * sizeof(std::uint32_t) +
               corners_.capacity() * sizeof(corners_[0]);
    }

private:
    struct Waiting {
        std::int32_t child = 0;
        float from = 0, to = 0;
    };

    /// Calls visit(leaf) in the order in which the ray comes to the leaves, until what visit returns, the distance that
    /// still matters, lies behind it.
    template <class Visit> void walk(const Ray& ray, const Visit& visit) const {
        // Rounding of a point's distance to a plane grows with its coordinates; and the builder kept triangles this
        // near to a plane on one side of it.
        const Vec3 size = glm::abs(ray.origin);
        const float blur = 4e-6F * (bsp_.extent + glm::max(size.x, glm::max(size.y, size.z)));
        std::array<Waiting, BspNodes::deepest + 1> stack;
        std::size_t waiting = 0;
        Waiting at{bsp_.root, std::max(ray.tMin, 0.0F), ray.tMax};
        float limit = ray.tMax;
        for (;;) {
            while (at.child >= 0) {
                const BspNodes::Node& node = bsp_.nodes[static_cast<std::size_t>(at.child)];
                const float height = glm::dot(node.normal, ray.origin) - node.distance;
                const float climb = glm::dot(node.normal, ray.direction);
                const std::int32_t near = node.children[climb < 0.0F ? 0 : 1];
                const std::int32_t far = node.children[climb < 0.0F ? 1 : 0];
                const float perClimb = 1.0F / climb;
                const float crossing = -height * perClimb;
                const float margin = std::abs(blur * perClimb);
                // Parallel, to the float: both sides of a plane it runs along, one side of any other.
                if (!std::isfinite(crossing) || !std::isfinite(margin)) {
                    if (std::abs(height) <= blur) {
                        stack[waiting++] = {node.children[1], at.from, at.to};
                        at.child = node.children[0];
                    } else {
                        at.child = node.children[height > 0.0F ? 0 : 1];
                    }
                    continue;
                }
                const float nearEnd = crossing + margin;
                const float farBegin = crossing - margin;
                if (nearEnd < at.from) {
                    at.child = far;
                } else if (farBegin > at.to) {
                    at.child = near;
                } else {
                    stack[waiting++] = {far, std::max(at.from, farBegin), at.to};
                    at = {near, at.from, std::min(at.to, nearEnd)};
                }
            }
            if (!bsp_.leaves.empty()) limit = visit(bsp_.leaves[static_cast<std::size_t>(-(at.child + 1))]);
            do {
                if (waiting == 0) return;
                at = stack[--waiting];
            } while (at.from > limit);
        }
    }

    BspNodes bsp_;
    std::vector<std::array<Vec3, 3>> corners_;
};

} // namespace

std::unique_ptr<Intersector> makeBspTree(const scene::Scene& scene, const level::Tree& tree) {
    return std::make_unique<BspTree>(scene, tree);
}

} // namespace pie::intersect
