#include "osgPlugins/osgpie/material_program.h"

#include "osgPlugins/osgpie/view_program.h"
#include "pie/level/level.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace osgpie {
namespace {

using pie::level::AlphaGen;
using pie::level::AlphaTest;
using pie::level::Blend;
using pie::level::BlendFactor;
using pie::level::Deform;
using pie::level::DeformKind;
using pie::level::RgbGen;
using pie::level::Shader;
using pie::level::Stage;
using pie::level::TcGen;
using pie::level::TcMod;
using pie::level::TcModKind;
using pie::level::Wave;

/// A float as GLSL 1.20 reads it: always with a point, never "inf".
std::string number(float value) {
    if (!std::isfinite(value)) value = 0.0F;
    const std::string text = fmt::format("{:.7g}", value);
    return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

/// A wave as an expression of time; `offset` is added to the phase (deforms, turbulence).
std::string waveExpression(const Wave& wave, const std::string& offset = "0.0") {
    const auto form = static_cast<int>(wave.form);
    return fmt::format("wave({}, {}, {}, {} + {}, {})", form, number(wave.base), number(wave.amplitude),
                       number(wave.phase), offset, number(wave.frequency));
}

constexpr const char* waveFunction = R"(
float wave(int form, float base, float amplitude, float phase, float frequency) {
    float x = fract(phase + TIME * frequency);
    float v;
    if (form == 0) v = sin(x * 6.2831853);
    else if (form == 1) v = x < 0.5 ? (x < 0.25 ? 4.0 * x : 2.0 - 4.0 * x) : (x < 0.75 ? 2.0 - 4.0 * x : 4.0 * x - 4.0);
    else if (form == 2) v = x < 0.5 ? 1.0 : -1.0;
    else if (form == 3) v = x;
    else if (form == 4) v = 1.0 - x;
    else v = 2.0 * fract(sin(floor((phase + TIME * frequency) * 10.0) * 12.9898) * 43758.5453) - 1.0;
    return base + amplitude * v;
}
)";

bool usesVertexLight(const Stage& stage) {
    return stage.rgbGen == RgbGen::Vertex || stage.rgbGen == RgbGen::ExactVertex ||
           stage.rgbGen == RgbGen::OneMinusVertex || stage.rgbGen == RgbGen::LightingDiffuse;
}

bool usesLight(const Stage& stage) { return stage.source == Stage::Source::Lightmap || usesVertexLight(stage); }

/// Texture coordinates of a stage from those of the picture and of the lightmap (tcGen, then tcMods in order, as the
/// game applies them).
std::string textureCoordinates(const Stage& stage, std::size_t i, const char* picture, const char* lightmap) {
    std::string code = fmt::format("    vec2 st{} = ", i);
    switch (stage.tcGen) {
    case TcGen::Texture:
        code += fmt::format("{};\n", stage.source == Stage::Source::Lightmap ? lightmap : picture);
        break;
    case TcGen::Lightmap: code += fmt::format("{};\n", lightmap); break;
    case TcGen::Environment: code += "environment(p.xyz, n);\n"; break;
    case TcGen::Vector: {
        const auto& v = stage.tcVectors;
        code += fmt::format("vec2(dot(p.xyz, vec3({}, {}, {})), dot(p.xyz, vec3({}, {}, {})));\n", number(v[0].x),
                            number(v[0].y), number(v[0].z), number(v[1].x), number(v[1].y), number(v[1].z));
        break;
    }
    }
    for (const TcMod& mod : stage.tcMods) {
        const auto& v = mod.values;
        switch (mod.kind) {
        case TcModKind::Scroll:
            code += fmt::format("    st{0} += fract(vec2({1}, {2}) * TIME);\n", i, number(v[0]), number(v[1]));
            break;
        case TcModKind::Scale:
            code += fmt::format("    st{0} *= vec2({1}, {2});\n", i, number(v[0]), number(v[1]));
            break;
        case TcModKind::Rotate:
            code += fmt::format("    {{ float a = radians(-({1}) * TIME); float s = sin(a), c = cos(a);\n"
                                "      st{0} = vec2(c * st{0}.x - s * st{0}.y + 0.5 - 0.5 * c + 0.5 * s, s * st{0}.x + "
                                "c * st{0}.y + 0.5 - "
                                "0.5 * s - 0.5 * c); }}\n",
                                i, number(v[0]));
            break;
        case TcModKind::Stretch:
            code += fmt::format("    {{ float w = {1}; float q = abs(w) > 1e-6 ? 1.0 / w : 1.0; st{0} = st{0} * q + "
                                "0.5 - 0.5 * q; }}\n",
                                i, waveExpression(mod.wave));
            break;
        case TcModKind::Transform:
            code += fmt::format(
                "    st{0} = vec2(st{0}.x * {1} + st{0}.y * {3} + {5}, st{0}.x * {2} + st{0}.y * {4} + {6});\n", i,
                number(v[0]), number(v[1]), number(v[2]), number(v[3]), number(v[4]), number(v[5]));
            break;
        case TcModKind::Turbulence:
            code += fmt::format(
                "    {{ float f = {1} + TIME * {2};\n"
                "      st{0} += {3} * sin(6.2831853 * vec2((p.x + p.z) / 1024.0 + f, p.y / 1024.0 + f)); }}\n",
                i, number(mod.wave.phase), number(mod.wave.frequency), number(mod.wave.amplitude));
            break;
        }
    }
    return code;
}

std::string deformCode(const Deform& deform) {
    switch (deform.kind) {
    case DeformKind::Wave:
        return fmt::format("    p.xyz += n * {};\n",
                           waveExpression(deform.wave, fmt::format("(p.x + p.y + p.z) * {}", number(deform.spread))));
    case DeformKind::Bulge: // spread = bulge width, amplitude = height, frequency = speed
        return fmt::format("    p.xyz += n * sin(gl_MultiTexCoord0.s * {} + TIME * {}) * {};\n", number(deform.spread),
                           number(deform.wave.frequency), number(deform.wave.amplitude));
    case DeformKind::Move:
        return fmt::format("    p.xyz += vec3({}, {}, {}) * {};\n", number(deform.direction.x),
                           number(deform.direction.y), number(deform.direction.z), waveExpression(deform.wave));
    // Sprites carry their centre and their place around it as further coordinates.
    case DeformKind::AutoSprite:
        return "    { vec3 r = vec3(gl_ModelViewMatrixInverse[0]), u = vec3(gl_ModelViewMatrixInverse[1]);\n"
               "      p.xyz = gl_MultiTexCoord2.xyz + normalize(r) * gl_MultiTexCoord3.x + normalize(u) * "
               "gl_MultiTexCoord3.y; }\n";
    case DeformKind::AutoSprite2: // turns about its long axis (in gl_MultiTexCoord4) to face the eye
        return "    { vec3 e = vec3(gl_ModelViewMatrixInverse[3]); vec3 m = gl_MultiTexCoord4.xyz;\n"
               "      vec3 c = gl_MultiTexCoord2.xyz + m * gl_MultiTexCoord3.y; vec3 r = cross(m, e - c); float l = "
               "length(r);\n"
               "      if (l > 1e-6) p.xyz = c + r / l * gl_MultiTexCoord3.x; }\n";
    case DeformKind::Normal: // wobbles normals for environment maps only
    case DeformKind::ProjectionShadow:
    case DeformKind::Text: break;
    }
    return {};
}

/// What a blend factor is worth, given the stage's colour `src` and alpha `srcA`. Destination alpha counts as one: the
/// frame has none.
std::string scalarFactor(BlendFactor factor) {
    switch (factor) {
    case BlendFactor::Zero: return "vec3(0.0)";
    case BlendFactor::One: return "vec3(1.0)";
    case BlendFactor::SourceColour: return "src";
    case BlendFactor::OneMinusSourceColour: return "(vec3(1.0) - src)";
    case BlendFactor::SourceAlpha: return "vec3(srcA)";
    case BlendFactor::OneMinusSourceAlpha: return "vec3(1.0 - srcA)";
    case BlendFactor::DestinationAlpha: return "vec3(1.0)";
    case BlendFactor::OneMinusDestinationAlpha:
    case BlendFactor::SourceAlphaSaturate: return "vec3(0.0)";
    case BlendFactor::DestinationColour:
    case BlendFactor::OneMinusDestinationColour: break;
    }
    return "vec3(1.0)";
}

/// C → P + Q·C of one stage's blend function.
std::pair<std::string, std::string> affine(const Blend& blend) {
    std::string p;
    std::string q = scalarFactor(blend.destination);
    switch (blend.source) {
    case BlendFactor::DestinationColour:
        p = "vec3(0.0)";
        q = "src + " + (blend.destination == BlendFactor::Zero ? "vec3(0.0)" : q);
        break;
    case BlendFactor::OneMinusDestinationColour:
        p = "src";
        q += " - src";
        break;
    default: p = blend.source == BlendFactor::Zero ? "vec3(0.0)" : "src * " + scalarFactor(blend.source); break;
    }
    return {p, q};
}

bool addsNothing(const Blend& b) { return b.source == BlendFactor::Zero || b.source == BlendFactor::DestinationColour; }
bool keepsAll(const Blend& b) {
    return b.destination == BlendFactor::One && b.source != BlendFactor::DestinationColour &&
           b.source != BlendFactor::OneMinusDestinationColour;
}

class Writer {
public:
    Writer(const Shader& shader, const Look& look) : shader_(shader), look_(look) {}

    MaterialProgram write() {
        chooseStages();
        if (stages_.empty()) {
            out_.visible = false;
            return std::move(out_);
        }
        const Stage& first = *stages_.front();
        out_.blended = !first.blend.opaque();
        out_.alphaTested = first.alphaTest != AlphaTest::None;
        out_.depthWrite = first.depthWrite;
        out_.bin = bin();
        assignUnits();
        writeVertexShader();
        writeFragmentShader();
        return std::move(out_);
    }

    /// The sky: direction instead of place; see makeSkyProgram.
    MaterialProgram writeSky() {
        chooseStages();
        const bool box = !shader_.skyBox.empty() && shader_.skyBox != "-";
        if (stages_.empty() && !box) {
            out_.visible = false;
            return std::move(out_);
        }
        if (box) {
            const auto sides = pie::level::skyBoxImages(shader_.skyBox); // +x +y −x −y up down
            for (const std::size_t side : {0U, 2U, 1U, 3U, 4U, 5U})
                out_.units.push_back({Stage::Source::Image, {sides.at(side)}, 0, true});
        }
        unitOf_.assign(stages_.size(), -1);
        for (std::size_t i = 0; i < stages_.size(); ++i) {
            if (stages_[i]->source != Stage::Source::Image) continue;
            unitOf_[i] = static_cast<int>(out_.units.size());
            out_.units.push_back(
                {Stage::Source::Image, stages_[i]->images, stages_[i]->framesPerSecond, stages_[i]->clamp});
        }
        out_.depthWrite = false;
        out_.vertexSource = "#version 120\nvarying vec3 direction;\nvoid main() {\n    direction = gl_Vertex.xyz;\n"
                            "    vec4 p = gl_ProjectionMatrix * vec4(mat3(gl_ModelViewMatrix) * gl_Vertex.xyz, 1.0);\n"
                            "    gl_Position = p.xyww; // as far as depth goes\n}\n";
        std::string& code = out_.fragmentSource;
        code = header();
        for (std::size_t u = 0; u < out_.units.size(); ++u) code += fmt::format("uniform sampler2D unit{};\n", u);
        code += "varying vec3 direction;\nvec4 colour = vec4(1.0);\nvec3 light() { return vec3(1.0); }\nfloat "
                "specular() { return 1.0; }\n"
                "vec2 environment(vec3 p, vec3 n) { return vec2(0.5 + 0.5 * n.y, 0.5 - 0.5 * n.z); }\n";
        if (look_.linear) code += "vec4 decode(vec4 c) { return c; }\n"; // the sky is shown as it is, not lit
        if (box) code += skyBoxFunction;
        code += cloudFunction();
        code +=
            "void main() {\n    vec3 n = normalize(direction);\n    vec3 position = n;\n    vec4 p = vec4(n, 1.0);\n"
            "    vec3 a = vec3(0.0), b = ";
        code += box ? "box(n);\n" : "vec3(0.0);\n";
        for (std::size_t i = 0; i < stages_.size(); ++i) {
            code += textureCoordinates(*stages_[i], i, "cloud(n)", "cloud(n)");
            code += fmt::format("    vec2 tc{0} = st{0};\n", i);
            code += stageCode(i);
        }
        code += "    gl_FragColor = vec4(b, 1.0);\n}\n";
        return std::move(out_);
    }

private:
    const Shader& shader_;
    const Look& look_;
    MaterialProgram out_;
    std::vector<const Stage*> stages_;
    std::vector<int> unitOf_; ///< texture unit of each stage, -1: none

    [[nodiscard]] bool anyLit() const {
        return std::any_of(stages_.begin(), stages_.end(), [](const Stage* s) { return usesLight(*s); });
    }

    void chooseStages() {
        constexpr std::size_t mostStages = 8; // the game's own limit
        for (const Stage& stage : shader_.stages)
            if (stages_.size() < mostStages) stages_.push_back(&stage);
        out_.lit = anyLit();
        out_.vertexLit = std::any_of(stages_.begin(), stages_.end(), [&](const Stage* s) {
            return look_.light == LightSource::Irradiance ? usesLight(*s)
                                                          : look_.light != LightSource::None && usesVertexLight(*s);
        });
        out_.lightmapCoordinates = std::any_of(stages_.begin(), stages_.end(), [&](const Stage* s) {
            return s->tcGen == TcGen::Lightmap || (s->source == Stage::Source::Lightmap && readsLightmap());
        });
        // The light alone is asked for: surfaces that only glow or tint show none.
        if (!look_.textures && !stages_.empty() && !stages_.front()->blend.opaque()) stages_.clear();
    }

    [[nodiscard]] bool readsLightmap() const {
        return look_.light == LightSource::Lightmap || (look_.switchable && look_.lightmapped);
    }

    [[nodiscard]] int bin() const {
        if (shader_.sort) {
            const float sort = *shader_.sort;
            if (sort <= 3.0F) return out_.blended ? 1 : 0;
            return out_.blended || sort > 5.0F ? 9 + static_cast<int>(std::min(sort, 16.0F)) - 5 : 2;
        }
        if (shader_.polygonOffset) return 1;
        return out_.blended ? (keepsAll(stages_.front()->blend) ? 14 : 13) : 0;
    }

    /// Unit 0 is the surface's picture (what fixed-function rendering uses); a lightmap stands in unit 1.
    void assignUnits() {
        unitOf_.assign(stages_.size(), -1);
        const auto add = [&](std::size_t i) {
            const Stage& s = *stages_[i];
            unitOf_[i] = static_cast<int>(out_.units.size());
            out_.units.push_back(
                {s.source, s.images, s.framesPerSecond, s.clamp || s.source == Stage::Source::Lightmap});
        };
        const auto image = std::find_if(stages_.begin(), stages_.end(),
                                        [](const Stage* s) { return s->source == Stage::Source::Image; });
        if (image != stages_.end())
            add(static_cast<std::size_t>(image - stages_.begin()));
        else
            out_.units.push_back({Stage::Source::White, {}, 0, false});
        for (std::size_t i = 0; i < stages_.size(); ++i) {
            const Stage& s = *stages_[i];
            if (s.source == Stage::Source::Lightmap && readsLightmap() && unitOf_[i] < 0) {
                add(i);
                break;
            }
        }
        for (std::size_t i = 0; i < stages_.size(); ++i) {
            if (unitOf_[i] >= 0) continue;
            const Stage& s = *stages_[i];
            if (s.source == Stage::Source::Image) add(i);
            if (s.source == Stage::Source::Lightmap && readsLightmap()) unitOf_[i] = lightmapUnit();
        }
    }
    [[nodiscard]] int lightmapUnit() const {
        for (std::size_t u = 0; u < out_.units.size(); ++u)
            if (out_.units[u].source == Stage::Source::Lightmap) return static_cast<int>(u);
        return -1;
    }

    [[nodiscard]] std::string header() const {
        return std::string("#version 120\n") +
               (look_.animate ? "uniform float osg_FrameTime;\n#define TIME osg_FrameTime\n" : "#define TIME 0.0\n") +
               waveFunction;
    }

    void writeVertexShader() {
        std::string& code = out_.vertexSource;
        code = header();
        code += "varying vec4 colour;\nvarying vec3 position;\nvarying vec3 normal;\nvarying float depth;\n";
        if (look_.switchable) code += viewVaryings;
        for (std::size_t i = 0; i < stages_.size(); ++i) code += fmt::format("varying vec2 tc{};\n", i);
        code += "vec2 environment(vec3 p, vec3 n) {\n"
                "    vec3 v = normalize(vec3(gl_ModelViewMatrixInverse[3]) - p);\n"
                "    vec3 r = n * (2.0 * dot(n, v)) - v;\n"
                "    return vec2(0.5 + 0.5 * r.y, 0.5 - 0.5 * r.z);\n}\n"
                "void main() {\n    vec4 p = gl_Vertex;\n    vec3 n = gl_Normal;\n";
        for (const Deform& deform : shader_.deforms) code += deformCode(deform);
        for (std::size_t i = 0; i < stages_.size(); ++i) {
            code += textureCoordinates(*stages_[i], i, "gl_MultiTexCoord0.st", "gl_MultiTexCoord1.st");
            code += fmt::format("    tc{0} = st{0};\n", i);
        }
        code +=
            "    colour = gl_Color;\n    position = p.xyz;\n    normal = n;\n    depth = -(gl_ModelViewMatrix * p).z;\n"
            "    gl_Position = gl_ModelViewProjectionMatrix * p;\n";
        if (look_.switchable) code += viewVertexCode;
        code += "}\n";
    }

    /// The light of a lit stage. Clamped with its hue kept, as the game clamps lightmap texels
    /// (R_ColorShiftLightingBytes).
    [[nodiscard]] std::string lightFunction() const {
        if (look_.switchable) return viewLight(look_.overbright);
        switch (look_.light) {
        case LightSource::Irradiance:
            return fmt::format("vec3 light() {{\n    vec3 l = max(colour.rgb, vec3(0.0)) * {0};\n    float m = "
                               "max(l.r, max(l.g, l.b));\n"
                               "    return m > {0} ? l * ({0} / m) : l;\n}}\n",
                               number(look_.overbright));
        case LightSource::Lightmap:
        case LightSource::Vertex:
            return fmt::format("vec3 light() {{ return colour.rgb * {}; }}\n", number(look_.overbright));
        case LightSource::None: break;
        }
        return "vec3 light() { return vec3(1.0); }\n";
    }

    [[nodiscard]] std::string rgbExpression(const Stage& stage) const {
        switch (stage.rgbGen) {
        case RgbGen::Identity:
        case RgbGen::IdentityLighting:
        case RgbGen::Entity:
        case RgbGen::OneMinusEntity: return "vec3(1.0)";
        case RgbGen::Vertex:
        case RgbGen::ExactVertex:
        case RgbGen::LightingDiffuse: return "light()";
        case RgbGen::OneMinusVertex: return "(vec3(1.0) - light())";
        case RgbGen::Wave: return fmt::format("vec3(clamp({}, 0.0, 1.0))", waveExpression(stage.rgbWave));
        case RgbGen::Constant:
            return fmt::format("vec3({}, {}, {})", number(stage.rgbConstant.x), number(stage.rgbConstant.y),
                               number(stage.rgbConstant.z));
        }
        return "vec3(1.0)";
    }
    [[nodiscard]] static std::string alphaExpression(const Stage& stage) {
        switch (stage.alphaGen) {
        case AlphaGen::Vertex: return "colour.a";
        case AlphaGen::OneMinusVertex: return "(1.0 - colour.a)";
        case AlphaGen::Wave: return fmt::format("clamp({}, 0.0, 1.0)", waveExpression(stage.alphaWave));
        case AlphaGen::Constant: return number(stage.alphaConstant);
        case AlphaGen::LightingSpecular: return "specular()";
        case AlphaGen::Portal:
            return fmt::format("clamp(length(vec3(gl_ModelViewMatrixInverse[3]) - position) / {}, 0.0, 1.0)",
                               number(std::max(1.0F, stage.alphaConstant)));
        case AlphaGen::Identity:
        case AlphaGen::Entity:
        case AlphaGen::OneMinusEntity: break;
        }
        return "1.0";
    }

    /// switchable: baked light of the lightmap stage `i`; white on surfaces without lightmap, as in the game.
    [[nodiscard]] std::string bakedTexel(std::size_t i) const {
        if (unitOf_[i] < 0 || !look_.lightmapped) return "vec3(1.0)";
        return fmt::format("texture2D(unit{}, tc{}).rgb * {}", unitOf_[i], i, number(look_.overbright));
    }
    /// switchable: what the level's own light is on this surface, as the difference is taken of.
    [[nodiscard]] std::string bakedLight() const {
        for (std::size_t i = 0; i < stages_.size(); ++i) {
            if (stages_[i]->source == Stage::Source::Lightmap) return bakedTexel(i);
            if (usesVertexLight(*stages_[i])) return fmt::format("bakedColour * {}", number(look_.overbright));
        }
        return "ours()";
    }

    /// `vec3 src; float srcA;` of stage i.
    [[nodiscard]] std::string sourceCode(std::size_t i) const {
        const Stage& stage = *stages_[i];
        std::string texel = "vec4(1.0)";
        if (stage.source == Stage::Source::Lightmap) {
            if (look_.switchable)
                texel = fmt::format("vec4(lightOf({}), 1.0)", bakedTexel(i));
            else if (look_.light == LightSource::Irradiance)
                texel = "vec4(light(), 1.0)";
            else if (look_.light == LightSource::Lightmap && unitOf_[i] >= 0) // a sky has none
                texel =
                    fmt::format("vec4(texture2D(unit{}, tc{}).rgb * {}, 1.0)", unitOf_[i], i, number(look_.overbright));
        } else if (unitOf_[i] >= 0) {
            texel = fmt::format("texture2D(unit{}, tc{})", unitOf_[i], i);
            if (look_.linear) texel = fmt::format("decode({})", texel);
            if (!look_.textures) texel = fmt::format("vec4(vec3(1.0), {}.a)", texel);
            if (look_.switchable) texel = fmt::format("plain({})", texel);
        }
        return fmt::format("        vec4 t = {};\n        vec3 src = t.rgb * {};\n        float srcA = t.a * {};\n",
                           texel, rgbExpression(stage), alphaExpression(stage));
    }

    [[nodiscard]] static std::string alphaTestCondition(AlphaTest test) {
        switch (test) {
        case AlphaTest::GreaterZero: return "srcA > 0.0";
        case AlphaTest::Less128: return "srcA < 0.5";
        case AlphaTest::GreaterEqual128: return "srcA >= 0.5";
        case AlphaTest::None: break;
        }
        return "true";
    }

    void writeFragmentShader() {
        std::string& code = out_.fragmentSource;
        code = header();
        for (std::size_t u = 0; u < out_.units.size(); ++u) code += fmt::format("uniform sampler2D unit{};\n", u);
        code += "varying vec4 colour;\nvarying vec3 position;\nvarying vec3 normal;\nvarying float depth;\n";
        for (std::size_t i = 0; i < stages_.size(); ++i) code += fmt::format("varying vec2 tc{};\n", i);
        // The game's specular highlight shines from one fixed place.
        code += "float specular() {\n    vec3 n = normalize(normal), l = normalize(vec3(-960.0, 1980.0, 96.0) - "
                "position);\n"
                "    vec3 r = n * (2.0 * dot(n, l)) - l;\n"
                "    float s = max(0.0, dot(r, normalize(vec3(gl_ModelViewMatrixInverse[3]) - position)));\n    return "
                "min(1.0, s * s * s * s);\n}\n";
        code += lightFunction();
        if (look_.linear)
            code += "vec4 decode(vec4 c) { return vec4(pow(c.rgb, vec3(2.2)), c.a); }\n"
                    "vec3 encode(vec3 c) { return pow(clamp(c, 0.0, 1.0), vec3(1.0 / 2.2)); }\n";
        if (look_.fog) code += fogFunction(look_.switchable);
        code += "void main() {\n    vec3 a = vec3(1.0), b = vec3(0.0); // the frame becomes a * frame + b\n";
        if (!look_.textures && !out_.lit) code += "    b = vec3(1.0);\n    a = vec3(0.0);\n";
        if (look_.switchable && !stages_.front()->blend.opaque()) code += "    if (!textured()) discard;\n";
        for (std::size_t i = 0; i < stages_.size(); ++i) code += stageCode(i);
        finish(code);
        code += "}\n";
    }

    [[nodiscard]] std::string stageCode(std::size_t i) const {
        const Stage& stage = *stages_[i];
        if (!look_.textures && out_.lit && !usesLight(stage) && i > 0) return {};
        const bool lightAloneSkips = look_.switchable && out_.lit && !usesLight(stage);
        std::string code = lightAloneSkips && i > 0 ? "    if (textured()) {\n" : "    {\n";
        code += sourceCode(i);
        if (!look_.textures && out_.lit && !usesLight(stage)) code += "        src = vec3(1.0);\n";
        if (lightAloneSkips && i == 0) code += "        if (!textured()) src = vec3(1.0);\n";
        if (stage.alphaTest != AlphaTest::None) {
            if (i == 0)
                code += fmt::format("        if (!({})) discard;\n", alphaTestCondition(stage.alphaTest));
            else
                code += fmt::format("        if ({}) {{\n", alphaTestCondition(stage.alphaTest));
        }
        // eq 3.8: the light brightens and darkens the texture instead of scaling it.
        const bool signedAdd =
            look_.addSigned && i > 0 && stage.source == Stage::Source::Lightmap && look_.light != LightSource::None;
        auto [p, q] = affine(stage.blend);
        if (signedAdd) {
            p = "(src - vec3(1.0))";
            q = "vec3(1.0)";
        }
        if (i == 0 && stage.blend.opaque()) // the first stage of clouds may blend with a sky box
            code += "        a = vec3(0.0); b = src;\n";
        else
            code += fmt::format("        vec3 p = {}, q = {};\n        a = q * a; b = clamp(p + q * b, 0.0, {});\n", p,
                                q, look_.linear ? "64.0" : number(std::max(1.0F, look_.overbright)));
        if (stage.alphaTest != AlphaTest::None && i > 0) code += "        }\n";
        if (i == 0 && out_.blended && stages_.size() == 1) code += "        single = vec4(src, srcA);\n";
        return code + "    }\n";
    }

    void finish(std::string& code) {
        const bool one = out_.blended && stages_.size() == 1;
        if (one) {
            // One stage: let OpenGL's own blend function do exactly what the script says.
            const std::size_t at = code.find("    vec3 a = vec3(1.0)");
            code.insert(at, "    vec4 single = vec4(0.0);\n");
            out_.blend = stages_.front()->blend;
            if (look_.fog) {
                if (keepsAll(out_.blend))
                    code += "    single.rgb *= 1.0 - fogAmount();\n";
                else if (addsNothing(out_.blend))
                    code += "    single.rgb = mix(single.rgb, vec3(1.0), fogAmount());\n";
                else
                    code += "    single.rgb = mix(single.rgb, fogColour, fogAmount());\n";
            }
            code += "    gl_FragColor = single;\n";
            return;
        }
        if (!out_.blended) {
            if (look_.linear) code += "    b = encode(b);\n";
            if (look_.fog) code += "    b = mix(b, fogColour, fogAmount());\n";
            if (look_.switchable)
                code += fmt::format("    b = looked(b, {}, {});\n", bakedLight(), out_.lit ? "true" : "false");
            code += "    gl_FragColor = vec4(b, 1.0);\n";
            return;
        }
        const bool pureFilter =
            std::all_of(stages_.begin(), stages_.end(), [](const Stage* s) { return addsNothing(s->blend); });
        const bool pureAdd =
            std::all_of(stages_.begin(), stages_.end(), [](const Stage* s) { return keepsAll(s->blend); });
        if (pureFilter) {
            if (look_.fog) code += "    a = mix(a, vec3(1.0), fogAmount());\n";
            code += "    gl_FragColor = vec4(a, 1.0);\n";
            out_.blend = {BlendFactor::Zero, BlendFactor::SourceColour};
        } else if (pureAdd) {
            if (look_.fog) code += "    b *= 1.0 - fogAmount();\n";
            code += "    gl_FragColor = vec4(b, 1.0);\n";
            out_.blend = {BlendFactor::One, BlendFactor::One};
        } else {
            // A blend function scales the frame by one number: exact where the factor is grey, its mean otherwise.
            code += "    float keep = clamp((a.r + a.g + a.b) / 3.0, 0.0, 1.0);\n";
            if (look_.fog) code += "    b = mix(b, fogColour * (1.0 - keep), fogAmount());\n";
            code += "    gl_FragColor = vec4(b, keep);\n";
            out_.blend = {BlendFactor::One, BlendFactor::SourceAlpha};
        }
    }

    /// Sides of the box as the game lays them out: s to the right and t upwards seen from inside.
    static constexpr const char* skyBoxFunction = R"(
vec3 box(vec3 d) {
    vec3 m = abs(d);
    if (m.x >= m.y && m.x >= m.z) {
        vec2 st = d.x > 0.0 ? vec2(-d.y, d.z) : vec2(d.y, d.z);
        st = st / m.x * vec2(0.5, -0.5) + 0.5;
        return d.x > 0.0 ? texture2D(unit0, st).rgb : texture2D(unit1, st).rgb;
    }
    if (m.y >= m.z) {
        vec2 st = d.y > 0.0 ? vec2(d.x, d.z) : vec2(-d.x, d.z);
        st = st / m.y * vec2(0.5, -0.5) + 0.5;
        return d.y > 0.0 ? texture2D(unit2, st).rgb : texture2D(unit3, st).rgb;
    }
    vec2 st = d.z > 0.0 ? vec2(-d.y, -d.x) : vec2(-d.y, d.x);
    st = st / m.z * vec2(0.5, -0.5) + 0.5;
    return d.z > 0.0 ? texture2D(unit4, st).rgb : texture2D(unit5, st).rgb;
}
)";

    /// Where a line of sight meets a dome of radius 4096 + height whose centre lies 4096 below the eye; the direction
    /// from that centre gives the texture coordinates (R_InitSkyTexCoords). Clouds end a quarter below the horizon.
    [[nodiscard]] std::string cloudFunction() const {
        const float height = std::max(1.0F, look_.cloudHeight);
        return fmt::format(
            "vec2 cloud(vec3 d) {{\n    d.z = max(d.z, -0.25 * max(abs(d.x), abs(d.y)));\n    d = normalize(d);\n"
            "    float b = 4096.0 * d.z;\n    float t = -b + sqrt(b * b + {0} * {0} + 8192.0 * {0});\n"
            "    vec3 v = normalize(vec3(d.xy * t, d.z * t + 4096.0));\n    return vec2(acos(v.x), acos(v.y));\n}}\n",
            number(height));
    }

    /// Fog as the game computes it: the square root of the share of the opaque depth that the ray spends below the
    /// fog's surface.
    static std::string fogFunction(bool switchable) {
        return std::string("uniform vec3 fogColour;\nuniform vec4 fogPlane; // distance below the fog's surface = "
                           "dot(fogPlane.xyz, p) + fogPlane.w\n"
                           "uniform float fogOpaque;\n"
                           "float fogAmount() {\n") +
               (switchable ? "    if (!textured()) return 0.0;\n" : "") +
               "    float t = dot(fogPlane.xyz, position) + fogPlane.w;\n"
               "    float eye = dot(fogPlane.xyz, vec3(gl_ModelViewMatrixInverse[3])) + fogPlane.w;\n"
               "    float share = eye < 0.0 ? (t < 1.0 ? 0.0 : t / (t - eye)) : (t < 0.0 ? 0.0 : 1.0);\n"
               "    return sqrt(clamp(depth / fogOpaque * share, 0.0, 1.0));\n}\n";
    }
};

} // namespace

MaterialProgram makeMaterialProgram(const Shader& shader, const Look& look) { return Writer(shader, look).write(); }

MaterialProgram makeSkyProgram(const Shader& shader, const Look& look) { return Writer(shader, look).writeSky(); }

} // namespace osgpie
