// The levels of our own: closed, of the size they say, lit, and the same when compiled.

#include "pie/brushes/compile.h"
#include "pie/intersect/intersectors.h"
#include "pie/level/entity_text.h"
#include "pie/lights/import.h"
#include "pie/lights/light_entity.h"
#include "tests/brushes/make_map.h"
#include "tests/support/files.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

namespace {

using namespace pie;
using ::testing::IsEmpty;

struct Bundled {
    const char* name;
    std::size_t leastTriangles, mostTriangles;
    bool sky;
};
std::ostream& operator<<(std::ostream& out, const Bundled& level) { return out << level.name; }

class BundledLevels : public ::testing::TestWithParam<Bundled> {
protected:
    static std::string path() { return std::string(PIE_LEVELS) + "/maps/" + GetParam().name + ".map"; }
    static level::Level load() {
        Result<level::Location> location = level::locate(path());
        EXPECT_TRUE(location);
        Result<level::Level> level = brushes::loadLevel(std::move(*location));
        EXPECT_TRUE(level) << (level ? "" : level.error().message());
        return level ? std::move(*level) : level::Level{};
    }
};

Vec3 placeOf(const lights::Light& light) {
    if (const auto* point = std::get_if<lights::PointLight>(&light)) return point->position;
    if (const auto* sphere = std::get_if<lights::SphereLight>(&light)) return sphere->position;
    return std::get<lights::SpotLight>(light).position;
}
Rgb wattsOf(const lights::Light& light) {
    if (const auto* point = std::get_if<lights::PointLight>(&light)) return point->power;
    if (const auto* sphere = std::get_if<lights::SphereLight>(&light)) return sphere->power;
    return std::get<lights::SpotLight>(light).power;
}

TEST_P(BundledLevels, LoadWithoutAWordAndAreOfTheirSize) {
    const level::Level level = load();
    EXPECT_THAT(level.statistics.warnings, IsEmpty());
    EXPECT_THAT(level.statistics.missingTextures, IsEmpty());
    EXPECT_GE(level.statistics.drawnTriangles, GetParam().leastTriangles);
    EXPECT_LE(level.statistics.drawnTriangles, GetParam().mostTriangles);
    const scene::Scene scene = scene::makeScene(level);
    const lights::ImportedLights lights = lights::importLights(level, scene);
    EXPECT_FALSE(lights.fallback);
    EXPECT_FALSE(lights.lights.empty());
}

/// What a window shows while a light is dragged is what the level has once it is saved and loaded; and whoever takes
/// the change back has the file again, byte for byte.
TEST_P(BundledLevels, SavedLightsAreThoseThatWereShown) {
    const level::Level level = load();
    const lights::ImportedLights lights = lights::importLights(level, scene::makeScene(level));
    const Result<std::filesystem::path> file = level.lightEntityFile();
    ASSERT_EQ(static_cast<bool>(file), !lights.entities.empty());
    if (file) {
        EXPECT_EQ(*file, path());
    }
    std::vector<level::EntityEdit> there, back;
    std::vector<lights::Light> shown;
    for (const std::uint32_t number : lights.entities) {
        const level::Entity& before = level.lightEntities[number];
        level::Entity after = before;
        lights::setPosition(after, lights::positionOf(before) + Vec3(1.5F, -2, 1.0F / 3.0F));
        lights::setIntensity(after, 0.7F * lights::intensityOf(before));
        there.push_back({before, after});
        shown.push_back(lights::lightOf(level, after).value());
        level::Entity restored = after;
        for (const auto& [key, value] : before.pairs) restored.set(key, value);
        back.push_back({after, restored});
    }
    const test::TemporaryFolder folder;
    const std::string text = test::readText(path());
    const std::string copy = folder.write("copy.map", text);
    ASSERT_FALSE(level::saveEntities(copy, there));
    Result<level::Location> location = level::locate(copy);
    ASSERT_TRUE(location);
    const Result<level::Level> again = brushes::loadLevel(std::move(*location));
    ASSERT_TRUE(again);
    const lights::ImportedLights read = lights::importLights(*again, scene::makeScene(*again));
    ASSERT_EQ(read.entities, lights.entities);
    for (std::size_t i = 0; i < shown.size(); ++i) {
        EXPECT_EQ(placeOf(read.lights[i]), placeOf(shown[i])) << i;
        EXPECT_EQ(wattsOf(read.lights[i]), wattsOf(shown[i])) << i;
    }
    ASSERT_FALSE(level::saveEntities(copy, back));
    EXPECT_EQ(test::readText(copy), text);
}

/// A million photons; what they leave behind sends rays in all directions: each must meet something, if only sky.
TEST_P(BundledLevels, NoPhotonLeaves) {
    const level::Level level = load();
    const scene::Scene scene = scene::makeScene(level);
    const photons::TraceCounts counts = test::traceLevel(level, 1'000'000);
    if (!GetParam().sky) {
        EXPECT_EQ(counts.escaped, 0U) << "of " << counts.rays;
    }
    EXPECT_GT(counts.stored, 500'000U);

    const auto intersector = intersect::makeIntersector(intersect::Kind::Embree, scene, level.tree);
    std::mt19937 random(1);
    std::uniform_real_distribution<float> any(-1, 1);
    const Vec3 start = level.firstView().eye;
    std::vector<intersect::Ray> rays(200'000);
    for (intersect::Ray& ray : rays) {
        Vec3 direction(0);
        while (!(glm::length(direction) > 0.1F && glm::length(direction) < 1))
            direction = Vec3(any(random), any(random), any(random));
        ray.origin = start;
        ray.direction = glm::normalize(direction);
    }
    std::vector<intersect::Hit> hits(rays.size());
    std::size_t lost = 0;
    // Walk on from the air before where the last ray ended.
    for (int bounce = 0; bounce < 5; ++bounce) {
        intersector->closest(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!hits[i].found()) {
                ++lost;
                rays[i].origin = start;
                continue;
            }
            rays[i].origin += 0.7F * hits[i].t * rays[i].direction;
            rays[i].direction = glm::normalize(Vec3(any(random), any(random), any(random)) + Vec3(1e-4F));
        }
    }
    EXPECT_EQ(lost, 0U);
}

TEST_P(BundledLevels, GiveTheSameTrianglesWhenCompiled) {
    const level::Level direct = load();
    std::ifstream stream(path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    const Result<brushes::MapText> map = brushes::parseMap(text, "x.map");
    ASSERT_TRUE(map);
    Result<level::Location> location = level::locate(path());
    ASSERT_TRUE(location);
    const level::ShaderLibrary shaders = level::ShaderLibrary::load(location->files);
    const Result<brushes::CompiledMap> compiled = brushes::compileMap(*map, "x.map", location->files, shaders);
    ASSERT_TRUE(compiled);
    EXPECT_TRUE(compiled->leakPath.empty());
    const std::vector<std::byte> file = level::writeBsp(compiled->bsp);
    location->name = "maps/compiled.bsp";
    const Result<level::Level> read = brushes::loadLevel(file, std::move(*location));
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->indices, direct.indices);
    ASSERT_EQ(read->vertices.size(), direct.vertices.size());
    for (std::size_t i = 0; i < direct.vertices.size(); ++i)
        ASSERT_EQ(read->vertices[i].position, direct.vertices[i].position) << i;
    EXPECT_EQ(read->statistics.drawnTriangles, direct.statistics.drawnTriangles);
}

INSTANTIATE_TEST_SUITE_P(All, BundledLevels,
                         ::testing::Values(Bundled{"small", 360, 380, false}, Bundled{"normal", 5000, 6000, true},
                                           Bundled{"cornell", 30, 80, false}, Bundled{"cornell_lamp", 30, 90, false},
                                           Bundled{"furnace", 12, 12, false}, Bundled{"curves", 200, 1500, false},
                                           Bundled{"glass", 200, 3000, false}),
                         [](const auto& level) { return std::string(level.param.name); });

} // namespace
