#include "pie/level/stage_parser.h"
#include "pie/level/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

namespace pie::level {
namespace {

constexpr std::size_t maxFrames = 8; ///< of an animMap, in the game

std::optional<BlendFactor> blendFactor(const std::string& word) {
    static const std::unordered_map<std::string_view, BlendFactor> factors = {
        {"gl_one", BlendFactor::One},
        {"gl_zero", BlendFactor::Zero},
        {"gl_src_color", BlendFactor::SourceColour},
        {"gl_one_minus_src_color", BlendFactor::OneMinusSourceColour},
        {"gl_dst_color", BlendFactor::DestinationColour},
        {"gl_one_minus_dst_color", BlendFactor::OneMinusDestinationColour},
        {"gl_src_alpha", BlendFactor::SourceAlpha},
        {"gl_one_minus_src_alpha", BlendFactor::OneMinusSourceAlpha},
        {"gl_dst_alpha", BlendFactor::DestinationAlpha},
        {"gl_one_minus_dst_alpha", BlendFactor::OneMinusDestinationAlpha},
        {"gl_src_alpha_saturate", BlendFactor::SourceAlphaSaturate}};
    const auto found = factors.find(word);
    return found == factors.end() ? std::nullopt : std::optional(found->second);
}

/// The game puts GL_ONE for a word it does not know, and for one that is only allowed on the other side.
BlendFactor sourceFactor(const std::string& word) {
    const std::optional<BlendFactor> factor = blendFactor(word);
    if (!factor || *factor == BlendFactor::SourceColour || *factor == BlendFactor::OneMinusSourceColour)
        return BlendFactor::One;
    return *factor;
}
BlendFactor destinationFactor(const std::string& word) {
    const std::optional<BlendFactor> factor = blendFactor(word);
    if (!factor || *factor == BlendFactor::DestinationColour || *factor == BlendFactor::OneMinusDestinationColour ||
        *factor == BlendFactor::SourceAlphaSaturate)
        return BlendFactor::One;
    return *factor;
}

WaveForm waveForm(const std::string& word) {
    static const std::unordered_map<std::string_view, WaveForm> forms = {{"sin", WaveForm::Sine},
                                                                         {"triangle", WaveForm::Triangle},
                                                                         {"square", WaveForm::Square},
                                                                         {"sawtooth", WaveForm::Sawtooth},
                                                                         {"inversesawtooth", WaveForm::InverseSawtooth},
                                                                         {"noise", WaveForm::Noise}};
    const auto found = forms.find(word);
    return found == forms.end() ? WaveForm::Sine : found->second;
}

void waveNumbers(Words& words, Wave& wave) {
    for (float* value : {&wave.base, &wave.amplitude, &wave.phase, &wave.frequency}) *value = words.numberOnLine();
}

} // namespace

std::string Words::wordOnLine() {
    const std::optional<Token> token = tokens_.nextOnLine();
    return token ? std::string(token->text) : std::string();
}

float Words::numberOnLine() { return toNumber(wordOnLine()); }

bool Words::vector(Vec3& into) {
    const bool opened = wordOnLine() == "(";
    for (int i = 0; opened && i < 3; ++i) into[i] = numberOnLine();
    if (opened && wordOnLine() == ")") return true;
    refuse("expected ( number number number ), with white space round the parentheses");
    skipLine();
    return false;
}

void Words::refuse(const std::string& why) {
    defects_->push_back(fmt::format("{}:{}: {}", fileName_, tokens_.line(), why));
}

Wave parseWave(Words& words) {
    Wave wave;
    wave.form = waveForm(lower(words.wordOnLine()));
    waveNumbers(words, wave);
    return wave;
}

std::optional<Deform> parseDeform(Words& words) {
    const std::string kind = lower(words.wordOnLine());
    Deform deform;
    if (kind == "wave") {
        deform.kind = DeformKind::Wave;
        const float divisor = words.numberOnLine();
        deform.spread = divisor != 0 ? 1 / divisor : 100.0F; // the game's value for a divisor of 0
        deform.wave = parseWave(words);
    } else if (kind == "normal") {
        deform.kind = DeformKind::Normal;
        deform.wave.amplitude = words.numberOnLine();
        deform.wave.frequency = words.numberOnLine();
    } else if (kind == "bulge") {
        deform.kind = DeformKind::Bulge;
        for (int i = 0; i < 3; ++i) deform.direction[i] = words.numberOnLine(); // width, height, speed
    } else if (kind == "move") {
        deform.kind = DeformKind::Move;
        for (int i = 0; i < 3; ++i) deform.direction[i] = words.numberOnLine();
        deform.wave = parseWave(words);
    } else if (kind == "autosprite") {
        deform.kind = DeformKind::AutoSprite;
    } else if (kind == "autosprite2") {
        deform.kind = DeformKind::AutoSprite2;
    } else if (kind == "projectionshadow") {
        deform.kind = DeformKind::ProjectionShadow;
    } else if (kind.starts_with("text")) {
        deform.kind = DeformKind::Text;
    } else {
        words.skipLine();
        return std::nullopt;
    }
    words.skipLine();
    return deform;
}

std::optional<Stage> StageParser::parse() {
    for (;;) {
        const std::optional<Token> token = words_.next();
        if (!token) {
            words_.refuse("a stage is not closed by '}'");
            break;
        }
        if (token->is('}')) break;
        keyword(lower(token->text));
    }
    finish();
    if (!hasPicture_) return std::nullopt;
    return std::move(stage_);
}

void StageParser::keyword(const std::string& word) {
    using Handler = void (StageParser::*)();
    static const std::unordered_map<std::string_view, Handler> handlers = {{"map", &StageParser::map},
                                                                           {"clampmap", &StageParser::clampMap},
                                                                           {"animmap", &StageParser::animMap},
                                                                           {"videomap", &StageParser::videoMap},
                                                                           {"alphafunc", &StageParser::alphaFunc},
                                                                           {"depthfunc", &StageParser::depthFunc},
                                                                           {"detail", &StageParser::detail},
                                                                           {"blendfunc", &StageParser::blendFunc},
                                                                           {"rgbgen", &StageParser::rgbGen},
                                                                           {"alphagen", &StageParser::alphaGen},
                                                                           {"tcgen", &StageParser::tcGen},
                                                                           {"texgen", &StageParser::tcGen},
                                                                           {"tcmod", &StageParser::tcMod},
                                                                           {"depthwrite", &StageParser::depthWrite}};
    if (const auto handler = handlers.find(word); handler != handlers.end()) {
        (this->*handler->second)();
        return;
    }
    words_.refuse(fmt::format("unknown keyword '{}' in a stage", word));
    words_.skipLine();
}

void StageParser::map() {
    const std::string name = words_.wordOnLine();
    const std::string key = lower(name);
    stage_.images.clear();
    hasPicture_ = !name.empty();
    if (name.empty()) words_.refuse("map without a name");
    if (key == "$lightmap") {
        stage_.source = Stage::Source::Lightmap;
    } else if (key == "$whiteimage" || key == "*white") {
        stage_.source = Stage::Source::White;
    } else if (!name.empty()) {
        stage_.source = Stage::Source::Image;
        stage_.images.push_back(name);
    }
}

void StageParser::clampMap() {
    map();
    stage_.clamp = true;
}

void StageParser::animMap() {
    stage_.framesPerSecond = words_.numberOnLine();
    stage_.source = Stage::Source::Image;
    stage_.images.clear();
    while (const std::optional<Token> frame = words_.nextOnLine())
        if (stage_.images.size() < maxFrames) stage_.images.emplace_back(frame->text);
    hasPicture_ = !stage_.images.empty();
}

/// Films are not played; the stage counts as one without a picture.
void StageParser::videoMap() { words_.skipLine(); }

void StageParser::alphaFunc() {
    const std::string word = lower(words_.wordOnLine());
    stage_.alphaTest = word == "gt0"     ? AlphaTest::GreaterZero
                       : word == "lt128" ? AlphaTest::Less128
                       : word == "ge128" ? AlphaTest::GreaterEqual128
                                         : AlphaTest::None;
}

void StageParser::depthFunc() {
    const std::string word = lower(words_.wordOnLine());
    if (word == "equal" || word == "lequal") stage_.depthEqual = word == "equal";
}

void StageParser::detail() { stage_.detail = true; }
void StageParser::depthWrite() { writesDepth_ = true; }

void StageParser::blendFunc() {
    const std::string first = lower(words_.wordOnLine());
    if (first.empty()) return;
    if (first == "add") {
        stage_.blend = {BlendFactor::One, BlendFactor::One};
    } else if (first == "filter") {
        stage_.blend = {BlendFactor::DestinationColour, BlendFactor::Zero};
    } else if (first == "blend") {
        stage_.blend = {BlendFactor::SourceAlpha, BlendFactor::OneMinusSourceAlpha};
    } else {
        const std::string second = lower(words_.wordOnLine());
        stage_.blend.source = sourceFactor(first);
        if (second.empty()) return;
        stage_.blend.destination = destinationFactor(second);
    }
    hasBlend_ = true;
}

void StageParser::rgbGen() {
    static const std::unordered_map<std::string_view, RgbGen> kinds = {{"identity", RgbGen::Identity},
                                                                       {"identitylighting", RgbGen::IdentityLighting},
                                                                       {"vertex", RgbGen::Vertex},
                                                                       {"exactvertex", RgbGen::ExactVertex},
                                                                       {"oneminusvertex", RgbGen::OneMinusVertex},
                                                                       {"entity", RgbGen::Entity},
                                                                       {"oneminusentity", RgbGen::OneMinusEntity},
                                                                       {"lightingdiffuse", RgbGen::LightingDiffuse},
                                                                       {"wave", RgbGen::Wave},
                                                                       {"const", RgbGen::Constant}};
    const auto kind = kinds.find(lower(words_.wordOnLine()));
    if (kind == kinds.end()) return;
    stage_.rgbGen = kind->second;
    hasRgbGen_ = true;
    if (stage_.rgbGen == RgbGen::Wave) stage_.rgbWave = parseWave(words_);
    if (stage_.rgbGen == RgbGen::Constant) (void)words_.vector(stage_.rgbConstant);
    // Vertex colours bring their alpha along unless the script has said otherwise before.
    if (stage_.rgbGen == RgbGen::Vertex && stage_.alphaGen == AlphaGen::Identity) stage_.alphaGen = AlphaGen::Vertex;
}

void StageParser::alphaGen() {
    static const std::unordered_map<std::string_view, AlphaGen> kinds = {
        {"identity", AlphaGen::Identity},
        {"vertex", AlphaGen::Vertex},
        {"oneminusvertex", AlphaGen::OneMinusVertex},
        {"entity", AlphaGen::Entity},
        {"oneminusentity", AlphaGen::OneMinusEntity},
        {"lightingspecular", AlphaGen::LightingSpecular},
        {"wave", AlphaGen::Wave},
        {"portal", AlphaGen::Portal},
        {"const", AlphaGen::Constant}};
    const auto kind = kinds.find(lower(words_.wordOnLine()));
    if (kind == kinds.end()) return;
    stage_.alphaGen = kind->second;
    if (stage_.alphaGen == AlphaGen::Wave) stage_.alphaWave = parseWave(words_);
    if (stage_.alphaGen == AlphaGen::Constant) stage_.alphaConstant = words_.numberOnLine();
    if (stage_.alphaGen == AlphaGen::Portal) words_.skipLine();
}

void StageParser::tcGen() {
    const std::string word = lower(words_.wordOnLine());
    hasTcGen_ = true;
    if (word == "environment") {
        stage_.tcGen = TcGen::Environment;
    } else if (word == "lightmap") {
        stage_.tcGen = TcGen::Lightmap;
    } else if (word == "vector") {
        stage_.tcGen = TcGen::Vector;
        (void)(words_.vector(stage_.tcVectors[0]) && words_.vector(stage_.tcVectors[1]));
    } else if (word == "texture" || word == "base") {
        stage_.tcGen = TcGen::Texture;
    } else {
        hasTcGen_ = false;
    }
}

void StageParser::tcMod() {
    TcMod mod;
    const std::string kind = lower(words_.wordOnLine());
    const auto numbers = [&](std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) mod.values.at(i) = words_.numberOnLine();
    };
    if (kind == "scroll") {
        mod.kind = TcModKind::Scroll;
        numbers(2);
    } else if (kind == "scale") {
        mod.kind = TcModKind::Scale;
        numbers(2);
    } else if (kind == "rotate") {
        mod.kind = TcModKind::Rotate;
        numbers(1);
    } else if (kind == "transform") {
        mod.kind = TcModKind::Transform;
        numbers(6);
    } else if (kind == "stretch") {
        mod.kind = TcModKind::Stretch;
        mod.wave = parseWave(words_);
    } else if (kind == "turb") {
        mod.kind = TcModKind::Turbulence;
        // Some scripts name the form, which the game takes for a base of 0.
        waveNumbers(words_, mod.wave);
    } else {
        words_.skipLine();
        return;
    }
    words_.skipLine();
    stage_.tcMods.push_back(mod);
}

void StageParser::finish() {
    if (!hasRgbGen_) {
        const bool lighting =
            !hasBlend_ || stage_.blend.source == BlendFactor::One || stage_.blend.source == BlendFactor::SourceAlpha;
        stage_.rgbGen = lighting ? RgbGen::IdentityLighting : RgbGen::Identity;
    }
    // Without blending depth is always written, with it only where the script says so.
    stage_.depthWrite = stage_.blend.opaque() || writesDepth_;
    if (!hasTcGen_) stage_.tcGen = stage_.source == Stage::Source::Lightmap ? TcGen::Lightmap : TcGen::Texture;
}

} // namespace pie::level
