#include "pie/engine/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace pie::engine {

scene::SceneOptions sceneOptions(const Settings& settings) {
    scene::SceneOptions options;
    options.reflectance = settings.reflectance;
    options.maxReflectance = settings.maxReflectance;
    options.linear = settings.colorSpace == ColorSpace::Srgb;
    return options;
}

scene::RefineOptions refineOptions(const Settings& settings) {
    scene::RefineOptions options;
    options.maxSplits = static_cast<std::size_t>(settings.meshRefinement);
    options.maxEdge = settings.maxEdge;
    options.tolerance = settings.tJunctionTolerance;
    options.maxTriangles = static_cast<std::size_t>(settings.maxTriangles);
    return options;
}

lights::ImportOptions importOptions(const Settings& settings) {
    lights::ImportOptions options;
    options.entities = settings.lightEntities;
    options.scripts = settings.lightScripts;
    options.backsplash = settings.backsplash;
    options.pointScale = settings.pointScale * settings.lightScale;
    options.areaScale = settings.areaScale * settings.lightScale;
    options.skyScale = settings.skyScale * settings.lightScale;
    options.linear = settings.colorSpace == ColorSpace::Srgb;
    return options;
}

Settings chosen(Settings settings) {
    const auto choose = [&](std::string_view key, std::string_view value) {
        // Within their range, so this cannot fail; and below whatever was set.
        if (settings.origin(key) <= Source::Preset) (void)settings.set(key, value, Source::Preset);
    };
    if (settings.budgetMs > 0) {
        // Answers for what is in view then fit about once into a frame (doc/performance.md). Longest edges are split
        // first, so a bound on triangles is one on the length of edges.
        constexpr float trianglesOfMillisecond = 12'000;
        const float triangles = std::min(4e6F, trianglesOfMillisecond * settings.budgetMs);
        const bool free = settings.origin("max_edge") <= Source::Preset;
        if (free) choose("max_triangles", fmt::format("{:.0f}", triangles));
        choose("max_edge", "32");
    }
    if (settings.targetError > 0) {
        struct Rung {
            float target;
            std::string_view rays, directTolerance;
        };
        // doc/trade.md has what each is good for.
        constexpr std::array<Rung, 4> ladder{
            {{4, "128", "2"}, {2, "256", "1"}, {1, "1024", "0.2"}, {0, "4096", "0.05"}}};
        const Rung& rung = *std::find_if(ladder.begin(), ladder.end(),
                                         [&](const Rung& r) { return settings.targetError >= r.target; });
        choose("standard_errors", "true");
        choose("gather_rays", rung.rays);
        choose("direct_tolerance", rung.directTolerance);
        // More frames than anybody waits for: the errors say when it is enough.
        choose("still_frames", "10000");
    }
    return settings;
}

bool gathers(const Settings& settings) {
    return settings.estimator == EstimatorKind::Gather && !settings.finalGathering;
}

bool texelsByPhotons(const Settings& settings, const lights::LightSet& lights) {
    constexpr std::size_t many = 16;
    if (!gathers(settings) || settings.recursionDepth == 0) return false;
    return settings.texelLight == TexelLight::Auto ? lights.lights().size() > many
                                                   : settings.texelLight == TexelLight::Photons;
}

photons::TracerOptions tracerOptions(const Settings& settings, const lights::LightSet& lights) {
    photons::TracerOptions options;
    options.scattering = settings.scattering;
    options.diffuseReflections = static_cast<unsigned>(settings.diffuseReflections);
    options.recursionDepth = static_cast<unsigned>(settings.recursionDepth);
    // The gather is a reflection itself.
    if (gathers(settings) && options.recursionDepth > 0) --options.recursionDepth;
    options.storeDirectLight = settings.storesDirectLight() || texelsByPhotons(settings, lights);
    options.lightDistribution = settings.lightDistribution;
    options.diffuseDistribution = settings.diffuseDistribution;
    options.photonsPerFrame = static_cast<std::uint64_t>(settings.photonsFromLight);
    options.seed = settings.seed;
    return options;
}

gather::NearestOptions nearestOptions(const Settings& settings) {
    gather::NearestOptions options;
    options.maxCount = static_cast<std::size_t>(settings.maxSearchCount);
    options.maxRadius = settings.maxSearchRadius;
    options.radiusHeuristic = settings.useRadiusHeuristic;
    options.heuristicAlpha = settings.radiusHeuristicAlpha;
    options.radius = settings.searchRadius;
    options.progressiveAlpha = settings.progressiveAlpha;
    options.volume = settings.volume();
    options.slice.halfThickness = settings.sphereSlice;
    options.incomingDirection = settings.useIncomingDirection;
    options.area = settings.usesTrueArea() ? gather::AreaEstimate::True : settings.area;
    options.kernel = settings.kernel;
    options.indirectOnly = settings.directLight == DirectLight::ShadowRays && !settings.finalGathering;
    return options;
}

} // namespace pie::engine
