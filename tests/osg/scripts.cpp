#include "tests/osg/scripts.h"

namespace pie::test {
namespace {

std::string stage(const std::string& keys) { return "{\n" + keys + "\n}\n"; }

} // namespace

level::Shader parseScript(const std::string& body) {
    level::ShaderLibrary library;
    library.parse("t/x\n{\n" + body + "\n}\n", "scripts/test.shader");
    const level::Shader* shader = library.find("t/x");
    return shader ? *shader : level::Shader{};
}

std::vector<std::string> scriptCollection() {
    const std::string light = stage("map $lightmap");
    const std::string picture = stage("map t/a.tga\nblendFunc filter");
    std::vector<std::string> bodies{
        light,
        light + picture,
        stage("map $whiteimage"),
        light + picture + stage("map t/glow.tga\nblendFunc add\nrgbGen wave sin 0.5 0.5 0 1"),
        stage("map t/fence.tga\nalphaFunc GE128\ndepthWrite") +
            stage("map $lightmap\nblendFunc filter\ndepthFunc equal"),
        stage("map t/b.tga") + stage("map t/a.tga\nalphaFunc GT0\nblendFunc blend") +
            stage("map $lightmap\nblendFunc filter"),
        "cull none\n" + stage("map t/a.tga\nblendFunc blend"),
        stage("map t/a.tga\nblendFunc GL_ONE GL_ONE_MINUS_SRC_ALPHA") + stage("map t/b.tga\nblendFunc add"),
        stage("map t/a.tga\nblendFunc GL_DST_COLOR GL_ONE_MINUS_DST_ALPHA") + stage("map t/b.tga\nblendFunc filter"),
        stage("animMap 2 t/a.tga t/b.tga") + stage("clampMap t/c.tga\nblendFunc add"),
        "deformVertexes autosprite\n" + stage("map t/flare.tga\nblendFunc add\nrgbGen vertex"),
        "deformVertexes autosprite2\n" + stage("map t/flame.tga\nblendFunc add"),
        "deformVertexes normal 0.5 0.1\n" + stage("map t/a.tga\ntcGen environment\nrgbGen lightingDiffuse"),
        "qer_editorimage t/a.tga\nsurfaceparm trans\n" +
            stage("map t/a.tga\nblendFunc GL_SRC_ALPHA GL_ONE\nalphaGen portal 256"),
    };
    for (const char* blend : {"GL_ONE GL_ONE", "GL_ZERO GL_ONE_MINUS_SRC_COLOR", "GL_DST_COLOR GL_SRC_COLOR",
                              "GL_ONE_MINUS_DST_COLOR GL_ZERO", "GL_SRC_ALPHA_SATURATE GL_DST_ALPHA",
                              "GL_ONE_MINUS_SRC_ALPHA GL_SRC_ALPHA", "GL_DST_ALPHA GL_ONE_MINUS_DST_ALPHA"})
        for (const std::string& first : {std::string(), light})
            bodies.push_back(first + stage("map t/a.tga\nblendFunc " + std::string(blend)) + picture);
    for (const char* rgb : {"identity", "identityLighting", "vertex", "exactVertex", "oneMinusVertex", "entity",
                            "oneMinusEntity", "lightingDiffuse", "wave noise 0 1 0 3", "const ( 0.5 0.25 -0.1 )"})
        bodies.push_back(stage("map t/a.tga\nrgbGen " + std::string(rgb)));
    for (const char* alpha : {"vertex", "oneMinusVertex", "entity", "oneMinusEntity", "lightingSpecular",
                              "wave square 0.5 0.5 0.25 1", "portal 512", "const 0.5"})
        bodies.push_back(stage("map t/b.tga") + stage("map t/a.tga\nblendFunc blend\nalphaGen " + std::string(alpha)));
    for (const char* mod : {"scroll -1 2", "scale -0.5 -1", "rotate -20", "stretch sin 1 -0.5 0.25 -1",
                            "transform 1 -0.5 0.5 -1 0.25 -0.25", "turb 0 -0.25 0.5 -1"})
        bodies.push_back(stage("map t/a.tga\ntcMod " + std::string(mod) + "\ntcMod scroll 0.1 -0.1"));
    for (const char* generator : {"base", "lightmap", "environment", "vector ( 0.01 0 -0.5 ) ( 0 -0.01 0 )"})
        bodies.push_back(stage("map t/a.tga\ntcGen " + std::string(generator)));
    for (const char* deform : {"wave 100 sin 0 3 0 0.5", "bulge 3 10 1", "move 1 2 -3 triangle 0 5 0 1"})
        bodies.push_back("deformVertexes " + std::string(deform) + "\n" + light + picture);
    std::string eight;
    for (int i = 0; i < 8; ++i) eight += stage("map t/" + std::to_string(i) + ".tga\nblendFunc add");
    bodies.push_back(eight);
    return bodies;
}

std::vector<osgpie::Look> allLooks() {
    using osgpie::LightSource;
    std::vector<osgpie::Look> looks;
    for (const auto light : {LightSource::Irradiance, LightSource::Lightmap, LightSource::Vertex, LightSource::None})
        for (unsigned bits = 0; bits < 32; ++bits) {
            osgpie::Look look;
            look.light = light;
            look.textures = (bits & 1U) != 0;
            look.addSigned = (bits & 2U) != 0;
            look.linear = (bits & 4U) != 0;
            look.animate = (bits & 8U) != 0;
            look.fog = (bits & 16U) != 0;
            look.overbright = look.linear ? 16.0F : 2.0F;
            look.cloudHeight = 128;
            looks.push_back(look);
        }
    return looks;
}

} // namespace pie::test
