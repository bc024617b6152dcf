// Every ray against every triangle: slow, and hard to get wrong. The judge of the other two.

#include "pie/intersect/intersectors.h"
#include "pie/intersect/triangle_test.h"

namespace pie::intersect {
namespace {

class BruteForce final : public Intersector {
public:
    explicit BruteForce(const scene::Scene& scene) : scene_(scene) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits) const override {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            hits[i] = Hit{};
            if (!usable(rays[i])) continue;
            Nearest nearest(rays[i], hits[i]);
            for (std::size_t t = 0; t < scene_.triangles.size(); ++t)
                nearest.test(static_cast<std::uint32_t>(t), corners(t));
        }
    }

    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const override {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            blocked[i] = 0;
            if (!usable(rays[i])) continue;
            const PreparedRay ray(rays[i]);
            const float tMin = rays[i].tMin > 0.0F ? rays[i].tMin : 0.0F;
            PreparedRay::Meeting meeting;
            for (std::size_t t = 0; t < scene_.triangles.size() && blocked[i] == 0; ++t)
                if (isOpaque(scene_, t) && ray.meets(corners(t), tMin, rays[i].tMax, meeting)) blocked[i] = 1;
        }
    }

    [[nodiscard]] std::string_view name() const override { return "brute force"; }
    [[nodiscard]] std::size_t bytes() const override { return sizeof(*this); }

private:
    [[nodiscard]] std::array<Vec3, 3> corners(std::size_t t) const {
        return {scene_.corner(t, 0), scene_.corner(t, 1), scene_.corner(t, 2)};
    }

    const scene::Scene& scene_;
};

} // namespace

std::unique_ptr<Intersector> makeBruteForce(const scene::Scene& scene) { return std::make_unique<BruteForce>(scene); }

} // namespace pie::intersect
