// Several maps answer what one answers when it is asked for the same photons, whatever the receiver.

#include "pie/core/parallel.h"
#include "pie/maps/exact.h"
#include "pie/maps/split_tree.h"
#include "tests/gather/scenes.h"
#include "tests/maps/trees.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pie::maps {
namespace {

using gather::test::direction;
using gather::test::receiverAt;
using gather::test::unit;
using gather::test::unit3;
using photons::Photon;

constexpr float size = 100;
constexpr SplitBy splits[] = {SplitBy::None, SplitBy::Normal, SplitBy::Cell, SplitBy::Both};

/// Small triangles in all directions; every third is two-sided, half lie along the axes, or all of them.
struct Soup {
    std::shared_ptr<const scene::Scene> scene;
    level::Tree tree;
    std::vector<Photon> photons;

    explicit Soup(std::uint32_t seed, std::size_t triangles = 300, std::size_t perTriangle = 12,
                  bool straight = false) {
        std::mt19937 random(seed);
        gather::test::SceneBuilder builder;
        builder.grey(0.5F);
        scene::Material cloth;
        cloth.twoSided = true;
        builder.material(cloth);
        for (std::size_t t = 0; t < triangles; ++t) {
            const Vec3 a = size * unit3(random);
            Vec3 u = 10.0F * direction(random);
            Vec3 v = 10.0F * direction(random);
            if (straight || t % 2 == 0) {
                const int axis = static_cast<int>(random() % 3);
                u = Vec3(0.0F);
                v = Vec3(0.0F);
                u[axis] = random() % 2 == 0 ? 10.0F : -10.0F;
                v[(axis + 1) % 3] = 10.0F;
            }
            builder.triangle(a, a + u, a + v, t % 3 == 0 ? 1 : 0);
        }
        scene = builder.make();
        tree = test::randomTree(150, size, random);
        for (std::uint32_t t = 0; t < scene->triangles.size(); ++t)
            for (std::size_t i = 0; i < perTriangle; ++i) {
                Photon& photon = photons.emplace_back();
                const float u = unit(random);
                const float v = (1.0F - u) * unit(random);
                photon.position = scene->corner(t, 0) + u * (scene->corner(t, 1) - scene->corner(t, 0)) +
                                  v * (scene->corner(t, 2) - scene->corner(t, 0));
                photon.direction = direction(random);
                photon.triangle = t;
                photon.id = static_cast<std::uint32_t>(photons.size());
            }
        photons.push_back(photons.back());
        photons.back().position.x = std::numeric_limits<float>::quiet_NaN();
    }
    [[nodiscard]] Vec3 litNormal(const Photon& photon) const {
        const Vec3& normal = scene->normals[photon.triangle];
        return scene->material(photon.triangle).twoSided && glm::dot(photon.direction, normal) > 0.0F ? -normal
                                                                                                      : normal;
    }
    /// With normals of triangles, along the axes, at their 45 degrees, on borders between classes, and anywhere.
    [[nodiscard]] scene::Receiver receiver(std::mt19937& random) const {
        const Photon& near = photons[random() % (photons.size() - 1)];
        Vec3 normal = direction(random);
        switch (random() % 5) {
        case 0: normal = litNormal(near); break;
        case 1: normal = Vec3(0.0F, random() % 2 == 0 ? 1.0F : -1.0F, 0.0F); break;
        case 2: normal = glm::normalize(Vec3(1.0F, static_cast<float>(random() % 3) / 3.0F, 0.0F)); break;
        case 3: normal = glm::normalize(litNormal(near) + Frame(litNormal(near)).tangent); break;
        default: break;
        }
        return receiverAt(near.position + (random() % 2 == 0 ? Vec3(0.0F) : unit3(random)), normal, random() % 4 == 0);
    }
};

template <class Map, class Accept>
std::vector<Neighbour> nearest(const Map& map, const scene::Receiver& at, std::size_t k, float radius, const Slab& slab,
                               Accept accept) {
    NearestQueue queue;
    map.nearest(at.position, k, radius, slab, accept, queue);
    std::vector<Neighbour> found(queue.found().begin(), queue.found().end());
    std::sort(found.begin(), found.end());
    return found;
}

TEST(SplitTree, FindsThePhotonsOfTheMapsThatAreSeen) {
    for (const std::uint32_t seed : {1U, 2U, 3U}) {
        const Soup soup(seed);
        ExactMap exact;
        exact.build(soup.photons);
        for (const SplitBy by : splits) {
            const auto partition = std::make_shared<const Partition>(*soup.scene, soup.tree, by);
            SplitTree tree(partition);
            tree.build(soup.photons);
            EXPECT_EQ(tree.bounds().lower, exact.bounds().lower);
            EXPECT_EQ(tree.bounds().upper, exact.bounds().upper);
            EXPECT_GT(tree.maps(), by == SplitBy::None ? 0U : by == SplitBy::Both ? 100U : 10U);
            std::mt19937 random(seed + 100);
            for (int i = 0; i < 1500; ++i) {
                const scene::Receiver at = soup.receiver(random);
                const auto seen = partition->seenFrom(at, 0.7F);
                const std::size_t ks[] = {0, 1, 5, 50, soup.photons.size()};
                const std::size_t k = ks[random() % 5];
                const float radii[] = {0.0F, 3.0F, 20.0F, std::numeric_limits<float>::infinity(), -1.0F};
                const float radius = radii[random() % 5];
                const Slab slab{at.normal, random() % 2 == 0 ? 2.0F : std::numeric_limits<float>::infinity()};
                const auto accept = [&](const Photon& photon) {
                    const float height = glm::dot(photon.position - at.position, at.normal);
                    return std::abs(height) <= slab.halfThickness && photon.id % 7 != 0;
                };
                const auto found = nearest(tree.seen(seen), at, k, radius, slab, [&](const Photon& photon) {
                    EXPECT_TRUE(seen.holds(partition->placeOf(photon))) << "a photon of another map is visited";
                    return accept(photon);
                });
                ASSERT_EQ(found, nearest(exact, at, k, radius, slab,
                                         [&](const Photon& photon) {
                                             return seen.holds(partition->placeOf(photon)) && accept(photon);
                                         }))
                    << "split " << static_cast<int>(by) << ", k " << k << ", radius " << radius;
            }
        }
    }
}

TEST(SplitTree, NoPhotonThatFacesLikeTheReceiverIsMissed) {
    // The classes that are searched hold every photon within the angle, on borders of classes and of the angle, too;
    // and nothing else where the partition says so.
    for (const bool straight : {false, true}) {
        const Soup soup(7, 1000, 3, straight);
        const Partition partition(*soup.scene, soup.tree, SplitBy::Normal);
        std::mt19937 random(8);
        std::size_t all = 0;
        std::size_t skipped = 0;
        for (int i = 0; i < 1000; ++i) {
            const scene::Receiver at = soup.receiver(random);
            const float minCosine = random() % 2 == 0 ? 0.7F : 2.0F * unit(random) - 1.0F;
            const auto seen = partition.seenFrom(at, minCosine);
            for (std::size_t p = 0; p + 1 < soup.photons.size(); ++p) {
                const Photon& photon = soup.photons[p];
                const float cosine = glm::dot(soup.litNormal(photon), at.normal);
                const bool held = seen.holds(partition.placeOf(photon));
                const bool faces = cosine > minCosine || (at.twoSided && -cosine > minCosine);
                ASSERT_TRUE(held || !faces) << cosine;
                ASSERT_TRUE(faces || !held || !seen.allFace) << cosine;
                skipped += held ? 0U : 1U;
            }
            all += seen.allFace ? 1U : 0U;
        }
        EXPECT_GT(skipped, 1000U * soup.photons.size() / 4) << "maps that do not matter are left out";
        EXPECT_TRUE(!straight || all > 100U) << all;
    }
}

TEST(SplitTree, WallsOfARoomNeedNoLookAtNormals) {
    gather::test::SceneBuilder builder;
    builder.room(Vec3(0.0F), Vec3(size));
    const auto room = builder.make();
    const Partition partition(*room, {}, SplitBy::Both);
    EXPECT_EQ(partition.cells(), 1U);
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {1.0F, -1.0F}) {
            Vec3 normal(0.0F);
            normal[axis] = sign;
            const auto seen = partition.seenFrom(receiverAt(Vec3(0.5F * size), normal), 0.7F);
            EXPECT_EQ(std::popcount(seen.classes), 1);
            EXPECT_TRUE(seen.allFace);
            const auto both = partition.seenFrom(receiverAt(Vec3(0.5F * size), normal, true), 0.7F);
            EXPECT_EQ(std::popcount(both.classes), 2);
            EXPECT_FALSE(both.allFace) << "sides are told apart";
        }
    for (const float bad : {0.0F, std::numeric_limits<float>::quiet_NaN()}) {
        const auto none = partition.seenFrom(receiverAt(Vec3(0.5F * size), Vec3(bad)), 0.7F);
        EXPECT_EQ(none.classes, 0U);
    }
}

TEST(SplitTree, DoesNotDependOnThreads) {
    const Soup soup(4, 2000, 10);
    const auto partition = std::make_shared<const Partition>(*soup.scene, soup.tree, SplitBy::Both);
    SplitTree one(partition);
    SplitTree two(partition);
    setThreads(1);
    one.build(soup.photons);
    setThreads(2);
    two.build(soup.photons);
    setThreads(0);
    std::mt19937 random(9);
    NearestQueue a;
    NearestQueue b;
    const auto all = [](const Photon&) { return true; };
    for (int i = 0; i < 500; ++i) {
        const scene::Receiver at = soup.receiver(random);
        const auto seen = partition->seenFrom(at, 0.7F);
        one.seen(seen).nearest(at.position, 30, 30.0F, {at.normal, 5.0F}, all, a);
        two.seen(seen).nearest(at.position, 30, 30.0F, {at.normal, 5.0F}, all, b);
        // Also the order in which they are summed.
        ASSERT_TRUE(std::equal(a.found().begin(), a.found().end(), b.found().begin(), b.found().end()));
    }
}

TEST(SplitTree, HandsPhotonsBack) {
    const Soup soup(4, 20, 3);
    SplitTree tree(std::make_shared<const Partition>(*soup.scene, soup.tree, SplitBy::Both));
    tree.build(soup.photons);
    EXPECT_EQ(tree.photons().size(), soup.photons.size());
    EXPECT_EQ(tree.release().size(), soup.photons.size());
    EXPECT_EQ(tree.maps(), 0U);
    EXPECT_TRUE(tree.photons().empty());
    EXPECT_TRUE(tree.bounds().empty());
}

} // namespace
} // namespace pie::maps
