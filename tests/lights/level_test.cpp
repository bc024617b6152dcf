// Lights of the shipped levels.

#include "pie/lights/import.h"
#include "pie/lights/light_set.h"
#include "tests/support/game_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <set>

namespace pie::lights {
namespace {

struct Shipped {
    std::string name;
    ImportedLights found;
    std::size_t emissiveFaces = 0, sunKeys = 0, skyTriangles = 0, skyGroups = 0;
    Rgb power{0.0F};
};

const std::vector<Shipped>& shippedLevels() {
    static const std::vector<Shipped> all = [] {
        std::vector<Shipped> list;
        for (const std::string& name : test::GameData::instance().levels) {
            const auto level = level::loadLevel(level::Location{test::GameData::instance().files, name});
            if (!level) {
                ADD_FAILURE() << level.error().message();
                continue;
            }
            const auto scene = std::make_shared<scene::Scene>(scene::makeScene(*level));
            Shipped shipped;
            shipped.name = name;
            shipped.found = importLights(*level, *scene);
            std::set<std::uint32_t> used;
            for (const auto& surface : level->surfaces) {
                const auto& shader = level->shaders[surface.shader];
                used.insert(surface.shader);
                if (shader.light.surfaceLight > 0.0F && !shader.parms.sky && surface.indexCount > 0)
                    ++shipped.emissiveFaces;
            }
            for (const std::uint32_t shader : used) shipped.sunKeys += level->shaders[shader].light.suns.size();
            const LightSet set(shipped.found.lights, scene);
            shipped.skyTriangles = set.portals().triangles.size();
            shipped.skyGroups = set.portals().groups.size();
            shipped.power = set.totalPower();
            list.push_back(std::move(shipped));
        }
        return list;
    }();
    return all;
}

TEST(ShippedLights, EveryLevelHasLight) {
    PIE_NEED_GAME_DATA();
    std::size_t emissive = 0;
    std::size_t sunny = 0;
    std::size_t fallbacks = 0;
    std::vector<std::size_t> areas;
    for (const Shipped& level : shippedLevels()) {
        std::cout << level.name << ": " << level.found.summary() << "; " << level.skyTriangles << " sky triangles in "
                  << level.skyGroups << " orientations\n";
        for (const std::string& warning : level.found.warnings) std::cout << "    " << warning << '\n';
        EXPECT_FALSE(level.found.lights.empty()) << level.name;
        EXPECT_GT(meanChannel(level.power), 0.0F) << level.name;
        EXPECT_TRUE(std::isfinite(level.power.x + level.power.y + level.power.z)) << level.name;
        emissive += level.emissiveFaces > 0 ? 1 : 0;
        sunny += level.sunKeys > 0 ? 1 : 0;
        fallbacks += level.found.fallback ? 1 : 0;
        EXPECT_EQ(level.found.fallback, !level.found.warnings.empty() && level.found.sources == "fallback")
            << level.name;
        areas.push_back(level.found.areas);
    }
    std::sort(areas.begin(), areas.end());
    const auto quantile = [&](double q) {
        return areas.at(static_cast<std::size_t>(q * static_cast<double>(areas.size() - 1)));
    };
    std::cout << emissive << " levels with emissive faces, " << sunny << " with a sun, " << fallbacks
              << " with the fallback; area lights: median " << quantile(0.5) << ", 90 % " << quantile(0.9) << ", most "
              << areas.back() << '\n';
    if (shippedLevels().size() != 85) GTEST_SKIP() << "counts are those of all 85 levels; " << test::GameData::missing;
    EXPECT_EQ(emissive, 78U);
    EXPECT_EQ(sunny, 74U);
}

/// The area lights of a face have its area: joining triangles to polygons loses and doubles nothing.
TEST(ShippedLights, PolygonsKeepTheAreaOfTheirFaces) {
    PIE_NEED_GAME_DATA();
    const auto& data = test::GameData::instance();
    std::size_t checked = 0;
    for (std::size_t i = 0; i < data.levels.size(); i += 8) {
        const auto level = level::loadLevel(level::Location{data.files, data.levels[i]}, {.images = false});
        ASSERT_TRUE(level) << level.error().message();
        const ImportedLights found = importLights(*level, scene::makeScene(*level), {.backsplash = false});
        std::map<std::uint32_t, double> areaOf;
        for (const Light& light : found.lights)
            if (const auto* area = std::get_if<AreaLight>(&light)) areaOf[area->surface] += area->area;
        for (const auto& [number, area] : areaOf) {
            const auto& surface = level->surfaces[number];
            double expected = 0.0;
            for (std::uint32_t k = 0; k + 2 < surface.indexCount; k += 3) {
                std::array<glm::dvec3, 3> p;
                for (std::uint32_t c = 0; c < 3; ++c)
                    p[c] = glm::dvec3(level->vertices[level->indices[surface.firstIndex + k + c]].position);
                expected += 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
            }
            EXPECT_NEAR(area, expected, 1e-4 * expected + 1e-3) << data.levels[i] << " surface " << number;
            ++checked;
        }
    }
    EXPECT_GT(checked, 100U);
}

} // namespace
} // namespace pie::lights
