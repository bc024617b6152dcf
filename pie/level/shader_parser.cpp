// The grammar as the game reads it (Q3 shader manual; ioquake3's tr_shader.c for defaults and for what it refuses) and
// the level compiler's light keys.

#include "pie/level/shader_parser.h"
#include "pie/level/names.h"
#include "pie/level/stage_parser.h"
#include "pie/level/tokens.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_map>

namespace pie::level {
namespace {

constexpr std::size_t maxStages = 8; ///< of the game

struct SortName {
    std::string_view name;
    float value;
};
constexpr std::array<SortName, 9> sortNames = {{{"portal", sortPortal},
                                                {"sky", sortSky},
                                                {"opaque", sortOpaque},
                                                {"decal", sortDecal},
                                                {"seethrough", sortSeeThrough},
                                                {"banner", sortBanner},
                                                {"additive", sortAdditive},
                                                {"nearest", sortNearest},
                                                {"underwater", sortUnderwater}}};

class ShaderParser {
public:
    ShaderParser(Shader& shader, Words words) : shader_(shader), words_(std::move(words)) {}

    void parse() {
        while (const std::optional<Token> token = words_.next()) {
            if (token->is('}')) break;
            if (token->is('{'))
                stage();
            else
                keyword(lower(token->text));
        }
        finish();
    }

private:
    using Handler = void (ShaderParser::*)();

    void keyword(const std::string& word) {
        static const std::unordered_map<std::string_view, Handler> handlers = {
            {"surfaceparm", &ShaderParser::surfaceParm},
            {"cull", &ShaderParser::cull},
            {"sort", &ShaderParser::sort},
            {"portal", &ShaderParser::portal},
            {"polygonoffset", &ShaderParser::polygonOffset},
            {"deformvertexes", &ShaderParser::deform},
            {"skyparms", &ShaderParser::skyParms},
            {"fogparms", &ShaderParser::fogParms},
            {"qer_editorimage", &ShaderParser::editorImage},
            {"q3map_surfacelight", &ShaderParser::surfaceLight},
            {"q3map_lightrgb", &ShaderParser::lightColour},
            {"q3map_lightimage", &ShaderParser::lightImage},
            {"q3map_backsplash", &ShaderParser::backsplash},
            {"q3map_bounce", &ShaderParser::bounce},
            {"q3map_bouncescale", &ShaderParser::bounce},
            {"q3map_sun", &ShaderParser::sun},
            {"sun", &ShaderParser::sun},
            {"q3map_sunext", &ShaderParser::extendedSun},
            {"q3map_skylight", &ShaderParser::skyLight},
        };
        if (const auto handler = handlers.find(word); handler != handlers.end()) {
            (this->*handler->second)();
            return;
        }
        if (!isIgnored(word)) words_.refuse(fmt::format("unknown keyword '{}'", word));
        words_.skipLine();
    }

    /// Keywords that mean nothing for the picture or its light.
    static bool isIgnored(const std::string& word) {
        return word.starts_with("qer") || word.starts_with("q3map") || word == "tesssize" || word == "clamptime" ||
               word == "nomipmaps" || word == "nopicmip" || word == "entitymergable" || word == "light";
    }

    void stage() {
        StageParser parser(words_);
        std::optional<Stage> stage = parser.parse();
        if (stages_ == maxStages) words_.refuse(fmt::format("more than {} stages", maxStages));
        ++stages_;
        // The game stops drawing at the first stage without a picture.
        if (!stage) closed_ = true;
        if (stage && !closed_ && shader_.stages.size() < maxStages) shader_.stages.push_back(std::move(*stage));
    }

    void surfaceParm() {
        const std::string word = lower(words_.wordOnLine());
        SurfaceParms& p = shader_.parms;
        const std::unordered_map<std::string_view, bool*> flags = {{"sky", &p.sky},
                                                                   {"nodraw", &p.noDraw},
                                                                   {"trans", &p.translucent},
                                                                   {"fog", &p.fog},
                                                                   {"nolightmap", &p.noLightmap},
                                                                   {"alphashadow", &p.alphaShadow},
                                                                   {"lightfilter", &p.lightFilter},
                                                                   {"playerclip", &p.clip},
                                                                   {"monsterclip", &p.clip},
                                                                   {"trigger", &p.trigger},
                                                                   {"areaportal", &p.areaPortal},
                                                                   {"hint", &p.hint},
                                                                   {"skip", &p.hint},
                                                                   {"nonsolid", &p.nonSolid},
                                                                   {"water", &p.water},
                                                                   {"slime", &p.slime},
                                                                   {"lava", &p.lava},
                                                                   {"structural", &p.structural},
                                                                   {"pointlight", &p.pointLight}};
        if (const auto flag = flags.find(word); flag != flags.end()) *flag->second = true;
        if (word == "detail") p.structural = false;
    }

    void cull() {
        const std::string word = lower(words_.wordOnLine());
        if (word == "none" || word == "twosided" || word == "disable") shader_.cull = Cull::None;
        if (word == "back" || word == "backside" || word == "backsided") shader_.cull = Cull::Back;
    }

    void sort() {
        const std::string word = lower(words_.wordOnLine());
        if (word.empty()) return;
        shader_.sort = toNumber(word);
        for (const SortName& known : sortNames)
            if (word == known.name) shader_.sort = known.value;
    }

    void portal() {
        shader_.portal = true;
        shader_.sort = sortPortal;
    }

    void polygonOffset() { shader_.polygonOffset = true; }

    void skyParms() {
        shader_.skyBox = words_.wordOnLine();
        if (shader_.skyBox.empty()) return;
        // 512 is the game's height for "-" and 0.
        const float height = words_.numberOnLine();
        shader_.cloudHeight = height != 0 ? height : 512.0F;
        (void)words_.wordOnLine();
        isSky_ = true;
    }

    void fogParms() {
        FogKeys fog;
        if (!words_.vector(fog.colour)) return;
        fog.opaqueDistance = words_.numberOnLine();
        shader_.fog = fog;
        words_.skipLine();
    }

    void editorImage() {
        shader_.editorImage = words_.wordOnLine();
        words_.skipLine();
    }

    void deform() {
        if (std::optional<Deform> deform = parseDeform(words_)) shader_.deforms.push_back(*deform);
    }

    void surfaceLight() { shader_.light.surfaceLight = lastNumber(); }
    void bounce() { shader_.light.bounce = lastNumber(); }
    void lightImage() {
        shader_.light.lightImage = words_.wordOnLine();
        words_.skipLine();
    }
    void lightColour() {
        shader_.light.colour = colour();
        words_.skipLine();
    }
    void backsplash() {
        shader_.light.backsplashPercent = words_.numberOnLine();
        shader_.light.backsplashDistance = lastNumber();
    }
    void skyLight() {
        SkyLightKey key;
        key.value = std::max(0.0F, words_.numberOnLine());
        // Fewer than 2 rings are none; the compiler raises them as well.
        key.iterations = static_cast<int>(std::clamp(lastNumber(), 2.0F, 1000.0F));
        shader_.light.skyLights.push_back(key);
    }
    void sun() {
        shader_.light.suns.push_back(plainSun());
        words_.skipLine();
    }
    void extendedSun() {
        SunKey key = plainSun();
        key.deviance = std::max(0.0F, words_.numberOnLine());
        key.samples = static_cast<int>(std::clamp(lastNumber(), 1.0F, 10000.0F));
        shader_.light.suns.push_back(key);
    }

    SunKey plainSun() {
        SunKey key;
        const Rgb written = colour();
        const float largest = maxChannel(written);
        key.colour = largest > 0 ? written / largest : Rgb(1.0F);
        key.intensity = words_.numberOnLine();
        key.degrees = words_.numberOnLine();
        key.elevation = words_.numberOnLine();
        return key;
    }

    Rgb colour() {
        Rgb c;
        for (int i = 0; i < 3; ++i) c[i] = words_.numberOnLine();
        return c;
    }

    float lastNumber() {
        const float number = words_.numberOnLine();
        words_.skipLine();
        return number;
    }

    /// The game's order of drawing where the script says nothing.
    void finish() {
        if (isSky_) shader_.sort = sortSky;
        shader_.parms.sky |= isSky_;
        if (shader_.polygonOffset && !shader_.sort) shader_.sort = sortDecal;
        // A first stage that blends makes the whole shader transparent; writing depth makes it a grate.
        if (!shader_.sort && !shader_.stages.empty() && !shader_.stages.front().blend.opaque())
            shader_.sort = shader_.stages.front().depthWrite ? sortSeeThrough : sortBlend;
        if (!shader_.sort) shader_.sort = sortOpaque;
        if (shader_.stages.empty() && !isSky_) shader_.sort = sortFog;
    }

    Shader& shader_;
    Words words_;
    std::size_t stages_ = 0;
    bool isSky_ = false, closed_ = false;
};

} // namespace

Shader parseShader(std::string name, std::string_view text, const std::string& fileName, int line) {
    Shader shader;
    shader.name = std::move(name);
    ShaderParser(shader, Words(text, line, fileName, shader.defects)).parse();
    return shader;
}

} // namespace pie::level
