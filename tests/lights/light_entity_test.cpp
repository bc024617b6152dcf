#include "pie/lights/import.h"
#include "pie/lights/light_entity.h"

#include <gtest/gtest.h>

#include <limits>

namespace pie::lights {
namespace {

level::Entity lamp(std::vector<std::pair<std::string, std::string>> more = {}) {
    level::Entity entity;
    entity.pairs = {{"classname", "light"}, {"origin", "1 2 3"}};
    entity.pairs.insert(entity.pairs.end(), more.begin(), more.end());
    return entity;
}

TEST(LightEntity, WhatIsSetIsWhatIsRead) {
    level::Entity entity = lamp();
    EXPECT_EQ(positionOf(entity), Vec3(1, 2, 3));
    EXPECT_EQ(intensityOf(entity), 300.0F);
    EXPECT_EQ(colourOf(entity), Rgb(1.0F));
    setPosition(entity, Vec3(-0.0F, 64.5F, -1.0F / 3.0F));
    setIntensity(entity, 123.4F);
    setColour(entity, Rgb(1.0F, 0.1F, 0.0F));
    EXPECT_EQ(positionOf(entity), Vec3(0.0F, 64.5F, -1.0F / 3.0F));
    EXPECT_EQ(intensityOf(entity), 123.4F);
    EXPECT_EQ(colourOf(entity), Rgb(1.0F, 0.1F, 0.0F));
    EXPECT_EQ(entity.value("light"), "123.4");
    EXPECT_EQ(entity.value("_color"), "1 0.1 0");
}

TEST(LightEntity, IntensityGoesWhereItIsReadAndIsNeverZero) {
    level::Entity entity = lamp({{"light", "5"}, {"_light", "7"}, {"scale", "2"}});
    EXPECT_EQ(intensityOf(entity), 14.0F);
    setIntensity(entity, 30.0F);
    EXPECT_EQ(entity.value("_light"), "15");
    EXPECT_EQ(entity.value("light"), "5");
    EXPECT_EQ(intensityOf(entity), 30.0F);
    for (const float none : {0.0F, std::numeric_limits<float>::quiet_NaN(), 1e-30F}) {
        setIntensity(entity, none);
        EXPECT_EQ(intensityOf(entity), 0.002F) << none;
    }
    setIntensity(entity, -100.0F); // negative lights subtract
    EXPECT_EQ(intensityOf(entity), -100.0F);
}

TEST(LightEntity, NumbersAreWrittenWithoutExponents) {
    level::Entity entity = lamp();
    setPosition(entity, Vec3(1e-7F, 1e20F, -12345.678F));
    EXPECT_EQ(entity.value("origin").find('e'), std::string_view::npos);
    EXPECT_EQ(positionOf(entity).y, 1e20F);
    setColour(entity, Rgb(-1.0F, std::numeric_limits<float>::infinity(), 2.0F));
    EXPECT_EQ(colourOf(entity), Rgb(0.0F, 0.0F, 2.0F));
}

TEST(LightEntity, TheLightIsThatOfTheLevel) {
    level::Level level;
    level.lightEntities = {lamp({{"light", "200"}, {"_color", "1 .5 0"}}), lamp({{"target", "t"}}), lamp()};
    level.lightEntities[2].set("classname", "lightJunior");
    level::Entity target;
    target.pairs = {{"classname", "info_null"}, {"targetname", "t"}, {"origin", "1 2 -97"}};
    level.lightEntities.push_back(target);
    level.lightEntities.push_back(lamp({{"_deviance", "8"}}));
    const ImportedLights imported = importLights(level, {});
    EXPECT_EQ(imported.entities, (std::vector<std::uint32_t>{0, 1, 4}));
    ASSERT_EQ(imported.lights.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto light = lightOf(level, level.lightEntities[imported.entities[i]]);
        ASSERT_TRUE(light);
        EXPECT_EQ(kindName(*light), kindName(imported.lights[i]));
    }
    EXPECT_FALSE(lightOf(level, level.lightEntities[2]));
    EXPECT_FALSE(lightOf(level, target));

    // A spot light that is moved keeps looking at its target.
    level::Entity moved = level.lightEntities[1];
    setPosition(moved, Vec3(101, 2, -97));
    const auto spot = std::get<SpotLight>(lightOf(level, moved).value());
    EXPECT_EQ(spot.position, Vec3(101, 2, -97));
    EXPECT_EQ(spot.direction, Vec3(-1, 0, 0));
}

} // namespace
} // namespace pie::lights
