#include "pie/core/parallel.h"
#include "pie/maps/nearest.h"
#include "pie/maps/snowball.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace pie::maps {
namespace {

using photons::Photon;

const std::vector<Vec3> corners{{0.0F, 0.0F, 0.0F}, {100.0F, 0.0F, 20.0F}, {0.0F, 100.0F, 20.0F}};

scene::Scene triangle() { return scene::makeScene(corners, std::vector<std::uint32_t>{0}, {scene::Material{}}); }

std::vector<Photon> hits(const scene::Scene& scene, std::size_t count) {
    std::mt19937 random(1);
    std::vector<Photon> photons(count);
    for (std::size_t i = 0; i < count; ++i) {
        float u = static_cast<float>(random() >> 8U) * 0x1p-24F;
        float v = static_cast<float>(random() >> 8U) * 0x1p-24F;
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        photons[i].position = scene.corner(0, 0) + u * (scene.corner(0, 1) - scene.corner(0, 0)) +
                              v * (scene.corner(0, 2) - scene.corner(0, 0));
        photons[i].flux = Rgb(1.0F, 2.0F, 3.0F);
        photons[i].bounce = static_cast<std::uint8_t>(i % 5);
        photons[i].id = static_cast<std::uint32_t>(i);
    }
    return photons;
}

TEST(Snowball, SpreadsFluxOverTheDiscWithinTheTriangle) {
    const scene::Scene scene = triangle();
    const std::vector<Photon> before = hits(scene, 2000);
    std::vector<Photon> after = before;
    constexpr unsigned size = 9;
    constexpr float radius = 10;
    snowball(after, scene, size, radius);
    ASSERT_EQ(after.size(), before.size() * size);
    double total = 0;
    double moments = 0;
    std::size_t whole = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_EQ(after[i * size].position, before[i].position) << "the first stays";
        std::size_t stayed = 0;
        double squares = 0;
        for (std::size_t j = 0; j < size; ++j) {
            const Photon& photon = after[i * size + j];
            EXPECT_EQ(photon.id, i * size + j);
            EXPECT_EQ(photon.bounce, before[i].bounce);
            const Vec3 way = photon.position - before[i].position;
            EXPECT_LE(glm::length(way), radius * 1.0001F);
            EXPECT_NEAR(glm::dot(way, scene.normals[0]), 0.0F, 1e-4F);
            for (int c = 0; c < 3; ++c) {
                const Vec3 edge = scene.corner(0, (c + 1) % 3) - scene.corner(0, c);
                EXPECT_GE(glm::dot(glm::cross(edge, photon.position - scene.corner(0, c)), scene.normals[0]), -0.1F);
            }
            total += static_cast<double>(photon.flux.y);
            stayed += photon.position == before[i].position ? 1 : 0;
            squares += static_cast<double>(glm::dot(way, way));
        }
        if (stayed > 1) continue; // near a border
        ++whole;
        moments += squares / (size - 1);
    }
    EXPECT_NEAR(total, 2.0 * 2000, 1e-2);
    ASSERT_GT(whole, 500U);
    // Uniform in the disc: the mean square is r²/2. Its deviation of one point is r²/√12, so 4 sigma of all are below 2
    // %.
    EXPECT_NEAR(moments / static_cast<double>(whole), 50.0, 1.0);
}

TEST(Snowball, OneOrNoRadiusChangesNothing) {
    const scene::Scene scene = triangle();
    const std::vector<Photon> before = hits(scene, 50);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const auto& [size, radius] :
         {std::pair(0U, 5.0F), std::pair(1U, 5.0F), std::pair(8U, 0.0F), std::pair(8U, -1.0F), std::pair(8U, nan)}) {
        std::vector<Photon> after = before;
        snowball(after, scene, size, radius);
        ASSERT_EQ(after.size(), before.size());
        EXPECT_EQ(after[7].position, before[7].position);
        EXPECT_EQ(after[7].flux, before[7].flux);
    }
    std::vector<Photon> none;
    snowball(none, scene, 8, 5.0F);
    EXPECT_TRUE(none.empty());
    std::vector<Photon> far = before;
    snowball(far, scene, 4, std::numeric_limits<float>::infinity());
    for (const Photon& photon : far) EXPECT_TRUE(isFinite(photon.position)) << "nothing so far lies on the triangle";
}

TEST(Snowball, SameOnAnyNumberOfThreads) {
    const scene::Scene scene = triangle();
    setThreads(1);
    std::vector<Photon> one = hits(scene, 20'000);
    snowball(one, scene, 5, 3.0F);
    setThreads(2);
    std::vector<Photon> two = hits(scene, 20'000);
    snowball(two, scene, 5, 3.0F);
    setThreads(0);
    ASSERT_EQ(one.size(), two.size());
    for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(one[i].position, two[i].position);
}

} // namespace
} // namespace pie::maps
