#include "pie/engine/settings_table.h"

#include <algorithm>
#include <array>

namespace pie::engine::table {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
constexpr double largestInt = std::numeric_limits<int>::max();

template <auto Member> constexpr Choice choice(std::span<const std::string_view> names) {
    return {names,
            [](Settings& settings, std::size_t value) {
                settings.*Member = static_cast<std::remove_reference_t<decltype(settings.*Member)>>(value);
            },
            [](const Settings& settings) { return static_cast<std::size_t>(settings.*Member); }};
}

// In the order of the enumerations.
constexpr std::array<std::string_view, 12> viewNames{
    "lit",     "baked",     "fullbright",       "light",   "lightmap", "split", "difference",
    "normals", "triangles", "coarse_triangles", "photons", "samples"};
constexpr std::array<std::string_view, 4> presetNames{"none", "draft", "balanced", "accurate"};
constexpr std::array<std::string_view, 2> rendererNames{"glsl", "fixed"};
constexpr std::array<std::string_view, 2> colorSpaceNames{"quake3", "srgb"};
constexpr std::array<std::string_view, 2> blendingNames{"multiply", "add_signed"};
constexpr std::array<std::string_view, 2> scatteringNames{"roulette", "split"};
constexpr std::array<std::string_view, 7> distributionNames{"halton",    "sobol",      "r2",    "explicit",
                                                            "rejection", "stratified", "spiral"};
constexpr std::array<std::string_view, 3> intersectorNames{"brute_force", "bsp", "embree"};
constexpr std::array<std::string_view, 3> estimatorNames{"gather", "true_area", "nearest"};
constexpr std::array<std::string_view, 4> kernelNames{"constant", "cone", "gaussian", "epanechnikov"};
constexpr std::array<std::string_view, 6> areaNames{"pi_r2",   "box",         "oriented_box",
                                                    "ellipse", "convex_hull", "true_area"};
constexpr std::array<std::string_view, 4> volumeNames{"sphere", "slice", "cylinder", "ellipsoid"};
constexpr std::array<std::string_view, 3> radiusNames{"nearest", "fixed", "progressive"};
constexpr std::array<std::string_view, 2> mapNames{"kd_tree", "exact"};
constexpr std::array<std::string_view, 4> splitNames{"none", "normal", "cell", "both"};
constexpr std::array<std::string_view, 2> directNames{"shadow_rays", "photons"};
constexpr std::array<std::string_view, 3> texelLightNames{"auto", "shadow_rays", "photons"};
constexpr std::array<std::string_view, 2> refineByNames{"length", "light"};
constexpr std::array<std::string_view, 2> reflectanceNames{"texture", "compiler"};

// clang-format off: one row is one paragraph
constexpr std::array table{
    Row{"view", "View", choice<&Settings::view>(viewNames), 0, 0, "",
        "lit: light by photons. baked: the level's own lightmaps and vertex colours, as the game shows them. "
        "fullbright: textures alone. "
        "light: as lit, without textures. lightmap: as baked, without textures. split: baked on the left, lit on the "
        "right. difference: lit less baked, red where ours is brighter, blue where it is darker. normals. triangles, "
        "coarse_triangles: edges of what is drawn, and of the level as it is in the file. photons: where they land. "
        "samples: rays spent on each vertex so far. baked and fullbright trace no photons.",
        ""},
    Row{"switch_views", "View", &Settings::switchViews, 0, 0, "",
        "Every surface's program holds all views, so that an application changes between them while the level is "
        "shown. Drawing costs a little more, and photons are prepared whatever the view. Not with renderer = fixed.",
        ""},
    Row{"renderer", "View", choice<&Settings::renderer>(rendererNames), 0, 0, "",
        "glsl: light as floats through a GLSL 1.20 shader. fixed: for drivers without shaders; light is clamped to "
        "what 8 bits and the "
        "texture combiners hold.",
        ""},
    Row{"color_space", "View", choice<&Settings::colorSpace>(colorSpaceNames), 0, 0, "",
        "quake3: textures and light colours are multiplied as stored, as the game does. srgb: they are linearised and "
        "the picture is "
        "encoded again; truer to optics, unlike the game. Same speed.",
        ""},
    Row{"exposure", "View", &Settings::exposure, 0, 1000, "", "Factor on light before display. 1 is the game's scale.",
        ""},
    Row{"overbright_clamp", "View", &Settings::overbrightClamp, 1, 16, "texture multiples",
        "Light beyond this multiple of the plain texture is cut with its hue kept: 1 as the game in a window, 2 as "
        "with "
        "hardware gamma (full screen on old systems).",
        ""},
    Row{"blending", "View", choice<&Settings::blending>(blendingNames), 0, 0, "",
        "How light meets the texture. multiply: C = 2 Cf Ct. add_signed: C = 2 Cf - 1 + Ct, which brightens and "
        "darkens but is not physical. Cf = 1/2 shows the texture as it is.",
        "pi-engine eq 3.9 and 3.8"},
    Row{"draw_sky", "View", &Settings::drawSky, 0, 0, "", "Draw sky boxes and clouds; off leaves the clear colour.",
        ""},
    Row{"draw_fog", "View", &Settings::drawFog, 0, 0, "", "Draw fog volumes.", ""},
    Row{"animate", "View", &Settings::animate, 0, 0, "",
        "Move textures, waves and animated pictures with time; off freezes them at time 0, so that pictures repeat.",
        ""},
    Row{"deluxe", "View", &Settings::deluxe, 0, 0, "",
        "baked: recognise lightmaps that alternate with light directions and skip those. Off when a level is taken for "
        "one by mistake.",
        ""},

    Row{"preset", "Speed and accuracy", choice<&Settings::preset>(presetNames), 0, 0, "",
        "Points on the measured front of speed against accuracy (doc/trade.md). draft: a fifth to a third of the time "
        "of a frame, "
        "soft shadows' edges in coarse steps. balanced: half as sharp again as the default, in less time a frame, "
        "refined later. "
        "accurate: sharper still, at several times the refinement. What is set besides stays as set. none: the "
        "defaults.",
        ""},
    Row{"budget_ms", "Speed and accuracy", &Settings::budgetMs, 0, 10'000, "milliseconds a frame",
        "Time that light may take of a frame, update and draw together, drawing itself not counted. Photons, "
        "refinement "
        "and the order of work then follow from it: lights that change first, then what is in view; answers that do "
        "not "
        "fit come a few frames later. Where max_edge and max_triangles are not set, triangles are at most 12,000 a "
        "millisecond, down to edges of 32. 0: a frame takes what photons_from_light and refine_rays cost. What a still "
        "view "
        "ends with is the same.",
        ""},
    Row{"target_error", "Speed and accuracy", &Settings::targetError, 0, 100, "per cent",
        "estimator = gather: trace photons until the relative standard error of what is in view is no larger, or until "
        "more photons do not help; then idle. gather_rays and direct_tolerance follow from it where they are not set. "
        "512 bytes a texel more. 0: still_frames says when to stop.",
        ""},

    Row{"photons_from_light", "Photons", &Settings::photonsFromLight, 0, 10'000'000, "photons per frame",
        "Photons that all lights together emit in a frame. Time for tracing and building grows in proportion; noise "
        "falls with the square "
        "root.",
        "pi-engine parameter 9"},
    Row{"accumulation_frames", "Photons", &Settings::accumulationFrames, 1, 1000, "frames",
        "Frames whose photons are kept together. More: less noise at the same tracing time, more memory and search "
        "time, and light that "
        "follows changes later.",
        "pi-engine parameter 10"},
    Row{"scattering", "Photons", choice<&Settings::scattering>(scatteringNames), 0, 0, "",
        "roulette: at a hit one photon goes on, with the probability of the reflectance; all photons have similar "
        "power. split: "
        "diffuse_reflections weaker ones do; many rays per photon, and dim photons fill the nearest-photon search.",
        "pi-engine 5.2"},
    Row{"recursion_depth", "Photons", &Settings::recursionDepth, 0, 100, "bounces",
        "Diffuse reflections of a photon at most; 0 leaves direct light only. Light from later bounces is lost: dark "
        "where walls are bright.",
        "pi-engine parameter 12"},
    Row{"diffuse_reflections", "Photons", &Settings::diffuseReflections, 1, 1000, "photons",
        "scattering = split: photons that one photon becomes at its first hit. More spread the light better and cost "
        "as many rays.",
        "pi-engine parameter 13"},
    Row{"store_direct_light", "Photons", &Settings::storeDirectLight, 0, 0, "",
        "Keep first hits in the photon map. direct_light = photons and texel_light = photons do so by themselves; else "
        "it costs memory "
        "and search time and "
        "shows nothing.",
        "pi-engine parameter 11"},
    Row{"light_distribution", "Photons", choice<&Settings::lightDistribution>(distributionNames), 0, 0, "",
        "How photons are spread over lights and directions. halton, sobol, r2: quasi-random, even over any number of "
        "photons. explicit, rejection: random numbers, the noise to compare with. stratified, spiral: a set for each "
        "frame of photons_from_light, even within it alone. spiral is best for direct light of one lamp, sobol and "
        "halton for the rest; the others but explicit lengthen tracing by 4 to 16 %.",
        "pi-engine parameter 15, 3.4"},
    Row{"diffuse_distribution", "Photons", choice<&Settings::diffuseDistribution>(distributionNames), 0, 0, "",
        "The same for the directions of reflections.", "pi-engine parameter 16, eq 3.11"},
    Row{"snowball_size", "Photons", &Settings::snowballSize, 1, 64, "photons",
        "Photons that one hit fills into the map, spread over a small circle on its triangle. Smoother without a ray "
        "more; "
        "longer searches, and max_search_count has to grow along.",
        "pi-engine parameter 14"},
    Row{"snowball_radius", "Photons", &Settings::snowballRadius, 0, unbounded, "units",
        "Radius of that circle. Larger: smoother, and light leaks into shadows.", "pi-engine parameter 14"},
    Row{"seed", "Photons", &Settings::seed, 0, 0, "",
        "Same seed, same bits, on any number of threads. Another seed shows what in a picture is noise.", ""},
    Row{"intersector", "Photons", choice<&Settings::intersector>(intersectorNames), 0, 0, "",
        "embree: a bounding volume hierarchy, the fast one. bsp: the level's own tree, as the paper. brute_force: "
        "every triangle for every "
        "ray, the judge. The same picture, but for ties on shared edges.",
        "pi-engine parameter 1, BSP_tree"},

    Row{"estimator", "Irradiance", choice<&Settings::estimator>(estimatorNames), 0, 0, "",
        "gather: photons are summed into surface texels, and every receiver gathers from the texels it sees by rays "
        "that "
        "are shot once and kept; the most accurate and, once the rays are there, the fastest. nearest: flux of the "
        "photons near by over `area`; the paper's with area = pi_r2. true_area: the same with area = true_area.",
        "pi-engine 3.2.2 and eq 3.3"},
    Row{"texel_size", "Irradiance", &Settings::texelSize, 0, 1e7, "units",
        "estimator = gather: edge of the surface texels that photons are summed into. 0: from the scene, 64 in levels "
        "of the usual size. "
        "Smaller: sharper indirect light, more noise near walls, more memory.",
        ""},
    Row{"gather_rays", "Irradiance", &Settings::gatherRays, 2, 65'536, "rays per receiver",
        "estimator = gather: rays of a finished receiver, rounded up to a power of two. Set-up time and memory grow in "
        "proportion; what noise stays in a still picture falls about with their power 3/4.",
        "pi-engine parameter 8, final_gathering_samples"},
    Row{"aimed_rays", "Irradiance", &Settings::aimedRays, 0, 0, "",
        "estimator = gather: a quarter as many rays again are aimed at the texels that reflect most of the light. Less "
        "noise where lamps are close to walls; decided by where lights shine at first.",
        "virtual indirect lights"},
    Row{"refine_rays", "Irradiance", &Settings::refineRays, 0, 1'000'000'000, "rays per frame",
        "estimator = gather: rays spent in a frame on receivers in view that are not finished. More: the picture is "
        "sharp "
        "after fewer frames, each of which takes longer.",
        ""},
    Row{"still_frames", "Irradiance", &Settings::stillFrames, 1, 1'000'000, "frames",
        "estimator = gather: frames in which a still scene goes on tracing photons; all of them stay in the sums, at "
        "no "
        "cost in memory. More: less noise, later idle.",
        ""},
    Row{"standard_errors", "Irradiance", &Settings::standardErrors, 0, 0, "",
        "estimator = gather: keep photons in 16 batches, so that the noise of an answer is known (pieprobe). 512 bytes "
        "a "
        "texel more.",
        ""},
    Row{"kernel", "Irradiance", choice<&Settings::kernel>(kernelNames), 0, 0, "",
        "How much a photon counts by its distance. constant: all the same, as in the paper. epanechnikov: least error "
        "at the same radius. cone and gaussian: sharper still or softer, and noisier. Same speed.",
        "pi-engine 3.5"},
    Row{"area", "Irradiance", choice<&Settings::area>(areaNames), 0, 0, "",
        "What flux is divided by. pi_r2: a whole disc, the paper's; loses half of the light at edges, where a level's "
        "vertices are. box, oriented_box, ellipse, convex_hull: a shape around the photons found; no set-up, needs "
        "about 30 photons. true_area: the surface that exists, 48 bytes a receiver and a moment at first sight.",
        "pi-engine 3.5.2"},
    Row{"photon_map", "Irradiance", choice<&Settings::photonMap>(mapNames), 0, 0, "",
        "kd_tree: search time grows with the logarithm of the photons. exact: looks at every photon, the judge. The "
        "same photons are found.",
        "pi-engine 5.3"},
    Row{"split_maps", "Irradiance", choice<&Settings::splitMaps>(splitNames), 0, 0, "",
        "Several photon maps, of which a search looks into those that matter to the receiver. normal: by the direction "
        "that surfaces face in; photons of surfaces at more than 45 degrees to the receiver do not count. cell: by the "
        "level's visibility; photons that the receiver cannot see do not count. both: by both. Less light leaks round "
        "corners and through walls. Searches take 0.6 to 1.2 times as long: true_area gains, pi_r2 hardly.",
        "pi-engine 5.3.4"},
    Row{"max_search_count", "Irradiance", &Settings::maxSearchCount, 0, 1'000'000, "photons",
        "k: photons in one estimate, at most. More: less noise, more blur, longer searches. 0 gives no indirect light.",
        "pi-engine parameter 4"},
    Row{"max_search_radius", "Irradiance", &Settings::maxSearchRadius, 0, unbounded, "units",
        "Radius of the search, at most. Small: speckles where photons are few. Large: slow there, and light blurs over "
        "the radius.",
        "pi-engine parameter 5"},
    Row{"search_radius", "Irradiance", choice<&Settings::searchRadius>(radiusNames), 0, 0, "",
        "nearest: up to the photon number max_search_count, at most max_search_radius. fixed: max_search_radius "
        "everywhere; noise where photons are few, blur and time where they are many. progressive: nearest, with a "
        "count that grows and a radius that shrinks as frames come in, so that noise and blur both vanish in a still "
        "scene.",
        "pi-engine 3.2.1"},
    Row{"progressive_alpha", "Irradiance", &Settings::progressiveAlpha, 0, 1, "",
        "search_radius = progressive: the count grows as frames to this power. Less: sharper and noisier.", ""},
    Row{"use_radius_heuristic", "Irradiance", &Settings::useRadiusHeuristic, 0, 0, "",
        "Take the radius from the density of photons instead of max_search_radius: r = sqrt(k r_n\u00b2 / (alpha n)).",
        "pi-engine parameter 6, eq 3.7"},
    Row{"radius_heuristic_alpha", "Irradiance", &Settings::radiusHeuristicAlpha, 1e-6, 1, "share of the mean radiance",
        "Below this share of the mean an estimate counts as dark. Smaller: a larger radius, smoother and slower.",
        "pi-engine eq 3.7"},
    Row{"search_volume", "Irradiance", choice<&Settings::searchVolume>(volumeNames), 0, 0, "",
        "Where photons count. sphere: whatever is near, other surfaces too. slice: of that, what is near the "
        "receiver's "
        "plane. cylinder and ellipsoid: nearly the same, at more cost.",
        "pi-engine 3.5.1"},
    Row{"use_sphere_slice", "Irradiance", &Settings::useSphereSlice, 0, 0, "",
        "Count only photons near the receiver's plane, so that light does not leak round corners and through walls. "
        "Hardly any time.",
        "pi-engine parameter 7"},
    Row{"sphere_slice", "Irradiance", &Settings::sphereSlice, 0, unbounded, "units",
        "Half thickness of that slice. Thin: curved surfaces lose photons. Thick: light leaks from neighbouring "
        "surfaces.",
        "pi-engine 3.5"},
    Row{"use_incoming_direction", "Irradiance", &Settings::useIncomingDirection, 0, 0, "",
        "Refuse photons that came from behind the receiver: those of the back of thin walls. With true_area surfaces "
        "are told apart by their normals anyway.",
        "pi-engine 3.5.1"},
    Row{"use_estimate_cache", "Irradiance", &Settings::useEstimateCache, 0, 0, "",
        "Estimate a vertex once a frame, however many triangles share it. Off: the same picture, every copy anew.",
        "pi-engine parameter 3"},
    Row{"final_gathering", "Irradiance", &Settings::finalGathering, 0, 0, "",
        "Take indirect light from rays over the hemisphere, and only what they meet from the photon map (estimator, "
        "area, "
        "kernel … then say how). Smooth with few photons; hundreds of times as slow.",
        "pi-engine parameter 8"},
    Row{"final_gathering_samples", "Irradiance", &Settings::finalGatheringSamples, 0, 65536, "rays",
        "Rays of a final gather. Time grows in proportion, noise falls with nearly the inverse.",
        "pi-engine parameter 8"},
    Row{"final_gathering_distance", "Irradiance", &Settings::finalGatheringDistance, 0, unbounded, "units",
        "Hits nearer than this are gathered once more, because a wall close by shows the errors of the map. Most of "
        "the "
        "time at edges.",
        "pi-engine 3.2.2"},
    Row{"final_gathering_secondary", "Irradiance", &Settings::finalGatheringSecondary, 0, 4096, "rays",
        "Rays of such a second gather; 0: none.", "pi-engine 3.2.2"},
    Row{"precompute_irradiance", "Irradiance", &Settings::precomputeIrradiance, 0, 1000, "photons",
        "Final gathering: estimate irradiance at every n-th photon beforehand, and take that of the nearest at each "
        "hit. "
        "Faster where rays are many; 0: estimate at each hit.",
        "pi-engine 3.2.2"},
    Row{"irradiance_cache", "Irradiance", &Settings::irradianceCache, 0, 10, "",
        "Final gathering: gather at some receivers only and interpolate between them, with about this relative error. "
        "0.1 to 0.3; 0: gather at each.",
        "pi-engine 3.2.2"},
    Row{"direct_light", "Irradiance", choice<&Settings::directLight>(directNames), 0, 0, "",
        "shadow_rays: light straight from the sources by rays; sharp shadows, no noise from point sources. photons: "
        "from the photon map like "
        "the rest; shadows blur over the search radius.",
        "pi-engine parameter 11"},
    Row{"texel_light", "Irradiance", choice<&Settings::texelLight>(texelLightNames), 0, 0, "",
        "estimator = gather: where direct light on the surfaces that are gathered comes from. shadow_rays: once for "
        "each piece of surface that is seen; without noise, slow where sources are many. photons: from first hits; "
        "free, "
        "and smooth after some frames. auto: photons where there are more than 16 sources, backsplash counted.",
        ""},
    Row{"direct_samples", "Irradiance", &Settings::directSamples, 1, 4096, "rays",
        "Shadow rays per receiver to a source that gives all its light there; one that gives a tenth gets a tenth. "
        "More: smoother penumbras. From 8 to 64 costs a fifth more.",
        ""},
    Row{"direct_tolerance", "Irradiance", &Settings::directTolerance, 0, 255, "lightmap units",
        "Standard error that direct light may have by testing only a draw of the weak sources. Larger: faster in "
        "levels "
        "of many lights, and noisier from vertex to vertex; the mean stays.",
        ""},

    Row{"mesh_refinement", "Geometry", &Settings::meshRefinement, 0, largestInt, "splits",
        "Splits of the longest edge, at most. 0 draws the level's own triangles. See max_edge.",
        "pi-engine parameter 2"},
    Row{"max_edge", "Geometry", &Settings::maxEdge, 0.001, unbounded, "units",
        "Edges are split until none is longer. Half the length: four times the receivers, in time and memory, and "
        "shadows twice as sharp.",
        "pi-engine parameter 2"},
    Row{"refine_by", "Geometry", choice<&Settings::refineBy>(refineByNames), 0, 0, "",
        "length: every edge down to max_edge. light: edges down to 4 max_edge, then only those across which direct "
        "light changes by more than refine_error, down to max_edge / 8: fewer vertices for the same shadows, seconds "
        "of shadow rays before the first frame.",
        ""},
    Row{"refine_error", "Geometry", &Settings::refineError, 0.1, 10'000, "lightmap units",
        "refine_by = light: an edge is split where direct light in its middle differs by more than this from what its "
        "ends give. Smaller: more vertices, smoother and sharper.",
        ""},
    Row{"max_vertices", "Geometry", &Settings::maxVertices, 1000, 100'000'000, "vertices",
        "refine_by = light: splitting stops at so many, and what is worst was split first. The bound on what a frame "
        "costs.",
        ""},
    Row{"max_triangles", "Geometry", &Settings::maxTriangles, 1000, 100'000'000, "triangles",
        "Refinement stops here whatever the other two say: the bound on memory.", ""},
    Row{"t_junction_tolerance", "Geometry", &Settings::tJunctionTolerance, 0, 1, "units",
        "Vertices this near to the inside of another triangle's edge are joined to it, so that no cracks sparkle and "
        "light is continuous.",
        ""},
    Row{"patch_tolerance", "Geometry", &Settings::patchTolerance, 0.01, 1000, "units",
        "Distance between a curve and its chords, at most. Smaller: rounder, more triangles to trace and to draw.", ""},
    Row{"cell_triangles", "Geometry", &Settings::cellTriangles, 1, 10'000'000, "triangles",
        "Triangles that are culled and drawn together. Fewer: less is estimated that nobody sees, more draw calls.",
        "pi-engine 5.4"},

    Row{"reflectance", "Surfaces and lights", choice<&Settings::reflectance>(reflectanceNames), 0, 0, "",
        "texture: the mean texel, true to energy. compiler: 0.55147 times it and the shader's q3map_bounce, as the "
        "level compiler; darker "
        "indirect light, nearer to the baked one.",
        ""},
    Row{"max_reflectance", "Surfaces and lights", &Settings::maxReflectance, 0, 1, "",
        "No channel of a surface reflects more. At 1 light in a closed white room only ends at recursion_depth.", ""},
    Row{"light_entities", "Surfaces and lights", &Settings::lightEntities, 0, 0, "",
        "Light from entities of the level, or of the .map beside it.", ""},
    Row{"light_scripts", "Surfaces and lights", &Settings::lightScripts, 0, 0, "",
        "Light from shader scripts: emissive surfaces, sun and sky.", ""},
    Row{"backsplash", "Surfaces and lights", &Settings::backsplash, 0, 0, "",
        "The level compiler's second, weaker source in front of every emissive surface, shining back on it and its "
        "surroundings.",
        ""},
    Row{"light_scale", "Surfaces and lights", &Settings::lightScale, 0, 1e6, "",
        "Factor on the power of every light, on top of the three below.", ""},
    Row{"point_scale", "Surfaces and lights", &Settings::pointScale, 0, 1e6, "", "Factor on light entities.", ""},
    Row{"area_scale", "Surfaces and lights", &Settings::areaScale, 0, 1e6, "", "Factor on emissive surfaces.", ""},
    Row{"sky_scale", "Surfaces and lights", &Settings::skyScale, 0, 1e6, "", "Factor on sun and sky light.", ""},
    Row{"flashlight", "Surfaces and lights", &Settings::flashlight, 0, 0, "",
        "A spot light that follows the view. Its photons are traced anew whenever the view moves: a frame of "
        "photons_from_light more, and accumulation_frames until what it throws back has followed.",
        "pi-engine fig 6.9"},
    Row{"flashlight_intensity", "Surfaces and lights", &Settings::flashlightIntensity, 0, 1e6, "of a light entity",
        "How bright it is.", ""},

    Row{"game", "Files and run", Path{&Settings::game, true}, 0, 0, "",
        "Game directory (maps, textures, scripts, pk3 files). Empty: the one around the level.", ""},
    Row{"textures", "Files and run", &Settings::textures, 0, 0, "",
        "More game directories, searched after the level's own: a base game's. Several are separated by ':', in a file "
        "by an array.",
        ""},
    Row{"config", "Files and run", Path{&Settings::config, false}, 0, 0, "",
        "TOML file with settings, one `key = value` a line. Option strings and command lines win over it.", ""},
    Row{"settle", "Files and run", &Settings::settle, 0, 0, "",
        "Trace all photons and light every vertex while loading, and leave no callbacks behind: for converters "
        "(osgconv) "
        "and programs that never run an update. Loading takes seconds longer; the light stays as it is.",
        ""},
    Row{"threads", "Files and run", &Settings::threads, 0, 1024, "threads",
        "0: one per core. Changes the time, never the picture.", ""},
    Row{"stats", "Files and run", &Settings::stats, 0, 0, "",
        "Keep what was counted and how long each stage took, as JSON in the user value pie.statistics of the level's "
        "node.",
        ""},
};
// clang-format on

std::string plain(std::string_view key) {
    std::string text;
    for (const char c : key) {
        if (c >= 'A' && c <= 'Z') {
            if (!text.empty()) text += '_';
            text += static_cast<char>(c - 'A' + 'a');
        } else {
            text += c == '-' ? '_' : c;
        }
    }
    return text;
}

/// Edits (insert, delete, replace, swap neighbours) between two words.
std::size_t distance(std::string_view a, std::string_view b) {
    std::vector<std::vector<std::size_t>> edits(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) edits[i][0] = i;
    for (std::size_t j = 0; j <= b.size(); ++j) edits[0][j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i)
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = edits[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            edits[i][j] = std::min({edits[i - 1][j] + 1, edits[i][j - 1] + 1, replaced});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                edits[i][j] = std::min(edits[i][j], edits[i - 2][j - 2] + 1);
        }
    return edits[a.size()][b.size()];
}

} // namespace

std::span<const Row> rows() { return table; }

std::optional<std::size_t> find(std::string_view key) {
    const auto* const row = std::find_if(table.begin(), table.end(), [&](const Row& r) { return r.key == key; });
    if (row == table.end()) return std::nullopt;
    return static_cast<std::size_t>(row - table.begin());
}

std::string_view nearest(std::string_view key) {
    // Longer than any key can be meant; bounds the work on hostile input.
    const std::string wanted = plain(key.substr(0, 64));
    // A part of a name costs one edit ("photons" means photons_from_light rather than any word of seven letters); among
    // equals the shorter name is the commoner setting.
    const auto cost = [&](const Row& row) {
        const bool part = wanted.size() >= 4 && (row.key.starts_with(wanted) || row.key.ends_with(wanted));
        return std::pair(part ? std::size_t{1} : distance(wanted, row.key), row.key.size());
    };
    return std::min_element(table.begin(), table.end(), [&](const Row& a, const Row& b) { return cost(a) < cost(b); })
        ->key;
}

} // namespace pie::engine::table
