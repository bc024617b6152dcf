#pragma once
// A Quake 3 shader as one GLSL 1.20 program. The stages of the script are composed in the fragment shader, so a surface
// is drawn once however many stages it has: a stage is an affine map C → P + Q·C of what is already there, and a chain
// of affine maps is affine. If the first stage is opaque the result is a colour; otherwise the chain ends in one blend
// function. Pure data, no OpenGL: tests read it without a display.

#include "pie/level/shader.h"

#include <string>
#include <vector>

namespace osgpie {

/// What the light of a lit stage is taken from.
enum class LightSource {
    Irradiance, ///< vertex colour = our irradiance over the overbright range
    Lightmap,   ///< the level's lightmap texture; vertex-lit stages take the level's vertex colours
    Vertex,     ///< the level's vertex colours; $lightmap is white, as in the game on surfaces without one
    None,       ///< full bright
};

struct Look {
    LightSource light = LightSource::Irradiance;
    bool textures = true;    ///< false: the light alone (view = light)
    float overbright = 1.0F; ///< largest light value shown; light is stored divided by it
    bool addSigned = false;  ///< pi-engine eq 3.8 instead of 3.9
    bool linear = false;     ///< multiply linearised texels, tone-map, encode (color_space = srgb)
    bool animate = true;     ///< false: time stands at zero
    bool fog = false;        ///< the surface stands in a fog volume: uniforms fogColour, fogPlane, fogOpaque
    /// Every view in one program (view_program.h); `light` is Irradiance then, and the baked light comes as
    /// gl_SecondaryColor and, on surfaces that have one, from the lightmap.
    bool switchable = false;
    bool lightmapped = false; ///< switchable: the surface has a lightmap
    float cloudHeight = 0;    ///< makeSkyProgram only
};

/// A texture unit of the program.
struct UnitTexture {
    pie::level::Stage::Source source = pie::level::Stage::Source::Image;
    std::vector<std::string> images; ///< frames of an animation, or one
    float framesPerSecond = 0;
    bool clamp = false;
};

struct MaterialProgram {
    std::string vertexSource, fragmentSource;
    std::vector<UnitTexture> units;   ///< units[0] is the picture of the surface, also for fixed-function rendering
    bool visible = true;              ///< false: nothing to draw in this look
    bool lit = false;                 ///< some stage shows light
    bool vertexLit = false;           ///< light comes with the vertices (Irradiance, or rgbGen vertex)
    bool lightmapCoordinates = false; ///< the lightmap's texture coordinates are read
    bool alphaTested = false;
    bool blended = false;
    pie::level::Blend blend; ///< when blended
    bool depthWrite = true;
    int bin = 0; ///< render order: 0 opaque, 1 decals, 10 … blended in the game's order of sorts
};

[[nodiscard]] MaterialProgram makeMaterialProgram(const pie::level::Shader& shader, const Look& look);

/// The same for a sky shader, drawn on a cube around the eye: the six sides of the sky box (units 0 to 5, if the shader
/// has one), then the cloud stages on a dome of radius 4096 + cloudHeight, as the game maps them.
[[nodiscard]] MaterialProgram makeSkyProgram(const pie::level::Shader& shader, const Look& look);

} // namespace osgpie
