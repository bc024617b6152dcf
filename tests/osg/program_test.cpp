// The generated programs in a real OpenGL: all compile and link, and what they compute is what the game's stages,
// blended into the frame one after the other, would have computed.

#include "osgPlugins/osgpie/material_program.h"
#include "tests/level/make_level.h"
#include "tests/osg/link_check.h"
#include "tests/osg/offscreen.h"
#include "tests/osg/scene_reading.h"
#include "tests/osg/scripts.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace {

using namespace osgpie;
using namespace pie;
using namespace pie::test;
using pie::level::Blend;
using pie::level::BlendFactor;
using Colour = std::array<double, 4>;

/// What the game does with one stage: the frame afterwards. Every value is cut to 0…1, as a frame of bytes cuts it.
Colour blended(const Blend& blend, const Colour& source, const Colour& frame) {
    const auto factor = [&](BlendFactor f, std::size_t c) {
        switch (f) {
        case BlendFactor::Zero: return 0.0;
        case BlendFactor::One: return 1.0;
        case BlendFactor::SourceColour: return source[c];
        case BlendFactor::OneMinusSourceColour: return 1 - source[c];
        case BlendFactor::DestinationColour: return frame[c];
        case BlendFactor::OneMinusDestinationColour: return 1 - frame[c];
        case BlendFactor::SourceAlpha: return source[3];
        case BlendFactor::OneMinusSourceAlpha: return 1 - source[3];
        default: return 1.0;
        }
    };
    Colour result = frame;
    for (std::size_t c = 0; c < 3; ++c)
        result[c] = std::clamp(source[c] * factor(blend.source, c) + frame[c] * factor(blend.destination, c), 0.0, 1.0);
    return result;
}

struct NamedBlend {
    const char* text;
    Blend blend;
};
constexpr std::array<NamedBlend, 10> blends{{
    {"GL_ONE GL_ONE", {BlendFactor::One, BlendFactor::One}},
    {"GL_ONE GL_ZERO", {BlendFactor::One, BlendFactor::Zero}},
    {"GL_DST_COLOR GL_ZERO", {BlendFactor::DestinationColour, BlendFactor::Zero}},
    {"GL_ZERO GL_SRC_COLOR", {BlendFactor::Zero, BlendFactor::SourceColour}},
    {"GL_ZERO GL_ONE_MINUS_SRC_COLOR", {BlendFactor::Zero, BlendFactor::OneMinusSourceColour}},
    {"GL_SRC_ALPHA GL_ONE_MINUS_SRC_ALPHA", {BlendFactor::SourceAlpha, BlendFactor::OneMinusSourceAlpha}},
    {"GL_ONE_MINUS_SRC_ALPHA GL_SRC_ALPHA", {BlendFactor::OneMinusSourceAlpha, BlendFactor::SourceAlpha}},
    {"GL_SRC_ALPHA GL_ONE", {BlendFactor::SourceAlpha, BlendFactor::One}},
    {"GL_ONE_MINUS_DST_COLOR GL_ONE", {BlendFactor::OneMinusDestinationColour, BlendFactor::One}},
    {"GL_DST_COLOR GL_SRC_COLOR", {BlendFactor::DestinationColour, BlendFactor::SourceColour}},
}};

const std::array<std::pair<const char*, Rgba8>, 3> pictures{
    {{"t/red", {180, 40, 20, 255}}, {"t/blue", {30, 90, 200, 64}}, {"t/grey", {120, 120, 120, 160}}}};

Colour toColour(const Rgba8& c) { return {c.r / 255.0, c.g / 255.0, c.b / 255.0, c.a / 255.0}; }

/// A stage: which picture, which blend.
using StageChoice = std::pair<std::size_t, std::size_t>;

std::string scriptOf(const std::string& name, const std::vector<StageChoice>& stages) {
    std::string text = name + "\n{\nsurfaceparm nolightmap\n";
    for (const auto& [picture, blend] : stages)
        text += fmt::format("{{\nmap {}.tga\nblendFunc {}\nrgbGen identity\n}}\n", pictures.at(picture).first,
                            blends.at(blend).text);
    return text + "}\n";
}

/// Squares in a row, each before the same backdrop; the middle of square i in the picture. One shot shows all.
class Row {
public:
    std::size_t add(const std::vector<StageChoice>& stages) {
        const std::string name = fmt::format("t/case{}", cases_.size());
        script_ += scriptOf(name, stages);
        cases_.push_back(stages);
        return cases_.size() - 1;
    }
    /// Empty where it cannot be drawn.
    [[nodiscard]] std::vector<Colour> draw() const {
        const Game game;
        for (const auto& [name, colour] : pictures) game.addPicture(name, colour);
        game.addPicture("t/backdrop", backdrop);
        game.addScript(script_);
        LevelBuilder builder;
        const auto square = [&](const std::string& shader, std::size_t i, float z) {
            const std::size_t row = i / columns;
            const float x = static_cast<float>(i % columns) * size;
            const float y = static_cast<float>(row) * size;
            builder.polygon(builder.shader(shader),
                            {{x, y, z}, {x + size, y, z}, {x + size, y + size, z}, {x, y + size, z}});
        };
        for (std::size_t i = 0; i < cases_.size(); ++i) {
            square("t/backdrop", i, 0);
            square(fmt::format("t/case{}", i), i, 8);
        }
        const osg::ref_ptr<osg::Node> node = readNode(game.addLevel("row", builder.build()), "view=fullbright");
        if (!node) return {};
        const std::size_t rows = (cases_.size() + columns - 1) / columns;
        Shot shot = fromAbove(0, columns * double{size}, 0, static_cast<double>(rows) * double{size});
        shot.width = static_cast<int>(columns) * pixels;
        shot.height = static_cast<int>(rows) * pixels;
        const Picture picture = render(*node, shot);
        std::vector<Colour> seen;
        for (std::size_t i = 0; i < cases_.size() && !picture.empty(); ++i) {
            const std::size_t x = (i % columns) * pixels + pixels / 2;
            const std::size_t y = (rows - 1 - i / columns) * pixels + pixels / 2; // rows of the picture run downwards
            const std::uint8_t* p = &picture.rgb[3 * (y * static_cast<std::size_t>(picture.width) + x)];
            seen.push_back({p[0] / 255.0, p[1] / 255.0, p[2] / 255.0, 1});
        }
        return seen;
    }
    [[nodiscard]] Colour expected(std::size_t i) const {
        Colour frame = toColour(backdrop);
        for (const auto& [picture, blend] : cases_[i])
            frame = blended(blends.at(blend).blend, toColour(pictures.at(picture).second), frame);
        return frame;
    }
    [[nodiscard]] std::string describe(std::size_t i) const { return scriptOf(fmt::format("t/case{}", i), cases_[i]); }
    [[nodiscard]] std::size_t count() const { return cases_.size(); }

private:
    static constexpr Rgba8 backdrop{100, 160, 60, 255};
    static constexpr std::size_t columns = 30;
    static constexpr int pixels = 8;
    static constexpr float size = 32;
    std::vector<std::vector<StageChoice>> cases_;
    std::string script_;
};

void expectGamesColours(const Row& row, double tolerance) {
    const std::vector<Colour> seen = row.draw();
    ASSERT_EQ(seen.size(), row.count());
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const Colour expected = row.expected(i);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(seen[i][c], expected[c], tolerance / 255) << "channel " << c << " of\n" << row.describe(i);
    }
}

} // namespace

TEST(GlPrograms, EveryCombinationLinks) {
    PIE_NEED_DISPLAY();
    LinkCheck check;
    if (!check.ready()) GTEST_SKIP() << noDisplay;
    const std::vector<Look> looks = allLooks();
    // Every seventh: 7 and 128 have no common factor, so that all looks meet all kinds of stages.
    std::size_t at = 0;
    std::size_t linked = 0;
    for (const std::string& body : scriptCollection()) {
        const level::Shader shader = parseScript(body);
        for (std::size_t i = at++ % 7; i < looks.size(); i += 21) {
            const MaterialProgram program = makeMaterialProgram(shader, looks[i]);
            if (!program.visible) continue;
            ++linked;
            EXPECT_EQ(check.fault(program.vertexSource, program.fragmentSource), "") << body << program.fragmentSource;
        }
        const level::Shader sky = parseScript("skyParms env/box 512 -\n" + body);
        const MaterialProgram program = makeSkyProgram(sky, looks[at % looks.size()]);
        EXPECT_EQ(check.fault(program.vertexSource, program.fragmentSource), "") << body << program.fragmentSource;
    }
    EXPECT_GT(linked, 200U);
}

TEST(GlPrograms, AFaultIsFound) {
    PIE_NEED_DISPLAY();
    LinkCheck check;
    if (!check.ready()) GTEST_SKIP() << noDisplay;
    const std::string vertex = "#version 120\nvoid main() { gl_Position = gl_Vertex; }\n";
    EXPECT_EQ(check.fault(vertex, "#version 120\nvoid main() { gl_FragColor = vec4(1.0); }\n"), "");
    EXPECT_NE(check.fault(vertex, "#version 120\nvoid main() { gl_FragColor = vec4(--1.0); }\n"), "");
    EXPECT_NE(check.fault(vertex, "#version 120\nvarying vec2 a;\nvoid main() { gl_FragColor = vec4(a, a); }\n"), "");
}

TEST(GlStages, OneStageIsTheGamesBlendFunction) {
    PIE_NEED_DISPLAY();
    Row row;
    for (std::size_t picture = 0; picture < pictures.size(); ++picture)
        for (std::size_t blend = 0; blend < blends.size(); ++blend) row.add({{picture, blend}});
    expectGamesColours(row, 1.5);
}

TEST(GlStages, TwoAndThreeStagesOnAnOpaqueOneAreComposedExactly) {
    PIE_NEED_DISPLAY();
    constexpr std::size_t replace = 1;
    Row row;
    for (std::size_t a = 0; a < blends.size(); ++a)
        for (std::size_t b = 0; b < blends.size(); ++b) row.add({{2, replace}, {a % 3, a}, {(a + b) % 3, b}});
    expectGamesColours(row, 1.5);
}

TEST(GlStages, SeveralBlendedStagesOfOneKindAreComposedExactly) {
    PIE_NEED_DISPLAY();
    Row row;
    for (const std::size_t add : {0U, 7U}) row.add({{1, add}, {1, 0}});           // sums
    for (const std::size_t filter : {2U, 3U, 4U}) row.add({{0, filter}, {2, 2}}); // products
    row.add({{2, 5}, {2, 5}}); // grey alpha: one number scales the frame
    row.add({{1, 5}, {1, 7}});
    expectGamesColours(row, 2.5); // the game rounds the frame to bytes between its stages
}
