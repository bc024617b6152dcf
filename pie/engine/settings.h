#pragma once
// Every parameter of the engine and of the view, in one struct, and a table that describes each: key, type, default,
// unit, range, what it costs in speed and accuracy, and its number in the paper (pi-engine 6.1). Whatever shows, reads
// or documents a setting reads the table; a new setting is one field here and one row there.
//
// Protocol: make a Settings, then feed it in any order: `readFile` (TOML), `setOptions` (an OSG option string) and
// `set` (one key from a command line). The source ranks, not the order of the calls: default < preset < level < file <
// option string < command line; a value from a lower source never replaces one from a higher. `origin` tells where a
// value came from. Errors name the key and what is allowed; a key that does not exist is an error that suggests the
// nearest. A call that fails changes nothing.

#include "pie/core/result.h"
#include "pie/gather/nearest_photons.h"
#include "pie/intersect/intersector.h"
#include "pie/photons/tracer.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pie::engine {

/// What is shown. Lit: light by photons. Baked: the level's own lightmaps and vertex colours. Light, Lightmap: as Lit
/// and Baked, without textures. Split: Baked on the left, Lit on the right. Difference: our light less the baked, in
/// false colour. The rest looks inside.
enum class View : std::uint8_t {
    Lit,
    Baked,
    Fullbright,
    Light,
    Lightmap,
    Split,
    Difference,
    Normals,
    Triangles,
    CoarseTriangles,
    Photons,
    Samples
};
/// Gather: a cached final gather over surface texels. Nearest: the photons near by. TrueArea is short for Nearest with
/// area = true_area.
enum class EstimatorKind : std::uint8_t { Gather, TrueArea, Nearest };
enum class DirectLight : std::uint8_t { ShadowRays, Photons };
/// Where the texels of a gather have direct light from.
enum class TexelLight : std::uint8_t { Auto, ShadowRays, Photons };
/// What decides where triangles are split: Length, or Light: where direct light changes.
enum class RefineBy : std::uint8_t { Length, Light };
enum class PhotonMapKind : std::uint8_t { KdTree, Exact };
/// Quake3: colours are used as stored; Srgb: linearised, and encoded again for display.
enum class ColorSpace : std::uint8_t { Quake3, Srgb };
/// How light meets the texture: Multiply is pi-engine eq 3.9, AddSigned eq 3.8.
enum class Blending : std::uint8_t { Multiply, AddSigned };
enum class Renderer : std::uint8_t { Glsl, Fixed };

/// Points on the measured front of speed against accuracy (doc/trade.md). None: every setting for itself.
enum class Preset : std::uint8_t { None, Draft, Balanced, Accurate };

/// Where a value came from, lowest precedence first. Preset: from `preset`, or chosen by budget_ms or target_error.
enum class Source : std::uint8_t { Default, Preset, Level, File, Options, CommandLine };
/// "default", "preset", "level", "file", "options", "command line"
[[nodiscard]] std::string_view sourceName(Source source);

struct Settings {
    // View
    View view = View::Lit;
    Renderer renderer = Renderer::Glsl;
    ColorSpace colorSpace = ColorSpace::Quake3;
    bool switchViews = false;  ///< programs hold every view
    float exposure = 1;        ///< factor on light before display
    float overbrightClamp = 1; ///< light is cut, hue kept, at this multiple of "texture as it is"
    Blending blending = Blending::Multiply;
    bool drawSky = true, drawFog = true, animate = true;
    bool deluxe = true; ///< baked: recognise interleaved deluxe lightmaps

    // Speed and accuracy
    Preset preset = Preset::None;
    float budgetMs = 0;    ///< milliseconds of a frame for light; 0: no bound
    float targetError = 0; ///< per cent, relative standard error; 0: none

    // Photons
    int photonsFromLight = 10'000; ///< emitted per frame, by all lights together
    int accumulationFrames = 10;
    photons::TracerOptions::Scattering scattering = photons::TracerOptions::Scattering::RussianRoulette;
    int recursionDepth = 32;
    int diffuseReflections = 36;
    bool storeDirectLight = false;
    int snowballSize = 1;      ///< photons stored for one hit
    float snowballRadius = 16; ///< units
    sampling::Distribution lightDistribution = sampling::Distribution::Halton;
    sampling::Distribution diffuseDistribution = sampling::Distribution::Halton;
    std::uint64_t seed = 0;
    intersect::Kind intersector = intersect::Kind::Embree;

    // Irradiance
    EstimatorKind estimator = EstimatorKind::Gather;
    float texelSize = 0;      ///< units; 0: from the scene
    int gatherRays = 256;     ///< per receiver
    bool aimedRays = true;    ///< a quarter as many again, at bright texels
    int refineRays = 200'000; ///< per frame
    int stillFrames = 100;    ///< photons of so many frames, at most
    bool standardErrors = false;
    gather::Kernel kernel = gather::Kernel::Epanechnikov;
    gather::AreaEstimate area = gather::AreaEstimate::Disc; ///< of EstimatorKind::Nearest
    PhotonMapKind photonMap = PhotonMapKind::KdTree;
    maps::SplitBy splitMaps = maps::SplitBy::None;
    int maxSearchCount = 100;
    float maxSearchRadius = 192; ///< units
    gather::RadiusRule searchRadius = gather::RadiusRule::Nearest;
    float progressiveAlpha = 0.7F;
    bool useRadiusHeuristic = false;
    float radiusHeuristicAlpha = 0.05F; ///< share of the mean radiance below which an estimate counts as dark
    gather::SearchVolume searchVolume = gather::SearchVolume::Slice;
    bool useSphereSlice = true; ///< false: a slice is a whole sphere
    float sphereSlice = 4;      ///< units; half thickness of slice, cylinder and ellipsoid
    bool useIncomingDirection = true;
    bool useEstimateCache = true;
    bool finalGathering = false;
    int finalGatheringSamples = 256;
    float finalGatheringDistance = 16; ///< units; nearer hits are gathered once more
    int finalGatheringSecondary = 16;
    int precomputeIrradiance = 0; ///< every how many photons; 0: never
    float irradianceCache = 0;    ///< Ward's a; 0: none
    DirectLight directLight = DirectLight::ShadowRays;
    TexelLight texelLight = TexelLight::Auto;
    int directSamples = 64;    ///< shadow rays per soft source and receiver, at most
    float directTolerance = 2; ///< lightmap units U, standard error

    // Geometry
    int meshRefinement = std::numeric_limits<int>::max(); ///< splits, at most
    float maxEdge = 64;                                   ///< units
    RefineBy refineBy = RefineBy::Length;
    float refineError = 8; ///< lightmap units U
    int maxVertices = 4'000'000;
    int maxTriangles = 4'000'000;
    float tJunctionTolerance = 0.01F; ///< units
    float patchTolerance = 1;         ///< units
    int cellTriangles = 1500;

    // Surfaces and lights
    scene::ReflectanceModel reflectance = scene::ReflectanceModel::Texture;
    float maxReflectance = 0.95F;
    bool lightEntities = true, lightScripts = true, backsplash = true;
    float lightScale = 1;                              ///< multiplies every light, beside the scale of its kind
    float pointScale = 1, areaScale = 1, skyScale = 1; ///< by kind: entities, emissive surfaces, sky and sun
    bool flashlight = false;                           ///< a spot light at the view
    float flashlightIntensity = 3000;                  ///< of a light entity

    // Files and run
    std::string game;                  ///< game directory; empty: the one around the level
    std::vector<std::string> textures; ///< further game directories, searched after the level's own
    std::string config;                ///< the TOML file read last
    bool settle = false;               ///< all light while loading, then no callbacks
    int threads = 0;                   ///< 0: one per core
    bool stats = false;

    /// Takes `value` for `key`. True when it is in effect, false when a higher source had set the key before. `config`
    /// reads the file it names, as a file.
    Result<bool> set(std::string_view key, std::string_view value, Source source);
    /// "key=value key2=value2", separated by white space, without quoting (OSG's -O). A word without '=' is the value
    /// true of a bool ("stats"). All or nothing.
    Result<bool> setOptions(std::string_view options, Source source = Source::Options);
    /// One "key=value", as after --set; the value may hold spaces.
    Result<bool> setPair(std::string_view pair, Source source);
    /// Flat `key = value` lines of a TOML file; lists are arrays. Relative folders in it are meant from the file's own
    /// folder. Errors carry line and column.
    Result<bool> readFile(const std::filesystem::path& file);

    /// Whether first hits go into the photon map: asked for, or needed because direct light is to come from there, or
    /// because final gathering sees it on other surfaces.
    [[nodiscard]] bool storesDirectLight() const {
        return storeDirectLight || directLight == DirectLight::Photons || finalGathering;
    }

    /// Whether one program holds every view, so that another is a uniform away.
    [[nodiscard]] bool viewsSwitch() const { return renderer == Renderer::Glsl && (switchViews || view > View::Light); }
    /// Whether our light is shown, or may be at any moment.
    [[nodiscard]] bool showsOurLight() const {
        return view == View::Lit || view == View::Light || viewsSwitch() || view > View::Light;
    }

    /// The search volume in effect.
    [[nodiscard]] gather::SearchVolume volume() const {
        return searchVolume == gather::SearchVolume::Slice && !useSphereSlice ? gather::SearchVolume::Sphere
                                                                              : searchVolume;
    }
    /// Whether flux is divided by the surface that exists.
    [[nodiscard]] bool usesTrueArea() const {
        return estimator == EstimatorKind::TrueArea || area == gather::AreaEstimate::True;
    }

    [[nodiscard]] Source origin(std::string_view key) const;     ///< Default for unknown keys
    [[nodiscard]] std::string value(std::string_view key) const; ///< as `set` reads it; empty for unknown keys
    /// What is in effect and differs from the default, one "key=value (source)" each in table order; `all`: everything.
    [[nodiscard]] std::vector<std::string> effective(bool all = false) const;
    /// What no value alone shows: combinations that do nothing or contradict, one line each.
    [[nodiscard]] std::vector<std::string> warnings() const;

private:
    void applyPreset();
    std::vector<Source> origins_; ///< by row of the table; empty: all Default
};

/// One row of the table, as text.
struct SettingInfo {
    std::string_view key;
    std::string_view group;       ///< "View", "Photons", …
    std::string syntax;           ///< "lit|baked|fullbright|light", "true|false", "<integer>", "<number>", "<folder>"
    std::string defaultValue;     ///< as `set` reads it
    std::string_view unit;        ///< "units", "watts per square unit"; may be empty
    std::string range;            ///< "1 to 10000000"; empty where the syntax says all
    std::string_view consequence; ///< what it does, and what more or less of it costs in speed and accuracy
    std::string_view paper;       ///< "pi-engine parameter 9"; may be empty
};
/// All rows, in the order in which they are to be shown.
[[nodiscard]] std::span<const SettingInfo> describe();
/// The table as Markdown, as it stands in doc/settings.md.
[[nodiscard]] std::string settingsPage();

} // namespace pie::engine
