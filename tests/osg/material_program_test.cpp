// Quake 3 shaders as GLSL programs: text only, no display. That the programs compile and compute what the game's stages
// compute is tested by program_test.cpp.

#include "osgPlugins/osgpie/material_program.h"
#include "tests/osg/glsl_check.h"
#include "tests/osg/scripts.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace {

using namespace osgpie;
using namespace pie::level;
using namespace pie::test;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
}

void expectValid(const MaterialProgram& program, const std::string& what) {
    EXPECT_THAT(glslFaults(program.vertexSource), IsEmpty()) << what << "\n" << program.vertexSource;
    EXPECT_THAT(glslFaults(program.fragmentSource), IsEmpty()) << what << "\n" << program.fragmentSource;
    EXPECT_EQ(glslDeclared(program.vertexSource, "varying"), glslDeclared(program.fragmentSource, "varying")) << what;
    std::size_t samplers = 0;
    for (const std::string& name : glslDeclared(program.fragmentSource, "uniform"))
        samplers += name.starts_with("unit") ? 1U : 0U;
    EXPECT_EQ(samplers, program.units.size()) << what;
}

MaterialProgram make(const std::string& body, const Look& look = {}) {
    MaterialProgram program = makeMaterialProgram(parseScript(body), look);
    expectValid(program, body);
    return program;
}

const std::string lightmapped = "{\nmap $lightmap\n}\n{\nmap t/a.tga\nblendFunc filter\n}";

Look with(LightSource light) {
    Look look;
    look.light = light;
    return look;
}

} // namespace

TEST(GlslCheck, FindsTheFaultsItIsFor) {
    const auto faults = [](const std::string& body) {
        return glslFaults("#version 120\nvoid main() {\n" + body + "}");
    };
    EXPECT_THAT(faults("float a = 1.0, b = sin(a);\n float c = a - b;\n"), IsEmpty());
    EXPECT_THAT(faults("float a = --1.0;\n"), Not(IsEmpty()));
    EXPECT_THAT(faults("float a = nan;\n"), Not(IsEmpty()));
    EXPECT_THAT(faults("float a = 1.0e;\n"), Not(IsEmpty()));
    EXPECT_THAT(faults("float a = b;\n"), Not(IsEmpty()));
    EXPECT_THAT(faults("float a = (1.0;\n"), Not(IsEmpty()));
    EXPECT_THAT(glslFaults("void main() {}"), Not(IsEmpty()));
}

TEST(MaterialProgram, LightmapStageIsOurLight) {
    const MaterialProgram program = make(lightmapped);
    EXPECT_TRUE(program.visible && program.lit && program.depthWrite);
    EXPECT_FALSE(program.blended || program.alphaTested);
    EXPECT_EQ(program.bin, 0);
    ASSERT_EQ(program.units.size(), 1U);
    EXPECT_EQ(program.units[0].source, Stage::Source::Image);
    EXPECT_THAT(program.units[0].images, testing::ElementsAre("t/a.tga"));
    EXPECT_THAT(program.fragmentSource, HasSubstr("vec4(light(), 1.0)"));
}

TEST(MaterialProgram, LightmapGetsOneUnitBehindThePicture) {
    const std::string twice = lightmapped + "\n{\nmap $lightmap\nblendFunc add\n}";
    const MaterialProgram program = make(twice, with(LightSource::Lightmap));
    ASSERT_EQ(program.units.size(), 2U);
    EXPECT_EQ(program.units[0].source, Stage::Source::Image);
    EXPECT_EQ(program.units[1].source, Stage::Source::Lightmap);
    EXPECT_TRUE(program.units[1].clamp) << "a lightmap's edge must not show its other edge";
    EXPECT_EQ(count(program.fragmentSource, "texture2D(unit1"), 2U);
    EXPECT_THAT(program.vertexSource, HasSubstr("vec2 st0 = gl_MultiTexCoord1.st"));
    EXPECT_THAT(program.vertexSource, HasSubstr("vec2 st1 = gl_MultiTexCoord0.st"));
}

TEST(MaterialProgram, LightmapAloneLeavesUnitZeroWhite) {
    const MaterialProgram program = make("{\nmap $lightmap\n}", with(LightSource::Lightmap));
    ASSERT_EQ(program.units.size(), 2U);
    EXPECT_EQ(program.units[0].source, Stage::Source::White);
    EXPECT_EQ(program.units[1].source, Stage::Source::Lightmap);
}

TEST(MaterialProgram, WithoutLightmapTheStageIsWhiteAsInTheGame) {
    const MaterialProgram program = make(lightmapped, with(LightSource::Vertex));
    EXPECT_EQ(program.units.size(), 1U);
    EXPECT_THAT(program.fragmentSource, Not(HasSubstr("vec4(light(), 1.0)")));
    EXPECT_THAT(make("{\nmap t/a.tga\nrgbGen vertex\n}", with(LightSource::Vertex)).fragmentSource,
                HasSubstr("t.rgb * light()"));
}

TEST(MaterialProgram, FullBrightShowsNoLight) {
    const MaterialProgram program = make(lightmapped, with(LightSource::None));
    EXPECT_THAT(program.fragmentSource, HasSubstr("vec3 light() { return vec3(1.0); }"));
    EXPECT_THAT(program.fragmentSource, Not(HasSubstr("unit1")));
}

TEST(MaterialProgram, OneBlendedStageKeepsItsBlendFunction) {
    const std::vector<std::pair<std::string, BlendFactor>> sources{
        {"GL_ONE", BlendFactor::One},
        {"GL_ZERO", BlendFactor::Zero},
        {"GL_DST_COLOR", BlendFactor::DestinationColour},
        {"GL_ONE_MINUS_DST_COLOR", BlendFactor::OneMinusDestinationColour},
        {"GL_SRC_ALPHA", BlendFactor::SourceAlpha},
        {"GL_ONE_MINUS_SRC_ALPHA", BlendFactor::OneMinusSourceAlpha}};
    const std::vector<std::pair<std::string, BlendFactor>> destinations{
        {"GL_ONE", BlendFactor::One},
        {"GL_SRC_COLOR", BlendFactor::SourceColour},
        {"GL_ONE_MINUS_SRC_COLOR", BlendFactor::OneMinusSourceColour},
        {"GL_SRC_ALPHA", BlendFactor::SourceAlpha},
        {"GL_ONE_MINUS_SRC_ALPHA", BlendFactor::OneMinusSourceAlpha}};
    for (const auto& [source, s] : sources)
        for (const auto& [destination, d] : destinations) {
            const MaterialProgram program =
                make(fmt::format("{{\nmap t/a.tga\nblendFunc {} {}\nrgbGen identity\n}}", source, destination));
            EXPECT_TRUE(program.blended);
            EXPECT_EQ(program.blend, (Blend{s, d})) << source << " " << destination;
            EXPECT_FALSE(program.depthWrite);
            EXPECT_THAT(program.fragmentSource, HasSubstr("gl_FragColor = single;"));
            EXPECT_GE(program.bin, 10) << "drawn behind what is opaque";
        }
}

TEST(MaterialProgram, SeveralBlendedStagesEndInOneBlendFunction) {
    const std::string add = "{\nmap t/a.tga\nblendFunc add\n}\n";
    const std::string filter = "{\nmap t/b.tga\nblendFunc filter\n}\n";
    const std::string mix = "{\nmap t/c.tga\nblendFunc blend\n}\n";
    EXPECT_EQ(make(add + add).blend, (Blend{BlendFactor::One, BlendFactor::One}));
    EXPECT_EQ(make(filter + filter).blend, (Blend{BlendFactor::Zero, BlendFactor::SourceColour}));
    EXPECT_EQ(make(add + filter).blend, (Blend{BlendFactor::One, BlendFactor::SourceAlpha}));
    EXPECT_EQ(make(mix + add).blend, (Blend{BlendFactor::One, BlendFactor::SourceAlpha}));
    EXPECT_FALSE(make(lightmapped + "\n" + add).blended) << "the first stage covers all";
}

TEST(MaterialProgram, AlphaTestsDiscardOrSkip) {
    const std::vector<std::pair<std::string, std::string>> tests{
        {"GT0", "srcA > 0.0"}, {"LT128", "srcA < 0.5"}, {"GE128", "srcA >= 0.5"}};
    for (const auto& [name, condition] : tests) {
        const std::string stage = "{\nmap t/a.tga\nalphaFunc " + name;
        const MaterialProgram first = make(stage + "\n}");
        EXPECT_TRUE(first.alphaTested);
        EXPECT_FALSE(first.blended) << "cut out, with depth";
        EXPECT_TRUE(first.depthWrite);
        EXPECT_THAT(first.fragmentSource, HasSubstr("if (!(" + condition + ")) discard;"));
        const MaterialProgram second = make("{\nmap t/b.tga\n}\n" + stage + "\nblendFunc blend\n}");
        EXPECT_FALSE(second.alphaTested) << "only the second stage is cut out, not the surface";
        EXPECT_THAT(second.fragmentSource, Not(HasSubstr("discard")));
        EXPECT_THAT(second.fragmentSource, HasSubstr("if (" + condition + ") {"));
    }
}

TEST(MaterialProgram, NegativeNumbersMakeNoDecrements) {
    const MaterialProgram program =
        make("deformVertexes wave -100 sin -3 -2 -0.5 -1\ndeformVertexes bulge -3 -2 -1\n"
             "deformVertexes move -1 -2 -3 sin -1 -2 -0.5 -1\n"
             "{\nmap t/a.tga\ntcMod scroll -1 -2\ntcMod scale -1 -0.5\ntcMod rotate -30\n"
             "tcMod stretch sin -1 -0.2 -0.5 -2\ntcMod transform -1 -2 -3 -4 -5 -6\ntcMod turb -1 -0.1 -0.5 -2\n"
             "tcGen vector ( -1 -2 -3 ) ( -4 -5 -6 )\nrgbGen wave inversesawtooth -1 -2 -3 -4\n"
             "alphaGen wave noise -1 -2 -3 -4\n}");
    for (const std::string& source : {program.vertexSource, program.fragmentSource})
        EXPECT_THAT(source, Not(HasSubstr("--")));
    EXPECT_THAT(program.vertexSource, HasSubstr("radians(-(-30.0) * TIME)"));
}

TEST(MaterialProgram, HostileNumbersStayNumbers) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    constexpr float huge = std::numeric_limits<float>::max();
    constexpr float tiny = std::numeric_limits<float>::denorm_min();
    for (const float value : {infinity, -infinity, std::nanf(""), huge, -huge, tiny, 1e10F, -1e-10F}) {
        Shader shader = parseScript("deformVertexes wave 100 sin 0 1 0 1\n{\nmap t/a.tga\ntcMod scroll 1 1\n"
                                    "tcMod turb 0 1 0 1\nrgbGen const ( 1 1 1 )\nalphaGen const 1\n}");
        shader.deforms.front().spread = value;
        shader.deforms.front().wave.amplitude = value;
        Stage& stage = shader.stages.front();
        stage.tcMods[0].values = {value, value, value, value, value, value};
        stage.tcMods[1].wave = {WaveForm::Sine, value, value, value, value};
        stage.rgbConstant = pie::Rgb(value);
        stage.alphaConstant = value;
        expectValid(makeMaterialProgram(shader, {}), std::to_string(value));
    }
}

TEST(MaterialProgram, WavesOfEveryFormAreCalled) {
    const std::vector<std::string> forms{"sin", "triangle", "square", "sawtooth", "inversesawtooth", "noise"};
    for (std::size_t i = 0; i < forms.size(); ++i) {
        const MaterialProgram program = make("{\nmap t/a.tga\nrgbGen wave " + forms[i] + " 0.5 0.25 0.125 2\n}");
        EXPECT_THAT(program.fragmentSource, HasSubstr("wave(" + std::to_string(i) + ", 0.5, 0.25, 0.125 + 0.0, 2.0)"));
    }
}

TEST(MaterialProgram, TimeStandsStillWhenAsked) {
    const std::string moving = "{\nmap t/a.tga\ntcMod scroll 1 0\n}";
    Look look;
    EXPECT_THAT(make(moving, look).vertexSource, HasSubstr("uniform float osg_FrameTime;"));
    look.animate = false;
    const MaterialProgram program = make(moving, look);
    EXPECT_THAT(program.vertexSource, Not(HasSubstr("osg_FrameTime")));
    EXPECT_THAT(program.fragmentSource, Not(HasSubstr("osg_FrameTime")));
}

TEST(MaterialProgram, AnimatedPicturesAreKept) {
    const MaterialProgram program =
        make("{\nanimMap 4 t/a.tga t/b.tga t/c.tga\n}\n{\nclampMap t/d.tga\nblendFunc add\n}");
    ASSERT_EQ(program.units.size(), 2U);
    EXPECT_THAT(program.units[0].images, testing::ElementsAre("t/a.tga", "t/b.tga", "t/c.tga"));
    EXPECT_EQ(program.units[0].framesPerSecond, 4.0F);
    EXPECT_FALSE(program.units[0].clamp);
    EXPECT_TRUE(program.units[1].clamp);
}

TEST(MaterialProgram, LightViewShowsLightWithoutTexturesAndKeepsHoles) {
    Look look;
    look.textures = false;
    const MaterialProgram cut = make("{\nmap t/a.tga\nalphaFunc GE128\n}\n{\nmap $lightmap\nblendFunc filter\n}", look);
    EXPECT_TRUE(cut.visible);
    EXPECT_THAT(cut.fragmentSource, HasSubstr("vec4(vec3(1.0), texture2D(unit0, tc0).a)"));
    EXPECT_THAT(cut.fragmentSource, HasSubstr("discard"));
    EXPECT_FALSE(makeMaterialProgram(parseScript("{\nmap t/a.tga\nblendFunc add\n}"), look).visible)
        << "what only glows shows no light";
}

TEST(MaterialProgram, NothingToDrawIsNotVisible) {
    EXPECT_FALSE(makeMaterialProgram(parseScript("qer_editorimage t/a.tga"), {}).visible);
}

TEST(MaterialProgram, DrawOrderFollowsTheGamesSort) {
    const std::string opaque = "{\nmap t/a.tga\n}";
    const std::string blended = "{\nmap t/a.tga\nblendFunc blend\n}";
    const auto bin = [](const std::string& body) { return make(body).bin; };
    EXPECT_EQ(bin(opaque), 0);
    EXPECT_GT(bin("polygonOffset\n" + opaque), 0) << "decals after what they lie on";
    EXPECT_LT(bin("polygonOffset\n" + opaque), bin(blended));
    EXPECT_LT(bin("sort underwater\n" + blended), bin(blended));
    EXPECT_LT(bin(blended), bin("sort nearest\n" + blended));
    EXPECT_LT(bin("sort seeThrough\n" + blended), bin(blended));
}

TEST(MaterialProgram, EveryCombinationIsWellFormed) {
    std::size_t made = 0;
    for (const std::string& body : scriptCollection())
        for (const Look& look : allLooks()) {
            const MaterialProgram program = makeMaterialProgram(parseScript(body), look);
            if (!program.visible) continue;
            ++made;
            expectValid(program, body);
            if (HasFailure()) return;
        }
    EXPECT_GT(made, 1000U);
}

TEST(SkyProgram, BoxIsSixClampedPicturesInTheOrderOfTheCube) {
    const Shader sky =
        parseScript("skyParms env/space 512 -\n{\nmap t/cloud.tga\ntcMod scroll -0.1 0.1\nblendFunc add\n}");
    const MaterialProgram program = makeSkyProgram(sky, with(LightSource::None));
    expectValid(program, "sky");
    ASSERT_EQ(program.units.size(), 7U);
    const std::vector<std::string> order{"rt", "lf", "bk", "ft", "up", "dn"}; // +x −x +y −y up down
    for (std::size_t i = 0; i < order.size(); ++i) {
        EXPECT_THAT(program.units[i].images, testing::ElementsAre(testing::StartsWith("env/space_" + order[i])));
        EXPECT_TRUE(program.units[i].clamp);
    }
    EXPECT_THAT(program.fragmentSource, HasSubstr("b = box(n)"));
    EXPECT_THAT(program.fragmentSource, Not(HasSubstr("b = src"))) << "clouds that blend replace the box";
    EXPECT_THAT(program.vertexSource, HasSubstr("p.xyww"));
    EXPECT_FALSE(program.depthWrite);
}

TEST(SkyProgram, CloudsAloneNeedNoBox) {
    for (const char* parms : {"skyParms - 512 -", "skyParms - - -"}) {
        const MaterialProgram program = makeSkyProgram(
            parseScript(std::string(parms) + "\n{\nmap t/cloud.tga\n}\n{\nmap t/more.tga\nblendFunc blend\n}"), {});
        expectValid(program, parms);
        EXPECT_EQ(program.units.size(), 2U);
        EXPECT_THAT(program.fragmentSource, Not(HasSubstr("box(n)")));
        EXPECT_THAT(program.fragmentSource, HasSubstr("cloud(n)"));
        EXPECT_THAT(program.fragmentSource, HasSubstr("b = src"));
    }
    EXPECT_FALSE(makeSkyProgram(parseScript("skyParms - 512 -"), {}).visible);
}

TEST(SkyProgram, EveryCombinationIsWellFormed) {
    for (const std::string& body : scriptCollection())
        for (const Look& look : allLooks()) {
            const MaterialProgram program = makeSkyProgram(parseScript("skyParms env/space 256 -\n" + body), look);
            ASSERT_TRUE(program.visible);
            expectValid(program, body);
            if (HasFailure()) return;
        }
}
