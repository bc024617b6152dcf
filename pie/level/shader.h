#pragma once
// Quake 3 shader scripts: what a surface looks like, whether light passes it, and what light it gives (Q3 shader
// manual; the light keys are those of the level compiler). Names are without extension, in lower case.

#include "pie/core/result.h"
#include "pie/core/vec.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pie::level {

class Vfs;

enum class BlendFactor : std::uint8_t {
    Zero,
    One,
    SourceColour,
    OneMinusSourceColour,
    DestinationColour,
    OneMinusDestinationColour,
    SourceAlpha,
    OneMinusSourceAlpha,
    DestinationAlpha,
    OneMinusDestinationAlpha,
    SourceAlphaSaturate
};
struct Blend {
    BlendFactor source = BlendFactor::One;
    BlendFactor destination = BlendFactor::Zero;
    bool operator==(const Blend&) const = default;
    [[nodiscard]] bool opaque() const { return source == BlendFactor::One && destination == BlendFactor::Zero; }
};

enum class WaveForm : std::uint8_t { Sine, Triangle, Square, Sawtooth, InverseSawtooth, Noise };
/// value(t) = base + amplitude * form(phase + t * frequency)
struct Wave {
    WaveForm form = WaveForm::Sine;
    float base = 0, amplitude = 0, phase = 0, frequency = 0;
};

enum class AlphaTest : std::uint8_t { None, GreaterZero, Less128, GreaterEqual128 };
enum class RgbGen : std::uint8_t {
    Identity,
    IdentityLighting,
    Vertex,
    ExactVertex,
    OneMinusVertex,
    Entity,
    OneMinusEntity,
    LightingDiffuse,
    Wave,
    Constant
};
enum class AlphaGen : std::uint8_t {
    Identity,
    Vertex,
    OneMinusVertex,
    Entity,
    OneMinusEntity,
    LightingSpecular,
    Wave,
    Portal,
    Constant
};
enum class TcGen : std::uint8_t { Texture, Lightmap, Environment, Vector };
enum class TcModKind : std::uint8_t { Scroll, Scale, Rotate, Stretch, Transform, Turbulence };
struct TcMod {
    TcModKind kind = TcModKind::Scroll;
    std::array<float, 6> values{}; ///< scroll/scale: s t; rotate: degrees per second; transform: m00 m01 m10 m11 t0 t1
    Wave wave;                     ///< stretch, turbulence
};

struct Stage {
    enum class Source : std::uint8_t { Image, Lightmap, White };
    Source source = Source::Image;
    std::vector<std::string> images; ///< one, or the frames of an animMap; as written
    float framesPerSecond = 0;
    bool clamp = false;
    Blend blend;
    AlphaTest alphaTest = AlphaTest::None;
    RgbGen rgbGen = RgbGen::Identity; ///< after the game's defaults for unset values
    Wave rgbWave;
    Rgb rgbConstant{1.0F};
    AlphaGen alphaGen = AlphaGen::Identity;
    Wave alphaWave;
    float alphaConstant = 1.0F;
    TcGen tcGen = TcGen::Texture;
    std::array<Vec3, 2> tcVectors{};
    std::vector<TcMod> tcMods;
    bool depthWrite = true;
    bool depthEqual = false;
    bool detail = false;
};

enum class Cull : std::uint8_t { Front, Back, None }; ///< Front is the usual: the side that faces away is not drawn

/// surfaceparm words and the flags of the BSP's shader lump, joined.
struct SurfaceParms {
    bool sky = false, noDraw = false, translucent = false, fog = false, noLightmap = false, alphaShadow = false,
         lightFilter = false, clip = false, trigger = false, areaPortal = false, hint = false, nonSolid = false,
         water = false, slime = false, lava = false, structural = true, pointLight = false;

    /// Joins the flags of the BSP's shader lump, which the compiler took from the script it saw.
    void addFlags(std::int32_t surfaceFlags, std::int32_t contentFlags);
};

/// q3map_sun and its variants: direction *towards* the sun. E = colour * intensity * cos, in lightmap units U.
struct SunKey {
    Rgb colour{1.0F};
    float intensity = 0, degrees = 0, elevation = 0, deviance = 0;
    int samples = 1;
};
/// q3map_skyLight value iterations.
struct SkyLightKey {
    float value = 0;
    int iterations = 0;
};
/// `q3map_surfacelight` and what belongs to it (LEVELS in doc/manual.md).
struct LightKeys {
    float surfaceLight = 0;
    std::optional<Rgb> colour; ///< q3map_lightRGB
    std::string lightImage;    ///< q3map_lightimage
    float backsplashPercent = 5, backsplashDistance = 23;
    float bounce = 1;
    std::vector<SunKey> suns;
    std::vector<SkyLightKey> skyLights;
};

struct FogKeys {
    Rgb colour{0.0F};
    float opaqueDistance = 0;
};

enum class DeformKind : std::uint8_t { Wave, Normal, Bulge, Move, AutoSprite, AutoSprite2, ProjectionShadow, Text };
struct Deform {
    DeformKind kind = DeformKind::Wave;
    float spread = 0;
    Vec3 direction{0.0F};
    Wave wave;
};

struct Shader {
    std::string name;
    std::string origin; ///< "scripts/x.shader:12", or "image", or "missing"
    SurfaceParms parms;
    Cull cull = Cull::Front;
    std::vector<Stage> stages;
    std::vector<Deform> deforms;
    bool polygonOffset = false;
    bool portal = false;
    std::optional<float>
        sort; ///< the game's number: 2 sky, 3 opaque, 5 see-through, 9 blended …; always set by the library
    std::string editorImage;
    std::string skyBox; ///< farbox base name of skyParms, "-" for a sky without box; empty: no skyParms
    float cloudHeight = 0;
    std::optional<FogKeys> fog;
    LightKeys light;
    /// What the game refuses in the script. It then shows its default picture (a grey box) instead; here the stages are
    /// kept as far as they were understood.
    std::vector<std::string> defects;

    /// False for what the game never shows: nodraw, clip, trigger, hint, area portals … and fog volumes without stages.
    [[nodiscard]] bool drawn() const;
    [[nodiscard]] bool twoSided() const { return cull == Cull::None; }
    /// First stage opaque (or alpha-tested): drawn with depth writes before everything that blends.
    [[nodiscard]] bool opaque() const;
};

/// All scripts of a file system. A script that defines a name wins over an image of that name; of several definitions
/// of one name in files of different names the one in the *lower* archive wins, as in the game (see `load` in the
/// source). Definitions are parsed when they are asked for. `find` and `resolve` may be called from several threads.
class ShaderLibrary {
public:
    ShaderLibrary();
    [[nodiscard]] static ShaderLibrary load(const Vfs& files);
    /// Adds the definitions of one text below those that are already there; where braces do not match, the rest of the
    /// text is dropped with a warning.
    void parse(std::string_view text, const std::string& fileName);
    /// Null if no script defines it. The pointer lives as long as the library and its copies.
    [[nodiscard]] const Shader* find(std::string_view name) const;
    /// The script's shader, or the game's implicit one for an image of that name: lightmapped (lightmap stage × image)
    /// or vertex-lit. Its origin is "image" whether the image exists or not.
    [[nodiscard]] Shader resolve(std::string_view name, bool lightmapped) const;
    /// All defined names, sorted.
    [[nodiscard]] std::vector<std::string> names() const;
    [[nodiscard]] const std::vector<std::string>& warnings() const;

private:
    struct Index;
    std::shared_ptr<Index> index_;
};

} // namespace pie::level
