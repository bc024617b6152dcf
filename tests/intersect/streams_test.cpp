// The two ways that Embree's kind finds what is nearest: streams, and Embree itself where the processor has no AVX2.

#include "pie/intersect/intersectors.h"
#include "pie/intersect/wide_tree.h"
#include "tests/intersect/rays.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace pie::test {
namespace {

using intersect::Hit;
using intersect::Kind;
using intersect::makeEmbree;
using intersect::makeIntersector;
using intersect::Ray;
using scene::Scene;

/// Long and short triangles through one another, some of them twice, and far from the origin.
Scene soup() {
    std::mt19937 random(51);
    std::uniform_real_distribution<float> place(-500, 500);
    std::vector<Vec3> corners;
    for (int i = 0; i < 700; ++i) {
        const Vec3 centre = Vec3(3000, 0, 0) + Vec3(place(random), place(random), place(random));
        for (int k = 0; k < 3; ++k) corners.push_back(centre + (i % 9 == 0 ? 400.0F : 50.0F) * randomDirection(random));
    }
    corners.insert(corners.end(), corners.begin(), corners.begin() + 300);
    return sceneOf(corners);
}

std::size_t differences(const std::vector<Hit>& a, const std::vector<Hit>& b) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        count += a[i].triangle != b[i].triangle || a[i].t != b[i].t || a[i].u != b[i].u || a[i].v != b[i].v ? 1 : 0;
    return count;
}

std::vector<Ray> bounded(std::vector<Ray> rays) {
    std::mt19937 random(52);
    std::uniform_real_distribution<float> length(1, 300);
    for (std::size_t i = 0; i < rays.size(); i += 3) {
        rays[i].tMin = 0.5F * length(random);
        rays[i].tMax = rays[i].tMin + length(random);
    }
    // Along planes of the room and axes: infinite slopes, and boxes without thickness met edge on.
    for (std::size_t i = 1; i < rays.size(); i += 50) {
        const int axis = static_cast<int>(i / 50 % 3);
        rays[i].direction = Vec3(0.0F);
        rays[i].direction[axis] = i % 100 == 1 ? 1.0F : -1.0F;
        rays[i].origin = glm::round(rays[i].origin / 8.0F) * 8.0F;
    }
    return rays;
}

TEST(Streams, AnswersAreThoseOfBruteForceToTheBit) {
    if (!intersect::WideTree::supported()) GTEST_SKIP() << "no AVX2";
    for (const Scene& scene : {furnishedRoom().scene, soup()}) {
        const auto judge = makeIntersector(Kind::BruteForce, scene, {});
        const auto streams = makeEmbree(scene, true);
        for (const std::vector<Ray>& rays :
             {bounded(randomRays(scene, 20'000, 53)), bounded(coherentRays(scene, 10'000, 54))})
            EXPECT_EQ(differences(closest(*judge, rays), closest(*streams, rays)), 0U);
    }
}

/// Nothing of it changes with what else is asked.
TEST(Streams, AnswersDoNotDependOnTheCompany) {
    const Scene scene = soup();
    const auto streams = makeEmbree(scene, true);
    const std::vector<Ray> rays = bounded(randomRays(scene, 10'000, 55));
    const std::vector<Hit> together = closest(*streams, rays);
    for (const std::size_t batch : {std::size_t{1}, std::size_t{7}, std::size_t{1000}}) {
        std::vector<Hit> hits(rays.size());
        for (std::size_t i = 0; i < rays.size(); i += batch) {
            const std::size_t count = std::min(batch, rays.size() - i);
            streams->closest(std::span(rays).subspan(i, count), std::span(hits).subspan(i, count));
        }
        EXPECT_EQ(differences(together, hits), 0U) << batch;
    }
}

TEST(Streams, EmbreeAloneAgrees) {
    const Furnished room = furnishedRoom();
    const auto judge = makeIntersector(Kind::BruteForce, room.scene, {});
    const auto alone = makeEmbree(room.scene, false);
    for (const std::vector<Ray>& rays : {randomRays(room.scene, 30'000, 56), coherentRays(room.scene, 20'000, 57)}) {
        const std::vector<Hit> hits = closest(*alone, rays);
        const Agreement agreement = compare(closest(*judge, rays), hits);
        EXPECT_EQ(agreement.wrong + agreement.edges, 0U) << agreement.text();
        EXPECT_LE(agreement.ties, 2U) << agreement.text();
        std::vector<Hit> singly;
        for (const Ray& ray : rays) singly.push_back(closest(*alone, {&ray, 1})[0]);
        EXPECT_EQ(differences(hits, singly), 0U);
    }
}

} // namespace
} // namespace pie::test
