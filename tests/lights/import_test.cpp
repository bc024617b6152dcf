#include "pie/lights/import.h"
#include "tests/lights/rooms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace pie::lights {
namespace {

using level::Entity;
using level::Level;

constexpr float wattsPerIntensity = static_cast<float>(4.0 * std::numbers::pi * 7500.0);

Entity entity(std::vector<std::pair<std::string, std::string>> pairs) {
    Entity e;
    e.pairs = std::move(pairs);
    return e;
}

Level withLights(std::vector<Entity> lights) {
    Level level;
    level.lightEntities = std::move(lights);
    return level;
}

/// One surface of `triangles` (indices into `vertices`) with a shader.
void addSurface(Level& level, const std::vector<Vec3>& vertices, const std::vector<std::uint32_t>& triangles,
                const level::Shader& shader) {
    level::Surface surface;
    surface.shader = static_cast<std::uint32_t>(level.shaders.size());
    surface.firstVertex = static_cast<std::uint32_t>(level.vertices.size());
    surface.vertexCount = static_cast<std::uint32_t>(vertices.size());
    surface.firstIndex = static_cast<std::uint32_t>(level.indices.size());
    surface.indexCount = static_cast<std::uint32_t>(triangles.size());
    for (const std::uint32_t i : triangles) level.indices.push_back(surface.firstVertex + i);
    for (const Vec3& v : vertices) {
        level::Vertex vertex;
        vertex.position = v;
        level.vertices.push_back(vertex);
    }
    level.shaders.push_back(shader);
    if (level.models.empty()) level.models.emplace_back();
    level.surfaces.push_back(surface);
}

level::Shader lampShader(float surfaceLight) {
    level::Shader shader;
    shader.name = "lamp";
    shader.stages.emplace_back();
    shader.light.surfaceLight = surfaceLight;
    return shader;
}
level::Shader skyShader() {
    level::Shader shader;
    shader.name = "sky";
    shader.parms.sky = true;
    return shader;
}
const std::vector<Vec3> square{{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}};
const std::vector<std::uint32_t> twoTriangles{0, 1, 2, 0, 2, 3};

std::shared_ptr<const scene::Scene> skyRoom() {
    test::RoomBuilder room;
    const auto wall = room.material(test::opaque(Rgb(0.5F)));
    const auto open = room.material(test::sky());
    room.inside({0, 0, 0}, {100, 100, 100}, {wall, open, wall, wall, wall, wall});
    return room.build();
}

TEST(Import, PointEntity) {
    const ImportedLights found = importLights(
        withLights({entity({{"classname", "light"}, {"origin", "1 2 3"}, {"light", "200"}, {"_color", "0.5 0.25 0"}})}),
        {});
    ASSERT_EQ(found.points, 1U);
    const auto& light = std::get<PointLight>(found.lights.at(0));
    EXPECT_EQ(light.position, Vec3(1, 2, 3));
    EXPECT_NEAR(light.power.x / (200 * wattsPerIntensity), 1.0F, 1e-5F)
        << "the colour is divided by its largest component";
    EXPECT_NEAR(light.power.y / light.power.x, 0.5F, 1e-5F);
    EXPECT_EQ(light.power.z, 0.0F);
    EXPECT_EQ(light.falloff.minDistance, 16.0F);
    EXPECT_EQ(found.summary(), "1 point; from entities");
}

TEST(Import, IntensityKeys) {
    const auto watts = [](std::vector<std::pair<std::string, std::string>> keys) {
        keys.emplace_back("classname", "light");
        const ImportedLights found = importLights(withLights({entity(keys)}), {});
        return std::get<PointLight>(found.lights.at(0)).power.x / wattsPerIntensity;
    };
    EXPECT_NEAR(watts({}), 300.0F, 1e-2F);
    EXPECT_NEAR(watts({{"light", "0"}}), 300.0F, 1e-2F);
    EXPECT_NEAR(watts({{"light", "100"}, {"_light", "50"}}), 50.0F, 1e-2F);
    EXPECT_NEAR(watts({{"light", "100"}, {"scale", "2.5"}}), 250.0F, 1e-2F);
    EXPECT_NEAR(watts({{"light", "-100"}}), -100.0F, 1e-2F);
    EXPECT_NEAR(watts({{"light", "100"}, {"_samples", "8"}}), 100.0F, 1e-2F) << "8 copies of an eighth";
    EXPECT_NEAR(watts({{"light", "100"}, {"_color", "0.5 0.5 0.5"}, {"spawnflags", "32"}}), 50.0F, 1e-2F);
    EXPECT_NEAR(watts({{"light", "100"}, {"_color", "0.5 0.5 0.5"}}), 100.0F, 1e-2F);
    EXPECT_NEAR(watts({{"light", "nonsense"}}), 300.0F, 1e-2F);
}

TEST(Import, FalloffKeys) {
    const ImportedLights found = importLights(
        withLights({entity({{"classname", "light"}, {"_extradist", "40"}, {"_anglescale", "0.5"}, {"spawnflags", "2"}}),
                    entity({{"classname", "light"}, {"light", "200"}, {"fade", "2"}, {"spawnflags", "1"}})}),
        {});
    const auto& first = std::get<PointLight>(found.lights.at(0)).falloff;
    EXPECT_EQ(first.extraDistance, 40.0F);
    EXPECT_EQ(first.angleScale, 0.5F);
    EXPECT_TRUE(first.noCosine);
    // Linear: E = c max(0, 0.9375 I - fade d), no cosine.
    const auto e = [&](const Vec3& p) {
        return illuminate(found.lights.at(1), p, glm::normalize(Vec3(1, 0, -1)), false, {}).irradiance.x;
    };
    EXPECT_NEAR(e({0, 0, 50}), 187.5F - 100.0F, 0.01F);
    EXPECT_EQ(e({0, 0, 94}), 0.0F);
    EXPECT_EQ(found.warnings.size(), 2U);
}

TEST(Import, Spot) {
    const ImportedLights found = importLights(
        withLights({entity({{"classname", "light"}, {"origin", "0 0 200"}, {"target", "T1"}, {"radius", "84"}}),
                    entity({{"classname", "info_null"}, {"targetname", "t1"}, {"origin", "0 0 0"}})}),
        {});
    ASSERT_EQ(found.spots, 1U);
    const auto& spot = std::get<SpotLight>(found.lights.at(0));
    EXPECT_EQ(spot.direction, Vec3(0, 0, -1));
    EXPECT_NEAR(spot.slope, 0.5F, 1e-6F);
    EXPECT_EQ(spot.rim, 32.0F);
}

TEST(Import, MissingTargetShinesAllAroundAndSaysSo) {
    const ImportedLights found = importLights(withLights({entity({{"classname", "light"}, {"target", "gone"}})}), {});
    EXPECT_EQ(found.points, 1U);
    EXPECT_THAT(found.warnings, testing::ElementsAre(testing::HasSubstr("'gone'")));
}

TEST(Import, SunEntity) {
    const ImportedLights found = importLights(
        withLights({entity({{"classname", "light"},
                            {"origin", "0 0 100"},
                            {"target", "t"},
                            {"_sun", "1"},
                            {"light", "120"},
                            {"_deviance", "2"}}),
                    entity({{"classname", "target_position"}, {"targetname", "t"}, {"origin", "100 0 0"}})}),
        *skyRoom());
    ASSERT_EQ(found.suns, 1U);
    const auto& sun = std::get<SunLight>(found.lights.at(0));
    EXPECT_NEAR(sun.towards.x, -std::sqrt(0.5F), 1e-6F);
    EXPECT_NEAR(sun.towards.z, std::sqrt(0.5F), 1e-6F);
    EXPECT_FLOAT_EQ(sun.irradiance.x, 120.0F);
    EXPECT_NEAR(sun.devianceRadians, 2.0F * std::numbers::pi_v<float> / 180.0F, 1e-6F);
}

TEST(Import, DevianceMakesASphere) {
    const ImportedLights found =
        importLights(withLights({entity({{"classname", "light"}, {"_deviance", "24"}, {"_samples", "16"}})}), {});
    ASSERT_EQ(found.spheres, 1U);
    EXPECT_EQ(std::get<SphereLight>(found.lights.at(0)).radius, 24.0F);
    EXPECT_NEAR(std::get<SphereLight>(found.lights.at(0)).power.x / wattsPerIntensity, 300.0F, 1e-2F);
}

TEST(Import, OnlyLightClassesCount) {
    const ImportedLights found =
        importLights(withLights({entity({{"classname", "lightJunior"}}), entity({{"classname", "info_player_start"}}),
                                 entity({{"classname", "Light_torch"}})}),
                     {});
    EXPECT_EQ(found.points, 1U);
}

TEST(Import, EmissiveSquareIsOnePolygonWithBacksplash) {
    Level level;
    auto shader = lampShader(1000);
    shader.light.colour = Rgb(0.2F, 0.4F, 0.1F);
    shader.light.backsplashPercent = 5;
    shader.light.backsplashDistance = 23;
    addSurface(level, square, twoTriangles, shader);
    const ImportedLights found = importLights(level, {});
    ASSERT_EQ(found.areas, 1U);
    ASSERT_EQ(found.lights.size(), 2U);
    const auto& splash = std::get<AreaLight>(found.lights[0]);
    const auto& light = std::get<AreaLight>(found.lights[1]);
    EXPECT_EQ(light.corners.size(), 4U);
    EXPECT_NEAR(light.area, 4096.0, 1e-6);
    EXPECT_EQ(light.normal, Vec3(0, 0, 1));
    EXPECT_FALSE(light.twoSided);
    EXPECT_NEAR(light.radiosity.y, 750.0F, 1e-3F);
    EXPECT_NEAR(light.radiosity.x, 375.0F, 1e-3F);
    EXPECT_EQ(splash.normal, Vec3(0, 0, -1));
    EXPECT_EQ(splash.corners[0].z, 23.0F);
    EXPECT_NEAR(splash.radiosity.y, 0.35F * 750.0F, 1e-3F);
    EXPECT_EQ(found.summary(), "1 area; from scripts");
    EXPECT_EQ(importLights(level, {}, {.backsplash = false}).lights.size(), 1U);
    EXPECT_TRUE(importLights(level, {}, {.scripts = false}).fallback);
}

TEST(Import, TwoSidedEmitters) {
    Level level;
    auto shader = lampShader(100);
    shader.cull = level::Cull::None;
    shader.light.backsplashPercent = 0;
    addSurface(level, square, twoTriangles, shader);
    const ImportedLights found = importLights(level, {});
    ASSERT_EQ(found.lights.size(), 1U);
    EXPECT_TRUE(std::get<AreaLight>(found.lights[0]).twoSided);
}

TEST(Import, SurfacesThatAreNotPolygonsStayInPieces) {
    Level level;
    auto shader = lampShader(100);
    shader.light.backsplashPercent = 0;
    // An L: two convex pieces at best.
    addSurface(level, {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}},
               {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5}, shader);
    ImportedLights found = importLights(level, {});
    double area = 0.0;
    for (const Light& light : found.lights) area += std::get<AreaLight>(light).area;
    EXPECT_NEAR(area, 3.0, 1e-9);
    EXPECT_EQ(found.lights.size(), 2U);

    // A bent strip: planes differ.
    Level bent;
    addSurface(bent, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5F}}, twoTriangles, shader);
    EXPECT_EQ(importLights(bent, {}).lights.size(), 2U);

    // Slivers without area are no lights.
    Level sliver;
    addSurface(sliver, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}}, {0, 1, 2, 0, 2, 3}, shader);
    EXPECT_EQ(importLights(sliver, {}).areas, 1U);
}

TEST(Import, StraightCornersAndFansJoin) {
    Level level;
    auto shader = lampShader(100);
    shader.light.backsplashPercent = 0;
    // A square with a vertex in the middle of each edge and a centre: eight triangles, one polygon of four corners.
    addSurface(level,
               {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}, {1, 1, 0}},
               {8, 0, 1, 8, 1, 2, 8, 2, 3, 8, 3, 4, 8, 4, 5, 8, 5, 6, 8, 6, 7, 8, 7, 0}, shader);
    const ImportedLights found = importLights(level, {});
    ASSERT_EQ(found.lights.size(), 1U);
    EXPECT_NEAR(std::get<AreaLight>(found.lights[0]).area, 4.0, 1e-9);
    EXPECT_EQ(std::get<AreaLight>(found.lights[0]).corners.size(), 4U);
}

TEST(Import, ColourOfTheLightImage) {
    Level level;
    auto image = std::make_shared<level::Image>();
    image->width = 2;
    image->height = 1;
    image->pixels = {Rgba8(200, 100, 0, 255), Rgba8(100, 50, 0, 255)};
    level::Texture texture;
    texture.name = "textures/lamp_glow";
    texture.path = "textures/lamp_glow.tga";
    texture.image = image;
    level.textureIndex[texture.name] = static_cast<std::uint32_t>(level.textures.size());
    level.textures.push_back(texture);
    auto shader = lampShader(100);
    shader.light.lightImage = "textures/lamp_glow";
    shader.light.backsplashPercent = 0;
    addSurface(level, square, twoTriangles, shader);
    const auto colour = std::get<AreaLight>(importLights(level, {}).lights.at(0)).radiosity;
    EXPECT_NEAR(colour.x, 75.0F, 1e-3F);
    EXPECT_NEAR(colour.y, 37.5F, 0.2F);
    const auto linear = std::get<AreaLight>(importLights(level, {}, {.linear = true}).lights.at(0)).radiosity;
    EXPECT_NEAR(linear.x, 75.0F, 1e-3F);
    EXPECT_LT(linear.y, 25.0F);
}

TEST(Import, SunOfTheSky) {
    Level level;
    auto shader = skyShader();
    level::SunKey key;
    key.colour = Rgb(2.0F, 1.0F, 0.5F);
    key.intensity = 90;
    key.degrees = 90;
    key.elevation = 30;
    shader.light.suns.push_back(key);
    addSurface(level, square, twoTriangles, shader);
    const ImportedLights found = importLights(level, *skyRoom());
    ASSERT_EQ(found.suns, 1U);
    const auto& sun = std::get<SunLight>(found.lights.at(0));
    EXPECT_NEAR(sun.towards.y, std::cos(std::numbers::pi / 6), 1e-6);
    EXPECT_NEAR(sun.towards.z, 0.5, 1e-6);
    EXPECT_FLOAT_EQ(sun.irradiance.x, 90.0F);
    EXPECT_FLOAT_EQ(sun.irradiance.z, 22.5F);
    EXPECT_TRUE(found.warnings.empty());
    const ImportedLights indoors = importLights(level, {});
    EXPECT_EQ(indoors.suns, 1U);
    EXPECT_TRUE(indoors.fallback) << "a sun without sky lights nothing";
    EXPECT_THAT(indoors.warnings, testing::Contains(testing::HasSubstr("no sky surface")));
}

/// 4(n-1)² + 1 equal suns; an open floor gets between 0.5 and 0.64 of the value.
TEST(Import, SkyLight) {
    for (const int n : {2, 3, 5, 12}) {
        Level level;
        auto shader = skyShader();
        shader.light.skyLights.push_back({100.0F, n});
        addSurface(level, square, twoTriangles, shader);
        const ImportedLights found = importLights(level, *skyRoom());
        ASSERT_EQ(found.skies, 1U);
        const auto& sky = std::get<SkyLight>(found.lights.at(0));
        EXPECT_EQ(sky.towards.size(), static_cast<std::size_t>(4 * (n - 1) * (n - 1) + 1));
        double floor = 0.0;
        for (const Vec3& towards : sky.towards) floor += sky.irradiance.x * towards.z;
        EXPECT_GT(floor, 49.0) << n;
        EXPECT_LT(floor, 65.0) << n;
    }
}

TEST(Import, SurfaceLightOnSkyHasNoBacksplash) {
    Level level;
    auto shader = skyShader();
    shader.light.surfaceLight = 100;
    addSurface(level, square, twoTriangles, shader);
    const ImportedLights found = importLights(level, *skyRoom());
    EXPECT_EQ(found.lights.size(), 1U);
    EXPECT_EQ(found.areas, 1U);
}

TEST(Import, UndrawnModelsGiveNoLight) {
    Level level;
    addSurface(level, square, twoTriangles, lampShader(100));
    level.models[0].drawn = false;
    EXPECT_TRUE(importLights(level, {}).fallback);
}

TEST(Import, FallbackAbovePlayerStarts) {
    Level level;
    level.entities = {entity({{"classname", "info_player_deathmatch"}, {"origin", "10 0 0"}}),
                      entity({{"classname", "info_player_start"}, {"origin", "20 0 0"}})};
    const auto room = skyRoom();
    const ImportedLights found = importLights(level, *room);
    EXPECT_TRUE(found.fallback);
    ASSERT_EQ(found.spheres, 2U);
    EXPECT_EQ(std::get<SphereLight>(found.lights[0]).position, Vec3(10, 0, 64));
    EXPECT_NEAR(std::get<SphereLight>(found.lights[0]).power.x, 64.0 * room->area / 2.0, 1.0);
    EXPECT_EQ(found.summary(), "2 sphere; from fallback");
    EXPECT_THAT(
        found.warnings,
        testing::ElementsAre("the level has no light: 2 soft point lights above the player starts stand in for it"));
    const ImportedLights empty = importLights({}, *room);
    ASSERT_EQ(empty.spheres, 1U);
    EXPECT_EQ(std::get<SphereLight>(empty.lights[0]).position, Vec3(50, 50, 50));
    EXPECT_EQ(importLights({}, {}).spheres, 1U) << "even an empty scene";
}

TEST(Import, AmbientOfTheWorld) {
    Level level;
    level.entities = {
        entity({{"classname", "worldspawn"}, {"_color", "1 0.5 0.5"}, {"ambient", "10"}, {"_minlight", "4"}})};
    const ImportedLights found = importLights(level, {});
    EXPECT_FLOAT_EQ(found.ambient.x, 10.0F);
    EXPECT_FLOAT_EQ(found.ambient.y, 5.0F);
    EXPECT_FLOAT_EQ(found.minLight.z, 2.0F);
}

TEST(Import, SourcesAreNamed) {
    Level level = withLights({entity({{"classname", "light"}})});
    level.lightEntitySource = "oa_dm1.map";
    addSurface(level, square, twoTriangles, lampShader(100));
    EXPECT_EQ(importLights(level, {}).summary(), "1 point, 1 area; from entities of oa_dm1.map and scripts");
}

TEST(Import, Scales) {
    Level level = withLights({entity({{"classname", "light"}})});
    auto shader = skyShader();
    shader.light.surfaceLight = 100;
    shader.light.suns.emplace_back();
    shader.light.suns.back().intensity = 10;
    addSurface(level, square, twoTriangles, shader);
    const ImportedLights found = importLights(level, *skyRoom(), {.pointScale = 2, .areaScale = 3, .skyScale = 4});
    EXPECT_NEAR(std::get<PointLight>(found.lights.at(0)).power.x / wattsPerIntensity, 600.0F, 1e-2F);
    EXPECT_NEAR(std::get<SunLight>(found.lights.at(1)).irradiance.x, 40.0F, 1e-4F);
    EXPECT_NEAR(std::get<AreaLight>(found.lights.at(2)).radiosity.x, 225.0F, 1e-3F);
}

} // namespace
} // namespace pie::lights
