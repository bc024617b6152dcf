// Lights that are edited: values, switches, undo, reading the level again, picking and dragging.

#include "apps/pieview/light_edits.h"
#include "apps/pieview/light_picking.h"
#include "apps/pieview/save_lights.h"

#include <gtest/gtest.h>

#include <numbers>

namespace {

using namespace pie::lights;
using pie::Rgb;
using pie::Vec2;
using pie::Vec3;
using pieview::LightEdits;

constexpr float watts = 4 * std::numbers::pi_v<float> * 7500;

PointLight lamp(const Vec3& position, float intensity, const Rgb& colour = Rgb(1.0F)) {
    PointLight light;
    light.position = position;
    light.power = colour * (intensity * watts);
    return light;
}

AreaLight panel() {
    return makeAreaLight({{0, 0, 100}, {0, 64, 100}, {64, 64, 100}, {64, 0, 100}}, Rgb(200.0F, 100.0F, 50.0F));
}

TEST(LightValues, StrengthIsTheLightKeyOfTheEditor) {
    EXPECT_NEAR(pieview::strengthOf(lamp({}, 300, {1, 0.5F, 0})), 300, 0.01F);
    EXPECT_NEAR(pieview::strengthOf(panel()), 200, 1e-3F);
    EXPECT_NEAR(pieview::strengthOf(SunLight{{0, 0, 1}, Rgb(10, 20, 5), 0}), 20, 1e-4F);
}

TEST(LightValues, ChangingOneKeepsTheOther) {
    const Light before = lamp({1, 2, 3}, 300, {1, 0.5F, 0.25F});
    const Light brighter = pieview::withStrength(before, 600);
    EXPECT_NEAR(pieview::strengthOf(brighter), 600, 0.01F);
    EXPECT_NEAR(pieview::colourOf(brighter).y, 0.5F, 1e-5F);
    const Light blue = pieview::withColour(before, {0, 0, 0.3F});
    EXPECT_NEAR(pieview::strengthOf(blue), 300, 0.01F);
    EXPECT_EQ(pieview::colourOf(blue), Rgb(0, 0, 1));
    EXPECT_EQ(pieview::colourOf(pieview::withColour(before, Rgb(-1.0F))), Rgb(1.0F)) << "no colour is white";
    EXPECT_EQ(pieview::strengthOf(pieview::withStrength(before, -5)), 0);
    const Light dark = pieview::withStrength(before, 0);
    EXPECT_EQ(pieview::strengthOf(pieview::withStrength(dark, 70)), 70) << "from darkness, white";
}

TEST(LightValues, LinearFalloffFollowsTheStrength) {
    PointLight light = lamp({}, 300);
    light.falloff.linear = true;
    light.falloff.linearIntensity = 300;
    EXPECT_NEAR(std::get<PointLight>(pieview::withStrength(light, 150)).falloff.linearIntensity, 150, 1e-3F);
}

TEST(LightValues, AreasMoveWhole) {
    const Light moved = pieview::movedTo(panel(), {132, 32, 90});
    EXPECT_EQ(*pieview::positionOf(moved), Vec3(132, 32, 90));
    EXPECT_EQ(std::get<AreaLight>(moved).corners[0], Vec3(100, 0, 90));
    EXPECT_FALSE(pieview::positionOf(SunLight{}));
}

TEST(PieviewLightEdits, SayWhatChangedAndWhatIsEdited) {
    LightEdits edits({lamp({}, 100), lamp({10, 0, 0}, 200)});
    EXPECT_TRUE(edits.takeChanged().empty());
    edits.set(1, lamp({10, 0, 0}, 300));
    edits.setOn(0, false);
    EXPECT_EQ(edits.takeChanged(), (std::vector<std::size_t>{0, 1}));
    EXPECT_TRUE(edits.takeChanged().empty());
    EXPECT_EQ(edits.edits().size(), 2U);
    EXPECT_FALSE(edits.isOn(0));
    edits.set(1, lamp({10, 0, 0}, 200)); // as it was
    EXPECT_FALSE(edits.isEdited(1));
    edits.setOn(0, true);
    EXPECT_TRUE(edits.edits().empty());
    EXPECT_EQ(edits.takeChanged().size(), 2U);
}

TEST(PieviewLightEdits, UndoGivesTheLevelsOwn) {
    LightEdits edits({lamp({}, 100), lamp({10, 0, 0}, 200)});
    edits.set(0, lamp({5, 5, 5}, 1));
    edits.setOn(0, false);
    edits.undo(0);
    EXPECT_TRUE(pieview::sameLight(edits.light(0), edits.original(0)));
    EXPECT_TRUE(edits.isOn(0));
    edits.set(0, lamp({}, 1));
    edits.set(1, lamp({}, 1));
    edits.undoAll();
    EXPECT_TRUE(edits.edits().empty());
    EXPECT_EQ(edits.takeChanged().size(), 2U);
}

TEST(PieviewLightEdits, FollowTheirLightWhenTheLevelIsReadAgain) {
    LightEdits edits({lamp({}, 100), lamp({10, 0, 0}, 200), lamp({20, 0, 0}, 300)});
    edits.set(1, lamp({10, 0, 0}, 250));
    edits.setOn(2, false);
    // One lamp more in front; the third has been moved in the editor.
    edits.carryOver({lamp({-9, 0, 0}, 50), lamp({}, 100), lamp({10, 0, 0}, 200), lamp({21, 0, 0}, 300)});
    ASSERT_EQ(edits.edits().size(), 1U);
    EXPECT_TRUE(pieview::sameLight(edits.light(2), lamp({10, 0, 0}, 250)));
    EXPECT_TRUE(edits.isOn(3)) << "the editor has the last word";
    EXPECT_EQ(edits.takeChanged(), std::vector<std::size_t>{2});
}

TEST(PieviewLightEdits, OfTwoAlikeEachKeepsItsOwn) {
    LightEdits edits({lamp({}, 100), lamp({}, 100)});
    edits.setOn(1, false);
    edits.carryOver({lamp({}, 100), lamp({}, 100)});
    EXPECT_TRUE(edits.isOn(0));
    EXPECT_FALSE(edits.isOn(1));
}

const apps::Camera camera{{0, -200, 0}, 90, 0}; // looks along +y
const apps::Lens lens{90, 400, 400};

TEST(LightPicking, TakesTheNearestInThePictureAndThenInDepth) {
    const LightEdits edits({lamp({0, 0, 0}, 1), lamp({50, 0, 0}, 1), lamp({0, -100, 0}, 1), SunLight{}});
    EXPECT_EQ(pieview::pickLight(edits, camera, lens, {251, 200}, 10), 1U);
    EXPECT_EQ(pieview::pickLight(edits, camera, lens, {200, 200}, 10), 2U) << "in front of the first";
    EXPECT_FALSE(pieview::pickLight(edits, camera, lens, {100, 100}, 10));
}

TEST(LightPicking, DragsInThePictureUpwardsAndAlongAnAxis) {
    const auto drag = [](const Vec2& to, pieview::DragAlong along) {
        return pieview::dragged({0, 0, 0}, camera, lens, {200, 200}, to, along);
    };
    // At distance 200 the picture is 400 units wide: a unit a pixel.
    const Vec3 free = drag({230, 180}, pieview::DragAlong::Picture);
    EXPECT_NEAR(free.x, 30, 0.01F);
    EXPECT_NEAR(free.y, 0, 0.01F);
    EXPECT_NEAR(free.z, 20, 0.01F);
    EXPECT_NEAR(drag({230, 180}, pieview::DragAlong::Vertical).z, 20, 0.01F);
    EXPECT_NEAR(drag({230, 180}, pieview::DragAlong::Vertical).x, 0, 0.01F);
    const Vec3 along = drag({230, 180}, pieview::DragAlong::Axis);
    EXPECT_NEAR(along.x, 30, 0.01F);
    EXPECT_NEAR(along.z, 0, 0.01F);
}

/// A level of two entities, the second a spot light, and an emissive panel.
struct SaveLights : ::testing::Test {
    SaveLights() {
        level.lightEntities.resize(3);
        level.lightEntities[0].pairs = {{"classname", "light"}, {"origin", "0 0 0"}, {"_color", "1 .5 .25"}};
        level.lightEntities[1].pairs = {
            {"classname", "light"}, {"origin", "0 0 100"}, {"light", "50"}, {"target", "t"}};
        level.lightEntities[2].pairs = {{"classname", "info_null"}, {"origin", "0 0 0"}, {"targetname", "t"}};
    }
    void import() {
        imported = importLights(level, {}, options);
        imported.lights.emplace_back(panel());
        edits = LightEdits(imported.lights);
    }
    [[nodiscard]] pieview::LightSource source() const { return {level, imported, options}; }

    pie::level::Level level;
    ImportOptions options;
    ImportedLights imported;
    LightEdits edits;
};

TEST_F(SaveLights, OnlyWhatChangedIsWritten) {
    import();
    ASSERT_EQ(edits.size(), 3U);
    EXPECT_TRUE(pieview::lightsToSave(source(), edits).edits.empty());
    edits.set(0, pieview::withStrength(edits.light(0), 450));
    edits.set(2, pieview::withStrength(edits.light(2), 450));
    edits.setOn(1, false);
    const auto plan = pieview::lightsToSave(source(), edits);
    ASSERT_EQ(plan.edits.size(), 1U);
    EXPECT_EQ(plan.edits[0].after.value("light"), "450");
    EXPECT_EQ(plan.edits[0].after.value("_color"), "1 .5 .25");
    EXPECT_EQ(plan.edits[0].after.value("origin"), "0 0 0");
    EXPECT_EQ(plan.ofShaders, 1U);
    EXPECT_EQ(plan.switchedOff, 1U);
}

TEST_F(SaveLights, FactorsOfTheSettingsStayOutOfTheLevel) {
    options.pointScale = 4;
    options.linear = true;
    import();
    edits.set(0, pieview::withColour(pieview::withStrength(edits.light(0), 600), {0.5F, 1, 0}));
    const auto edit = pieview::entityEdit(source(), edits, 0);
    ASSERT_TRUE(edit);
    EXPECT_EQ(edit->after.value("light"), "150"); // of 600
    EXPECT_EQ(edit->after.value("_color"), "0.735 1 0");
    EXPECT_NEAR(pieview::colourOf(*pieview::shownLight(source(), edits, 0)).x, 0.5F, 2e-3F);
}

TEST_F(SaveLights, AMovedSpotLightIsShownLookingAtItsTarget) {
    import();
    edits.set(1, pieview::movedTo(edits.light(1), {100, 0, 0}));
    const auto shown = pieview::shownLight(source(), edits, 1);
    ASSERT_TRUE(shown);
    EXPECT_EQ(std::get<SpotLight>(*shown).direction, Vec3(-1, 0, 0));
    edits.setOn(1, false);
    EXPECT_FALSE(pieview::shownLight(source(), edits, 1));
    EXPECT_FALSE(pieview::entityEdit(source(), edits, 2));
    EXPECT_TRUE(pieview::shownLight(source(), edits, 2));
}

TEST_F(SaveLights, UnnormalisedColoursKeepTheirScale) {
    level.lightEntities[0].set("_color", "4 2 1");
    level.lightEntities[0].set("spawnflags", "32");
    import();
    edits.set(0, pieview::withColour(edits.light(0), {0, 1, 0}));
    EXPECT_EQ(pieview::entityEdit(source(), edits, 0)->after.value("_color"), "0 4 0");
    EXPECT_NEAR(pieview::strengthOf(*pieview::shownLight(source(), edits, 0)), pieview::strengthOf(edits.original(0)),
                1);
}

} // namespace
