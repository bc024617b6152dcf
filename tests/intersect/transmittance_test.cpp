#include "tests/intersect/rays.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pie::test {
namespace {

using intersect::Hit;
using intersect::Kind;
using intersect::Ray;
using scene::Interaction;
using scene::Scene;

/// Counts what is asked of another intersector.
class Counting final : public intersect::Intersector {
public:
    explicit Counting(const Scene& scene) : inner_(makeIntersector(Kind::Embree, scene, {})) {}
    void closest(std::span<const Ray> rays, std::span<Hit> hits) const override {
        closestRays += rays.size();
        inner_->closest(rays, hits);
    }
    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const override {
        occlusionRays += rays.size();
        inner_->occluded(rays, blocked);
    }
    [[nodiscard]] std::string_view name() const override { return "counting"; }
    [[nodiscard]] std::size_t bytes() const override { return 0; }

    mutable std::size_t closestRays = 0, occlusionRays = 0;

private:
    std::unique_ptr<intersect::Intersector> inner_;
};

scene::Material filter(const Rgba8& texel, bool alphaOnly) {
    auto image = std::make_shared<level::Image>();
    image->width = image->height = 1;
    image->pixels = {texel};
    scene::Material made = material(Interaction::Filter);
    made.filter = image;
    made.alphaOnly = alphaOnly;
    return made;
}

/// Materials: 0 opaque, 1 half-transparent, 2 stained glass, 3 sky.
const std::vector<scene::Material>& kinds() {
    static const std::vector<scene::Material> all{material(Interaction::Opaque), filter({9, 9, 9, 102}, true),
                                                  filter({255, 51, 0, 255}, false), material(Interaction::Sky)};
    return all;
}

/// Square sheets across the z axis, one per entry, at z = 1, 2, 3 …
Scene sheets(const std::vector<std::uint32_t>& materials, float distance = 1) {
    std::vector<Vec3> corners;
    std::vector<std::uint32_t> ofTriangle;
    for (std::size_t i = 0; i < materials.size(); ++i) {
        const float z = distance * static_cast<float>(i + 1);
        corners.insert(corners.end(), {{-8, -8, z}, {8, -8, z}, {8, 8, z}, {-8, -8, z}, {8, 8, z}, {-8, 8, z}});
        ofTriangle.insert(ofTriangle.end(), {materials[i], materials[i]});
    }
    return sceneOf(corners, ofTriangle, kinds());
}

Rgb through(const Scene& scene, const Ray& ray, Kind kind = Kind::Embree) {
    Rgb result(-1.0F);
    transmittance(*makeIntersector(kind, scene, {}), scene, {&ray, 1}, {&result, 1});
    return result;
}

const Ray along{{1, 2, 0}, 0, {0, 0, 1}};

TEST(Transmittance, OpaqueStopsAndSkyDoesNot) {
    EXPECT_EQ(through(sheets({0}), along), Rgb(0.0F));
    EXPECT_EQ(through(sheets({3, 3}), along), Rgb(1.0F));
    EXPECT_EQ(through(sheets({1, 0}), along), Rgb(0.0F));
    EXPECT_EQ(through(sheets({}), along), Rgb(1.0F));
}

TEST(Transmittance, LayersMultiply) {
    for (const Kind kind : allKinds) {
        EXPECT_NEAR(through(sheets({1}), along, kind).x, 0.6F, 1e-6F);
        EXPECT_NEAR(through(sheets({1, 3, 1, 1}), along, kind).y, 0.216F, 1e-6F);
        const Rgb stained = through(sheets({2, 1}), along, kind);
        EXPECT_NEAR(stained.x, 0.6F, 1e-6F);
        EXPECT_NEAR(stained.y, 0.12F, 1e-6F);
        EXPECT_EQ(stained.z, 0.0F);
    }
}

TEST(Transmittance, MindsTheLimitsOfTheRay) {
    Ray ray = along;
    ray.tMin = 1.5F;
    ray.tMax = 2.5F;
    EXPECT_NEAR(through(sheets({1, 1, 1}), ray).x, 0.6F, 1e-6F);
}

TEST(Transmittance, ThinAndFarSheetsCountOnceEach) {
    EXPECT_NEAR(through(sheets({1, 1}, 0.25F), along).x, 0.36F, 1e-6F);
    Ray far = along;
    far.origin = Vec3(1, 2, -3000);
    EXPECT_NEAR(through(sheets({1, 1, 1, 1}), far).x, 0.1296F, 1e-6F);
}

TEST(Transmittance, ManyLayersEnd) {
    EXPECT_NEAR(through(sheets(std::vector<std::uint32_t>(20, 1)), along).x, std::pow(0.6F, 20), 1e-9);
    EXPECT_EQ(through(sheets(std::vector<std::uint32_t>(300, 1)), along), Rgb(0.0F));
}

TEST(Transmittance, ABlockOfRaysIsARayAtATime) {
    const Scene scene = sheets({1, 2, 3, 1});
    const auto intersector = makeIntersector(Kind::Embree, scene, {});
    std::vector<Ray> rays(1000, along);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        rays[i].origin.x = static_cast<float>(i) * 0.02F - 10;
        rays[i].tMax = 0.005F * static_cast<float>(i);
    }
    std::vector<Rgb> all(rays.size());
    transmittance(*intersector, scene, rays, all);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        Rgb one(-1.0F);
        transmittance(*intersector, scene, {&rays[i], 1}, {&one, 1});
        EXPECT_EQ(all[i], one) << i;
    }
}

TEST(Transmittance, CostsOneOcclusionRayWithoutFilters) {
    const Scene scene = sheets({3, 0});
    const Counting counting(scene);
    std::vector<Ray> rays(700, along);
    std::vector<Rgb> results(rays.size());
    transmittance(counting, scene, rays, results);
    EXPECT_EQ(counting.occlusionRays, rays.size());
    EXPECT_EQ(counting.closestRays, 0U);
}

TEST(Transmittance, BlockedRaysAreNotTracedFurther) {
    const Scene scene = sheets({1, 1, 0});
    const Counting counting(scene);
    Rgb result(-1.0F);
    transmittance(counting, scene, {&along, 1}, {&result, 1});
    EXPECT_EQ(result, Rgb(0.0F));
    EXPECT_EQ(counting.closestRays, 0U);
}

} // namespace
} // namespace pie::test
