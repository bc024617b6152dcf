// Lights that are set while the light of a scene is shown, through Transport.

#include "pie/core/parallel.h"
#include "tests/engine/lit_room.h"
#include "tests/lights/rooms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace pie::engine {
namespace {

using gather::test::receiverAt;
using gather::test::relativeRms;
using gather::test::SceneBuilder;
using pie::test::lamp;

const lights::Light first = lamp(Vec3(30, 30, 70), Rgb(4e7F, 2e7F, 1e7F));
const lights::Light second = lamp(Vec3(70, 60, 50), Rgb(1e7F, 3e7F, 2e7F));
const lights::Light elsewhere = lamp(Vec3(20, 80, 30), Rgb(9e7F, 1e7F, 1e7F));

Settings roomSettings() {
    Settings settings;
    settings.photonsFromLight = 4000;
    settings.accumulationFrames = 5;
    settings.stillFrames = 40;
    settings.directTolerance = 0.01F;
    return settings;
}

/// A photon map is slower; it is only to be seen that all of it is renewed.
void renewAll(Settings& settings) {
    settings.photonsFromLight = 1000;
    settings.accumulationFrames = 20;
}

/// A grey room with a box in it, and receivers on floor and wall.
struct Room : test::LitRoom {
    Room() : LitRoom(makeScene(), makePoints()) {}

    static std::shared_ptr<const scene::Scene> makeScene() {
        SceneBuilder builder;
        builder.grey(0.6F);
        builder.room(Vec3(0.0F), Vec3(100.0F));
        builder.grey(0.3F);
        builder.quad(Vec3(40, 40, 20), Vec3(30, 0, 0), Vec3(0, 30, 0));
        return builder.make();
    }
    static std::vector<scene::Receiver> makePoints() {
        std::vector<scene::Receiver> points;
        for (int x = 0; x < 8; ++x)
            for (int y = 0; y < 8; ++y) {
                const auto a = 6.0F + 12.0F * static_cast<float>(x);
                const auto b = 6.0F + 12.0F * static_cast<float>(y);
                points.push_back(receiverAt(Vec3(a, b, 0.0F), Vec3(0, 0, 1)));
                points.push_back(receiverAt(Vec3(0.0F, a, b), Vec3(1, 0, 0)));
            }
        return points;
    }
    /// A frame as a viewer has it.
    bool frame(Transport& transport, std::vector<Rgb>& light) const {
        const bool changed = transport.advance();
        light.resize(which.size());
        transport.irradiance(which, light);
        return changed;
    }
    std::vector<Rgb> settle(Transport& transport) const {
        std::vector<Rgb> light;
        int frames = 0;
        while (frame(transport, light))
            if (++frames > 1000) {
                ADD_FAILURE() << "never still";
                break;
            }
        return light;
    }
};

std::vector<EstimatorKind> estimators() { return {EstimatorKind::Gather, EstimatorKind::TrueArea}; }

TEST(ChangingLights, SettleToWhatTheyWouldHaveBeenFromTheStart) {
    const Room room;
    for (const EstimatorKind kind : estimators()) {
        Settings settings = roomSettings();
        settings.estimator = kind;
        if (kind != EstimatorKind::Gather) renewAll(settings);
        Transport changed = room.transport({first}, settings);
        std::vector<Rgb> light;
        for (int i = 0; i < 4; ++i) room.frame(changed, light);
        changed.setLight(1, elsewhere);
        for (int i = 0; i < 3; ++i) room.frame(changed, light);
        changed.setLight(1, second);
        const std::vector<Rgb> settled = room.settle(changed);
        Transport fresh = room.transport({first, second}, settings);
        const double error = relativeRms(settled, room.settle(fresh));
        EXPECT_LT(error, kind == EstimatorKind::Gather ? 0.01 : 0.1) << static_cast<int>(kind);
        EXPECT_EQ(changed.lightCount(), 2U);
        EXPECT_TRUE(changed.statistics().still);
    }
}

TEST(ChangingLights, LightsOfTheLevelMoveAndGoOut) {
    const Room room;
    for (const EstimatorKind kind : estimators())
        for (const bool errors : {false, true}) {
            Settings settings = roomSettings();
            settings.estimator = kind;
            settings.standardErrors = errors;
            if (kind != EstimatorKind::Gather) renewAll(settings);
            Transport changed = room.transport({first, elsewhere}, settings);
            room.settle(changed);
            changed.setLight(1, second);
            const double moved = relativeRms(room.settle(changed), [&] {
                Transport fresh = room.transport({first, second}, settings);
                return room.settle(fresh);
            }());
            changed.setLight(1, std::nullopt);
            const double out = relativeRms(room.settle(changed), [&] {
                Transport fresh = room.transport({first}, settings);
                return room.settle(fresh);
            }());
            const double most = kind == EstimatorKind::Gather ? 0.01 : 0.1;
            EXPECT_LT(moved, most) << static_cast<int>(kind) << errors;
            EXPECT_LT(out, most) << static_cast<int>(kind) << errors;
            for (const std::size_t light : {0U, 1U}) changed.setLight(light, std::nullopt);
            const std::vector<Rgb> dark = room.settle(changed);
            for (const Rgb& e : dark) EXPECT_LT(meanChannel(e), 1.0F) << "of some thousand";
        }
}

// The shadow is where it belongs in the very next frame, and all the light within the renewal time.
TEST(ChangingLights, AMoveIsThereAtOnceAndWholeWithinTheRenewalTime) {
    const Room room;
    const Settings settings = roomSettings();
    Transport changed = room.transport({first}, settings);
    changed.setLight(1, elsewhere);
    room.settle(changed);
    Transport there = room.transport({first, second}, settings);
    const std::vector<Rgb> truth = room.settle(there);
    changed.setLight(1, second);
    std::vector<Rgb> light;
    room.frame(changed, light);
    EXPECT_LT(relativeRms(light, truth), 0.35) << "what is reflected is still that of before";
    for (int i = 1; i < settings.accumulationFrames; ++i) room.frame(changed, light);
    EXPECT_LT(relativeRms(light, truth), 0.03);
}

TEST(ChangingLights, SameBitsOnAnyNumberOfThreads) {
    const Room room;
    std::vector<std::vector<Rgb>> results;
    for (const unsigned threads : {1U, 2U}) {
        setThreads(threads);
        Transport changed = room.transport({first}, roomSettings());
        std::vector<Rgb> light;
        for (int i = 0; i < 9; ++i) {
            changed.setLight(1, lamp(Vec3(20.0F + 5.0F * static_cast<float>(i), 50, 60), Rgb(2e7F)));
            if (i == 5) changed.setLight(0, elsewhere);
            room.frame(changed, light);
        }
        results.push_back(light);
    }
    setThreads(0);
    EXPECT_EQ(std::memcmp(results[0].data(), results[1].data(), results[0].size() * sizeof(Rgb)), 0);
}

// Photons keep their numbers, so a light that is set anew where it is changes nothing, and one that moves a little
// changes little: no flicker.
TEST(ChangingLights, DoNotFlicker) {
    const Room room;
    Transport changed = room.transport({first}, roomSettings());
    changed.setLight(1, second);
    std::vector<Rgb> light;
    for (int i = 0; i < 60; ++i) { // never still: only the ring of photons is there
        changed.setLight(1, second);
        room.frame(changed, light);
    }
    const std::vector<Rgb> before = light;
    for (int i = 0; i < 5; ++i) {
        changed.setLight(1, second);
        room.frame(changed, light);
        EXPECT_EQ(std::memcmp(light.data(), before.data(), light.size() * sizeof(Rgb)), 0);
    }
    // A step of a hundredth of the room, to be seen against the step that the true light makes.
    const lights::Light step = lamp(Vec3(71, 60, 50), Rgb(1e7F, 3e7F, 2e7F));
    for (int i = 0; i < 5; ++i) {
        changed.setLight(1, step);
        room.frame(changed, light);
    }
    Transport from = room.transport({first, second}, roomSettings());
    Transport to = room.transport({first, step}, roomSettings());
    const std::vector<Rgb> a = room.settle(from);
    const std::vector<Rgb> b = room.settle(to);
    std::vector<Rgb> expected = before;
    for (std::size_t i = 0; i < expected.size(); ++i) expected[i] += b[i] - a[i];
    EXPECT_LT(relativeRms(light, expected), 0.01);
}

TEST(ChangingLights, CostNothingWhereThereAreNone) {
    const Room room;
    Transport still = room.transport({first, second}, roomSettings());
    room.settle(still);
    const std::size_t bytes = still.statistics().estimatorBytes;
    Transport changing = room.transport({first}, roomSettings());
    changing.setLight(1, second);
    room.settle(changing);
    EXPECT_GT(changing.statistics().estimatorBytes, bytes);
}

TEST(ChangingLights, DirectionsNeedNotBeUnits) {
    const Room room;
    std::vector<std::vector<Rgb>> results;
    for (const float length : {1.0F, 7.0F}) {
        Transport changed = room.transport({}, roomSettings());
        lights::SpotLight spot;
        spot.position = Vec3(50, 50, 80);
        spot.direction = Vec3(0, 0, -length);
        spot.power = Rgb(1e7F);
        changed.setLight(0, spot);
        results.push_back(room.settle(changed));
    }
    EXPECT_GT(meanChannel(results[0][54]), 1.0F);
    EXPECT_EQ(results[0], results[1]);
}

// Lights without any power, without number, or brighter than anything before.
TEST(ChangingLights, ExtremesStayFinite) {
    const Room room;
    Transport changed = room.transport({}, roomSettings());
    std::vector<Rgb> light;
    for (const float watts : {0.0F, 1e-30F, std::numeric_limits<float>::quiet_NaN(), 1e30F, 1e7F}) {
        changed.setLight(3, lamp(Vec3(50, 50, 80), Rgb(watts)));
        for (int i = 0; i < 7; ++i) room.frame(changed, light);
        for (const Rgb& e : light) ASSERT_TRUE(std::isfinite(e.x) && e.x >= 0.0F) << watts;
    }
    changed.setLight(3, first);
    Transport fresh = room.transport({first}, roomSettings());
    EXPECT_LT(relativeRms(room.settle(changed), room.settle(fresh)), 0.01);
}

} // namespace
} // namespace pie::engine
