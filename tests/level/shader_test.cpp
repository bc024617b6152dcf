#include "pie/level/shader.h"
#include "pie/level/vfs.h"
#include "tests/level/make_level.h"

#include <gtest/gtest.h>

using namespace pie;
using namespace pie::level;
using namespace pie::test;

namespace {

/// The shader "t/x" with this body.
Shader parse(const std::string& body) {
    ShaderLibrary library;
    library.parse("t/x\n{\n" + body + "\n}\n", "scripts/test.shader");
    const Shader* shader = library.find("T/X.tga");
    EXPECT_NE(shader, nullptr) << body;
    return shader == nullptr ? Shader{} : *shader;
}

Stage stage(const std::string& body) {
    const Shader shader = parse("{\nmap a.tga\n" + body + "\n}");
    EXPECT_EQ(shader.stages.size(), 1U) << body;
    EXPECT_TRUE(shader.defects.empty()) << shader.defects.front();
    return shader.stages.empty() ? Stage{} : shader.stages.front();
}

} // namespace

TEST(Shader, UnsetValuesGetTheGamesDefaults) {
    const Stage plain = stage("");
    EXPECT_EQ(plain.images, std::vector<std::string>{"a.tga"});
    EXPECT_EQ(plain.rgbGen, RgbGen::IdentityLighting);
    EXPECT_EQ(plain.alphaGen, AlphaGen::Identity);
    EXPECT_EQ(plain.tcGen, TcGen::Texture);
    EXPECT_EQ(plain.alphaTest, AlphaTest::None);
    EXPECT_TRUE(plain.blend.opaque());
    EXPECT_TRUE(plain.depthWrite);
    EXPECT_FALSE(plain.clamp);

    const Stage add = stage("blendFunc add");
    EXPECT_EQ(add.blend, (Blend{BlendFactor::One, BlendFactor::One}));
    EXPECT_EQ(add.rgbGen, RgbGen::IdentityLighting);
    EXPECT_FALSE(add.depthWrite);
    const Stage blend = stage("blendfunc BLEND\ndepthWrite");
    EXPECT_EQ(blend.blend, (Blend{BlendFactor::SourceAlpha, BlendFactor::OneMinusSourceAlpha}));
    EXPECT_EQ(blend.rgbGen, RgbGen::IdentityLighting);
    EXPECT_TRUE(blend.depthWrite);
    const Stage filter = stage("blendfunc filter");
    EXPECT_EQ(filter.blend, (Blend{BlendFactor::DestinationColour, BlendFactor::Zero}));
    EXPECT_EQ(filter.rgbGen, RgbGen::Identity);
    const Stage replace = stage("blendfunc GL_ONE GL_ZERO");
    EXPECT_TRUE(replace.blend.opaque());
    EXPECT_TRUE(replace.depthWrite);
}

TEST(Shader, BlendFactorsHaveTheirSides) {
    EXPECT_EQ(stage("blendFunc GL_ZERO GL_ONE_MINUS_SRC_COLOR").blend,
              (Blend{BlendFactor::Zero, BlendFactor::OneMinusSourceColour}));
    EXPECT_EQ(stage("blendFunc GL_DST_COLOR GL_SRC_ALPHA").blend,
              (Blend{BlendFactor::DestinationColour, BlendFactor::SourceAlpha}));
    EXPECT_EQ(stage("blendFunc GL_ONE_MINUS_DST_ALPHA GL_DST_ALPHA").blend,
              (Blend{BlendFactor::OneMinusDestinationAlpha, BlendFactor::DestinationAlpha}));
    // Words of the wrong side and unknown ones count as GL_ONE.
    EXPECT_EQ(stage("blendFunc GL_SRC_COLOR GL_DST_COLOR").blend, (Blend{BlendFactor::One, BlendFactor::One}));
    EXPECT_EQ(stage("blendFunc nonsense GL_ZERO").blend, (Blend{BlendFactor::One, BlendFactor::Zero}));
}

TEST(Shader, StageKeywords) {
    EXPECT_EQ(stage("alphaFunc GE128").alphaTest, AlphaTest::GreaterEqual128);
    EXPECT_EQ(stage("alphaFunc lt128").alphaTest, AlphaTest::Less128);
    EXPECT_EQ(stage("alphafunc GT0").alphaTest, AlphaTest::GreaterZero);
    EXPECT_TRUE(stage("depthFunc equal").depthEqual);
    EXPECT_FALSE(stage("depthFunc lequal").depthEqual);
    EXPECT_TRUE(stage("detail").detail);
    EXPECT_EQ(stage("tcGen environment").tcGen, TcGen::Environment);
    EXPECT_EQ(stage("texgen lightmap").tcGen, TcGen::Lightmap);
    EXPECT_EQ(stage("tcGen base").tcGen, TcGen::Texture);
    const Stage vector = stage("tcGen vector ( 1 0 0 ) ( 0 .5 0 )");
    EXPECT_EQ(vector.tcGen, TcGen::Vector);
    EXPECT_EQ(vector.tcVectors[1], Vec3(0, 0.5F, 0));
    const Stage constant = stage("rgbGen const ( 1 0.5 0.25 )\nalphaGen const 0.75");
    EXPECT_EQ(constant.rgbGen, RgbGen::Constant);
    EXPECT_EQ(constant.rgbConstant, Rgb(1, 0.5F, 0.25F));
    EXPECT_EQ(constant.alphaGen, AlphaGen::Constant);
    EXPECT_EQ(constant.alphaConstant, 0.75F);
    const Stage wave = stage("rgbGen wave inversesawtooth 1 2 3 4");
    EXPECT_EQ(wave.rgbGen, RgbGen::Wave);
    EXPECT_EQ(wave.rgbWave.form, WaveForm::InverseSawtooth);
    EXPECT_EQ(wave.rgbWave.frequency, 4);
    // Vertex colours bring their alpha along, exact ones do not.
    EXPECT_EQ(stage("rgbGen vertex").alphaGen, AlphaGen::Vertex);
    EXPECT_EQ(stage("alphaGen oneMinusVertex\nrgbGen vertex").alphaGen, AlphaGen::OneMinusVertex);
    EXPECT_EQ(stage("rgbGen exactVertex").alphaGen, AlphaGen::Identity);
}

TEST(Shader, TextureModifiersKeepTheirOrder) {
    const Stage s = stage("tcMod scroll 1 2\ntcmod scale 3 4\ntcMod rotate 5\ntcMod stretch sin 1 2 3 4\ntcMod "
                          "transform 1 2 3 4 5 6\ntcMod turb 0 .1 .2 .3\ntcMod nothing 1");
    ASSERT_EQ(s.tcMods.size(), 6U);
    EXPECT_EQ(s.tcMods[0].kind, TcModKind::Scroll);
    EXPECT_EQ(s.tcMods[0].values[1], 2);
    EXPECT_EQ(s.tcMods[1].kind, TcModKind::Scale);
    EXPECT_EQ(s.tcMods[2].values[0], 5);
    EXPECT_EQ(s.tcMods[3].wave.amplitude, 2);
    EXPECT_EQ(s.tcMods[4].values[5], 6);
    EXPECT_EQ(s.tcMods[5].kind, TcModKind::Turbulence);
    EXPECT_FLOAT_EQ(s.tcMods[5].wave.frequency, 0.3F);
}

TEST(Shader, StagesMayShowLightmapWhiteOrFrames) {
    const Shader shader = parse("{\nmap $lightmap\n}\n{\nmap $whiteimage\nblendfunc filter\n}\n{\nanimMap 10 a b c d e "
                                "f g h i\n}\n{\nclampmap c.tga\n}");
    ASSERT_EQ(shader.stages.size(), 4U);
    EXPECT_EQ(shader.stages[0].source, Stage::Source::Lightmap);
    EXPECT_EQ(shader.stages[0].tcGen, TcGen::Lightmap);
    EXPECT_EQ(shader.stages[1].source, Stage::Source::White);
    EXPECT_EQ(shader.stages[2].images.size(), 8U);
    EXPECT_EQ(shader.stages[2].framesPerSecond, 10);
    EXPECT_TRUE(shader.stages[3].clamp);
    EXPECT_TRUE(shader.opaque());
    EXPECT_TRUE(shader.drawn());
}

TEST(Shader, GeneralKeywords) {
    const Shader s = parse(
        "cull disable\nsurfaceparm trans\nsurfaceparm LAVA\nsurfaceparm detail\npolygonOffset\nqer_editorimage e.tga\n"
        "fogparms ( .1 .2 .3 ) 400\ndeformVertexes wave 64 sin 1 2 3 4\ndeformVertexes move 1 2 3 square 0 1 0 "
        "2\nq3map_tesssize 4\nnopicmip\nlight 1\n{\nmap x\n}");
    EXPECT_TRUE(s.defects.empty());
    EXPECT_TRUE(s.twoSided());
    EXPECT_TRUE(s.parms.translucent);
    EXPECT_TRUE(s.parms.lava);
    EXPECT_FALSE(s.parms.structural);
    EXPECT_TRUE(s.polygonOffset);
    EXPECT_EQ(s.sort, 4);
    EXPECT_EQ(s.editorImage, "e.tga");
    ASSERT_TRUE(s.fog);
    EXPECT_EQ(s.fog->colour, Rgb(.1F, .2F, .3F));
    EXPECT_EQ(s.fog->opaqueDistance, 400);
    ASSERT_EQ(s.deforms.size(), 2U);
    EXPECT_FLOAT_EQ(s.deforms[0].spread, 1 / 64.0F);
    EXPECT_EQ(s.deforms[1].direction, Vec3(1, 2, 3));
    EXPECT_EQ(s.deforms[1].wave.form, WaveForm::Square);
    EXPECT_EQ(s.origin, "scripts/test.shader:1");
    EXPECT_EQ(parse("cull back\n{\nmap x\n}").cull, Cull::Back);
    EXPECT_EQ(parse("cull front\n{\nmap x\n}").cull, Cull::Front);
}

TEST(Shader, SortFollowsTheGame) {
    const auto sort = [](const std::string& body) { return parse(body).sort.value_or(-1); };
    EXPECT_EQ(sort("{\nmap x\n}"), 3);
    EXPECT_EQ(sort("{\nmap x\nblendfunc blend\n}"), 9);
    EXPECT_EQ(sort("{\nmap x\nblendfunc blend\ndepthwrite\n}"), 5);
    EXPECT_EQ(sort("{\nmap x\n}\n{\nmap y\nblendfunc add\n}"), 3);
    EXPECT_EQ(sort("sort additive\n{\nmap x\n}"), 10);
    EXPECT_EQ(sort("sort 7.5\n{\nmap x\n}"), 7.5F);
    EXPECT_EQ(sort("portal\n{\nmap x\nblendfunc blend\n}"), 1);
    EXPECT_EQ(sort("skyparms env/x - -\nsort nearest"), 2);
}

TEST(Shader, LightKeys) {
    const Shader s = parse("q3map_surfacelight 1500\nq3map_lightRGB 1 .5 .25\nq3map_lightimage l.tga\nq3map_backsplash "
                           "2 16\nq3map_bounceScale 1.5\n"
                           "q3map_sun .5 .25 .125 100 45 60\nq3map_sunExt 1 1 1 50 0 90 2 16\nsun 0 0 0 10 1 "
                           "2\nq3map_skyLight 200 5\nq3map_skylight 1 1\n{\nmap x\n}");
    EXPECT_TRUE(s.defects.empty());
    EXPECT_EQ(s.light.surfaceLight, 1500);
    EXPECT_EQ(s.light.colour, Rgb(1, .5F, .25F));
    EXPECT_EQ(s.light.lightImage, "l.tga");
    EXPECT_EQ(s.light.backsplashPercent, 2);
    EXPECT_EQ(s.light.backsplashDistance, 16);
    EXPECT_EQ(s.light.bounce, 1.5F);
    ASSERT_EQ(s.light.suns.size(), 3U);
    EXPECT_EQ(s.light.suns[0].colour, Rgb(1, .5F, .25F)); // over its largest channel
    EXPECT_EQ(s.light.suns[0].intensity, 100);
    EXPECT_EQ(s.light.suns[0].degrees, 45);
    EXPECT_EQ(s.light.suns[0].elevation, 60);
    EXPECT_EQ(s.light.suns[1].deviance, 2);
    EXPECT_EQ(s.light.suns[1].samples, 16);
    EXPECT_EQ(s.light.suns[2].colour, Rgb(1));
    ASSERT_EQ(s.light.skyLights.size(), 2U);
    EXPECT_EQ(s.light.skyLights[0].value, 200);
    EXPECT_EQ(s.light.skyLights[0].iterations, 5);
    EXPECT_EQ(s.light.skyLights[1].iterations, 2);
}

TEST(Shader, SkiesAndWhatIsNeverShown) {
    const Shader sky = parse("surfaceparm sky\nskyparms env/moon 1024 -\n{\nmap clouds\n}");
    EXPECT_EQ(sky.skyBox, "env/moon");
    EXPECT_EQ(sky.cloudHeight, 1024);
    EXPECT_FALSE(sky.drawn());
    const Shader cloudsOnly = parse("skyparms - 0 -\n{\nmap clouds\n}");
    EXPECT_EQ(cloudsOnly.cloudHeight, 512);
    EXPECT_TRUE(cloudsOnly.parms.sky);
    EXPECT_FALSE(cloudsOnly.drawn());
    // Without skyparms the game draws the stages.
    EXPECT_TRUE(parse("surfaceparm sky\n{\nmap stars\n}").drawn());
    for (const char* parm : {"nodraw", "trigger", "areaportal", "hint", "skip"})
        EXPECT_FALSE(parse(std::string("surfaceparm ") + parm + "\n{\nmap x\n}").drawn()) << parm;
    EXPECT_FALSE(parse("surfaceparm fog\nfogparms ( 1 1 1 ) 100").drawn());
    EXPECT_TRUE(parse("surfaceparm playerclip\n{\nmap x\n}").drawn());
}

TEST(Shader, WhatTheGameRefusesIsTold) {
    const auto defect = [](const std::string& body) {
        const Shader s = parse(body);
        EXPECT_EQ(s.defects.size(), 1U) << body;
        return s.defects.empty() ? std::string() : s.defects.front();
    };
    EXPECT_EQ(defect("frobnicate 1 2 3\n{\nmap x\n}"), "scripts/test.shader:3: unknown keyword 'frobnicate'");
    EXPECT_EQ(defect("{\nmap x\nfrob 1\n}"), "scripts/test.shader:5: unknown keyword 'frob' in a stage");
    EXPECT_NE(defect("fogparms (1 1 1) 100\n{\nmap x\n}").find("expected ( number number number )"), std::string::npos);
    EXPECT_NE(defect("{\nmap x\n}\n{\nmap x\n}\n{\nmap x\n}\n{\nmap x\n}\n{\nmap x\n}\n{\nmap x\n}\n{\nmap "
                     "x\n}\n{\nmap x\n}\n{\nmap x\n}")
                  .find("more than 8 stages"),
              std::string::npos);
    EXPECT_EQ(parse("frobnicate 1 2 3\n{\nmap x\n}").stages.size(), 1U);
}

TEST(Shader, AStageWithoutAPictureEndsTheStages) {
    const Shader s = parse("{\nmap a\n}\n{\nvideoMap film.roq\n}\n{\nmap b\n}");
    ASSERT_EQ(s.stages.size(), 1U);
    EXPECT_EQ(s.stages[0].images.front(), "a");
}

TEST(ShaderLibrary, TheFirstDefinitionOfANameWins) {
    ShaderLibrary library;
    library.parse("a\n{\n{\nmap first\n}\n}\na\n{\n{\nmap second\n}\n}\n", "x.shader");
    library.parse("A\n{\n{\nmap third\n}\n}\nb\n{\n}\n", "y.shader");
    EXPECT_EQ(library.find("a")->stages.at(0).images.at(0), "first");
    EXPECT_EQ(library.find("b")->origin, "y.shader:7");
    EXPECT_EQ(library.find("c"), nullptr);
    EXPECT_EQ(library.names(), (std::vector<std::string>{"a", "b"}));
}

TEST(ShaderLibrary, BrokenBracesDropTheRestOfAFileOnly) {
    ShaderLibrary library;
    library.parse("a\n{\n{\nmap x\n}\n}\nb\n{\n{\nmap x\n}\n", "x.shader");
    library.parse("c\nd\n{\n}\n", "y.shader");
    library.parse("e\n{\n{\nmap x\n}\n}\n", "z.shader");
    EXPECT_NE(library.find("a"), nullptr);
    EXPECT_EQ(library.find("b"), nullptr);
    EXPECT_EQ(library.find("d"), nullptr);
    EXPECT_NE(library.find("e"), nullptr);
    ASSERT_EQ(library.warnings().size(), 2U);
    EXPECT_EQ(library.warnings()[0], "x.shader: line 7: the definition of 'b' is not closed by '}'; it is ignored");
    EXPECT_EQ(library.warnings()[1], "y.shader: line 1: 'c' is not followed by '{'; the rest of the file is ignored");
}

TEST(ShaderLibrary, FilesCountInTheGamesOrder) {
    const auto script = [](const std::string& name, const std::string& image) {
        return toBytes(name + "\n{\n{\nmap " + image + "\n}\n}\n");
    };
    Vfs files;
    files.mountMemory("lower", {{"scripts/a.shader", script("same", "lower/a")},
                                {"scripts/shared.shader", script("shared", "lower")}});
    files.mountMemory("upper", {{"scripts/b.shader", script("same", "upper/b")},
                                {"scripts/shared.shader", script("shared", "upper")},
                                {"scripts/c.shader", script("both", "upper/c")},
                                {"scripts/d.shader", script("both", "upper/d")},
                                {"other/e.shader", script("none", "x")}});
    const ShaderLibrary library = ShaderLibrary::load(files);
    const auto image = [&](const char* name) { return library.find(name)->stages.at(0).images.at(0); };
    EXPECT_EQ(image("shared"), "upper"); // one file name: the upper file hides the lower
    EXPECT_EQ(image("same"), "lower/a"); // two file names: the lower archive is read first
    EXPECT_EQ(image("both"), "upper/d"); // inside one source: the last file is read first
    EXPECT_EQ(library.find("none"), nullptr);
}

TEST(ShaderLibrary, ImagesHaveImplicitShaders) {
    const ShaderLibrary library;
    const Shader lightmapped = library.resolve("Textures/Base.tga", true);
    EXPECT_EQ(lightmapped.name, "textures/base");
    EXPECT_EQ(lightmapped.origin, "image");
    ASSERT_EQ(lightmapped.stages.size(), 2U);
    EXPECT_EQ(lightmapped.stages[0].source, Stage::Source::Lightmap);
    EXPECT_EQ(lightmapped.stages[0].rgbGen, RgbGen::Identity);
    EXPECT_EQ(lightmapped.stages[1].blend, (Blend{BlendFactor::DestinationColour, BlendFactor::Zero}));
    EXPECT_EQ(lightmapped.stages[1].images.front(), "Textures/Base.tga");
    EXPECT_FALSE(lightmapped.stages[1].depthWrite);
    EXPECT_TRUE(lightmapped.opaque());
    const Shader vertexLit = library.resolve("textures/base", false);
    ASSERT_EQ(vertexLit.stages.size(), 1U);
    EXPECT_EQ(vertexLit.stages[0].rgbGen, RgbGen::ExactVertex);
}

TEST(SurfaceParms, FlagsOfTheShaderLumpAreJoined) {
    SurfaceParms p;
    p.addFlags(0, 1);
    EXPECT_FALSE(p.sky || p.noDraw || p.clip || p.trigger || p.translucent);
    EXPECT_TRUE(p.structural);
    p.addFlags(0x4 | 0x80 | 0x400 | 0x8000 | 0x10000, 0);
    EXPECT_TRUE(p.sky && p.noDraw && p.noLightmap && p.lightFilter && p.alphaShadow);
    EXPECT_FALSE(p.hint);
    p = {};
    p.addFlags(0x100, 0x8 | 0x10 | 0x20 | 0x40 | 0x8000 | 0x10000 | 0x8000000 | 0x20000000 | 0x40000000);
    EXPECT_TRUE(p.hint && p.lava && p.slime && p.water && p.fog && p.areaPortal && p.clip && p.translucent &&
                p.trigger);
    EXPECT_FALSE(p.structural);
}
