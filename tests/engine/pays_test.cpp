// A scene pays only for what it has: counters and bytes of levels with and without a thing.
#include "pie/engine/engine.h"

#include "tests/level/make_level.h"

#include <gtest/gtest.h>

#include <numeric>
#include <string>

namespace pie::engine {
namespace {

struct Parts {
    bool sky = false, grate = false;
};

constexpr const char* scripts = R"(
textures/made/sky
{
    surfaceparm sky
    surfaceparm noimpact
    q3map_skylight 100 3
    q3map_sun 1 1 1 100 0 90
}
textures/made/grate
{
    surfaceparm alphashadow
    surfaceparm nonsolid
    cull none
    {
        map textures/made/grate.tga
        alphaFunc GE128
        rgbGen vertex
    }
}
)";

std::shared_ptr<const level::Level> makeLevel(const Parts& parts) {
    test::LevelBuilder builder;
    const int wall = builder.shader("textures/made/wall");
    const int top = parts.sky ? builder.shader("textures/made/sky", 0x4) : wall;
    builder.room(Vec3(-128, -128, -64), Vec3(128, 128, 96), {wall, wall, wall, wall, wall, top});
    if (parts.grate) {
        const int grate = builder.shader("textures/made/grate");
        builder.room(Vec3(-32, -32, -32), Vec3(32, 32, 0), {grate, grate, grate, grate, grate, grate});
    }
    builder.entity({{"classname", "light"}, {"origin", "16 8 40"}, {"light", "200"}});
    auto files = std::vector<std::pair<std::string, level::Bytes>>{
        {"textures/made/wall.tga", test::makeTga(4, 4, [](int, int) { return Rgba8(160, 128, 96, 255); })},
        {"textures/made/grate.tga",
         test::makeTga(4, 4, [](int x, int) { return Rgba8(160, 128, 96, x % 2 == 0 ? 255 : 0); })},
        {"scripts/made.shader", test::toBytes(scripts)}};
    auto level = level::loadLevel(test::inMemory(builder.build(), std::move(files)));
    EXPECT_TRUE(level) << level.error().message();
    return std::make_shared<const level::Level>(std::move(*level));
}

Settings fewPhotons() {
    Settings settings;
    settings.photonsFromLight = 2000;
    settings.accumulationFrames = settings.stillFrames = 2;
    settings.gatherRays = 64;
    return settings;
}

Statistics spent(const Parts& parts, const Settings& settings) {
    Engine engine(makeLevel(parts), settings);
    while (engine.advance()) {}
    std::vector<std::uint32_t> which(engine.receivers().points.size());
    std::iota(which.begin(), which.end(), 0U);
    std::vector<Rgb> light(which.size());
    engine.irradiance(which, light);
    engine.finish(which);
    engine.irradiance(which, light);
    return engine.statistics();
}

std::size_t bytesWithoutCoordinates(const Statistics& statistics) {
    // Eight corners of the room, each once.
    return statistics.coarseTriangles * (sizeof(scene::Triangle) + sizeof(Vec3)) + 8 * sizeof(Vec3);
}

} // namespace

TEST(PaysOnly, ForTheSkyThatThereIs) {
    Settings settings = fewPhotons();
    settings.estimator = EstimatorKind::TrueArea;
    const Statistics closed = spent({}, settings);
    EXPECT_EQ(closed.directEstimates, closed.receivers);
    EXPECT_LE(closed.directRays, closed.receivers) << "one lamp, one point: a ray a receiver that faces it";
    EXPECT_GT(closed.directRays, closed.receivers / 2);
    EXPECT_EQ(closed.photonsEscaped, 0U);
    const Statistics open = spent({.sky = true}, settings);
    EXPECT_GT(open.directRays, 4 * open.receivers);
}

TEST(PaysOnly, ForTheFiltersThatThereAre) {
    const Statistics plain = spent({}, fewPhotons());
    EXPECT_EQ(plain.sceneBytes, bytesWithoutCoordinates(plain)) << "no texture coordinates";
    const Statistics filtered = spent({.grate = true}, fewPhotons());
    EXPECT_EQ(filtered.sceneBytes,
              bytesWithoutCoordinates(filtered) + 8 * sizeof(Vec3) + 3 * filtered.coarseTriangles * sizeof(Vec2));
}

TEST(PaysOnly, ForTheEstimatorThatIsChosen) {
    Settings settings = fewPhotons();
    const Statistics gather = spent({}, settings);
    EXPECT_EQ(gather.mapBytes, 0U);
    EXPECT_EQ(gather.mapNodesVisited, 0U);
    EXPECT_GT(gather.estimatorBytes, 0U);
    settings.standardErrors = true;
    const Statistics errors = spent({}, settings);
    EXPECT_GT(errors.estimatorBytes, gather.estimatorBytes) << "batches are kept where they are asked for alone";
    settings = fewPhotons();
    settings.recursionDepth = 0;
    const Statistics direct = spent({}, settings);
    EXPECT_LT(direct.gatherRays, gather.gatherRays / 16) << "nothing is gathered; some texels for a first guess";
    EXPECT_LT(direct.estimatorBytes, gather.estimatorBytes);
    settings = fewPhotons();
    settings.estimator = EstimatorKind::TrueArea;
    const Statistics near = spent({}, settings);
    EXPECT_EQ(near.gatherRays, 0U);
    EXPECT_GT(near.mapBytes, 0U);
}

} // namespace pie::engine
