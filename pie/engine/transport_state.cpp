#include "pie/engine/transport_state.h"

#include "pie/core/clock.h"
#include "pie/engine/options.h"
#include "pie/gather/final_gather.h"
#include "pie/gather/nearest_photons.h"
#include "pie/maps/snowball.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pie::engine {
namespace {

gather::FinalGatherOptions finalGatherOptions(const Settings& settings) {
    gather::FinalGatherOptions options;
    options.samples = static_cast<unsigned>(settings.finalGatheringSamples);
    options.secondaryDistance = settings.finalGatheringDistance;
    options.secondarySamples = static_cast<unsigned>(settings.finalGatheringSecondary);
    options.precompute = static_cast<unsigned>(settings.precomputeIrradiance);
    options.cacheAccuracy = settings.irradianceCache;
    options.addDirect = settings.directLight == DirectLight::Photons;
    options.seed = settings.seed;
    return options;
}

/// But for what lights decide.
gather::GatherOptions gatherOptions(const Settings& settings) {
    gather::GatherOptions options;
    options.texels.edge = settings.texelSize;
    options.rays = static_cast<unsigned>(settings.gatherRays);
    options.reflections = static_cast<unsigned>(settings.recursionDepth);
    options.standardErrors = settings.standardErrors;
    options.seed = settings.seed;
    return options;
}

/// Null where photons are one map.
std::shared_ptr<const maps::Partition> partition(const Settings& settings, const scene::Scene& scene,
                                                 const level::Tree& tree) {
    if (gathers(settings) || settings.splitMaps == maps::SplitBy::None) return nullptr;
    return std::make_shared<const maps::Partition>(scene, tree, settings.splitMaps);
}

gather::DirectOptions directOptions(const Settings& settings) {
    gather::DirectOptions options;
    options.softSamples = static_cast<unsigned>(settings.directSamples);
    options.absoluteTolerance = settings.directTolerance;
    options.seed = settings.seed;
    return options;
}

ChangingOptions changingOptions(const Settings& settings, const lights::LightSet& lights) {
    ChangingOptions options;
    options.tracer = tracerOptions(settings, lights);
    options.shadowRays = settings.directLight == DirectLight::ShadowRays;
    options.direct = directOptions(settings);
    // Without reflections shadow rays are all there is.
    if (settings.recursionDepth > 0 || !options.shadowRays)
        options.photonsPerFrame = static_cast<std::uint64_t>(settings.photonsFromLight);
    else
        options.photonsPerFrame = 0;
    options.renewalFrames = static_cast<std::size_t>(settings.accumulationFrames);
    options.stillFrames = static_cast<std::size_t>(settings.stillFrames);
    return options;
}

void makeUnit(Vec3& direction) {
    const float length = glm::length(direction);
    if (length > 0.0F && std::isfinite(length)) direction /= length;
}
/// Directions as they are in a level.
void makeUnit(lights::Light& light) {
    if (auto* spot = std::get_if<lights::SpotLight>(&light)) makeUnit(spot->direction);
    if (auto* sun = std::get_if<lights::SunLight>(&light)) makeUnit(sun->towards);
}

/// Photons of a light that went out are traced again so many at once.
constexpr std::uint64_t takenBackAtOnce = 1 << 18;

} // namespace

Transport::State::State(Surroundings&& around, std::vector<lights::Light> theLights, const level::Tree& tree,
                        const scene::Receivers& theReceivers, const Settings& theSettings)
    : scene(std::move(around.scene)), lights(std::move(theLights), scene), intersector(std::move(around.intersector)),
      receivers(theReceivers), settings(chosen(theSettings)),
      tracer(*scene, lights, *intersector, tracerOptions(settings, lights)),
      map(static_cast<std::size_t>(settings.accumulationFrames),
          settings.photonMap == PhotonMapKind::Exact ? maps::Search::Exact : maps::Search::KdTree,
          partition(theSettings, *scene, tree)),
      levelLights(lights.lights().size()), lightCount(levelLights), cache(theReceivers.points.size()),
      budget(double{settings.budgetMs}), convergence(gathers(settings) ? double{settings.targetError} : 0),
      partsToTrace(partsOfFrame * static_cast<std::uint64_t>(settings.stillFrames)) {
    const gather::NearestOptions options = nearestOptions(settings);
    if (settings.directLight == DirectLight::ShadowRays)
        direct =
            std::make_unique<gather::DirectLight>(*scene, lights, *intersector, receivers, directOptions(settings));
    if (settings.finalGathering) {
        estimator = std::make_unique<gather::FinalGather>(*scene, *intersector, receivers, map, options,
                                                          finalGatherOptions(settings), direct ? &lights : nullptr);
    } else if (gathers(settings)) {
        gather::GatherOptions gatherSettings = gatherOptions(settings);
        gatherSettings.texelsByPhotons = texelsByPhotons(settings, lights);
        auto gather = std::make_unique<gather::CachedGather>(*scene, lights, *intersector, receivers, direct.get(),
                                                             gatherSettings, std::move(around.texels));
        gathering = gather.get();
        if (settings.recursionDepth > 0 && settings.aimedRays) aim(*gather);
        estimator = std::move(gather);
    } else {
        estimator = std::make_unique<gather::NearestPhotons>(*scene, receivers, map, options);
    }
    asked.assign(receivers.points.size(), 0);
    statistics.coarseTriangles = scene->triangles.size();
    statistics.lights = lights.lights().size();
    statistics.sceneBytes = scene->triangles.size() * (sizeof(scene::Triangle) + sizeof(Vec3)) +
                            scene->positions.size() * sizeof(Vec3) + scene->textureCoordinates.size() * sizeof(Vec2);
    statistics.intersectorBytes = intersector->bytes();
    statistics.receivers = receivers.points.size();
    statistics.receiverBytes = cache.bytes() + receivers.points.size() * sizeof(scene::Receiver) +
                               receivers.ofVertex.size() * sizeof(std::uint32_t);
}

/// Enough photons to tell what is bright, however many a frame has.
void Transport::State::aim(gather::CachedGather& gather) {
    constexpr std::uint64_t most = 100'000;
    photons::TracerOptions options = tracerOptions(settings, lights);
    options.recursionDepth = 0;
    options.storeDirectLight = true;
    const photons::PhotonTracer firstHits(*scene, lights, *intersector, options);
    std::vector<photons::Photon> hits;
    const auto perFrame = static_cast<std::uint64_t>(settings.photonsFromLight);
    statistics.raysTraced += firstHits.trace(0, std::min(perFrame, most), hits).rays;
    gather.aim(hits);
}

Surroundings makeSurroundings(std::shared_ptr<const scene::Scene> scene, const level::Tree& tree,
                              const Settings& settings) {
    Surroundings around;
    around.intersector = intersect::makeIntersector(settings.intersector, *scene, tree);
    if (gathers(settings)) around.texels = gather::CachedGather::makeTexels(*scene, gatherOptions(chosen(settings)));
    around.scene = std::move(scene);
    return around;
}

void Transport::State::setLight(std::size_t number, std::optional<lights::Light> light) {
    lightCount = std::max(lightCount, number + 1);
    if (light) makeUnit(*light);
    if (!gathering) {
        if (mapLights.empty())
            for (const lights::Light& old : lights.lights()) mapLights.emplace_back(old);
        if (number >= mapLights.size()) mapLights.resize(number + 1);
        mapLights[number] = std::move(light);
        mapLightsChanged = true;
        return;
    }
    if (!changing)
        changing = std::make_unique<ChangingLights>(scene, *intersector, receivers, changingOptions(settings, lights));
    if (number < levelLights && !lights.muted(static_cast<std::uint32_t>(number)))
        toMute.push_back(static_cast<std::uint32_t>(number));
    changing->set(number, std::move(light));
}

/// Takes a light out of those that stand still: its photons are traced once more, with negative sign.
void Transport::State::mute(std::uint32_t light) {
    if (lights.muted(light)) return;
    const lights::LightSet alone({lights.lights()[light]}, scene);
    if (settings.standardErrors) {
        // Which batch a photon counted to is not known any more.
        gathering->clear();
        partsTraced = 0;
    } else {
        lights::LightSet own = lights;
        own.muteAllBut(light);
        const photons::PhotonTracer again(*scene, own, *intersector, tracerOptions(settings, lights));
        const auto perFrame = static_cast<std::uint64_t>(settings.photonsFromLight);
        const std::uint64_t end = photonIndex(partsTraced);
        std::vector<photons::Photon> photons;
        for (std::uint64_t first = 0; first < end; first += takenBackAtOnce) {
            photons.clear();
            statistics.raysTraced += again.trace(first, std::min(takenBackAtOnce, end - first), perFrame, photons).rays;
            gathering->takeBack(photons);
            statistics.photonsInMap -= photons.size();
        }
    }
    lights.mute(light);
    gathering->mute(light, alone);
}

/// Makes what was set the present lights. Returns whether any light changed.
bool Transport::State::changeLights() {
    if (std::exchange(mapLightsChanged, false)) {
        std::vector<lights::Light> present;
        for (const auto& light : mapLights)
            if (light) present.push_back(*light);
        lights = lights::LightSet(std::move(present), scene);
        if (direct) direct->change(lights);
        framesTraced = 0; // every frame of the map is traced again, in place of what it was
        return true;
    }
    if (!changing) return false;
    for (const std::uint32_t light : std::exchange(toMute, {})) mute(light);
    return changing->commit(*gathering);
}

/// Index of the first photon of part number `part`: frames have photons_from_light of them, however they divide.
std::uint64_t Transport::State::photonIndex(std::uint64_t part) const {
    const auto perFrame = static_cast<std::uint64_t>(settings.photonsFromLight);
    return part / partsOfFrame * perFrame + part % partsOfFrame * perFrame / partsOfFrame;
}

FrameBudget::Plan Transport::State::plan() {
    FrameBudget::Work work;
    const auto left = [](std::uint64_t done, std::uint64_t all) {
        return static_cast<unsigned>(std::min<std::uint64_t>(all - std::min(done, all), 1U << 20U));
    };
    if (gathering) {
        work.still = convergence.done() ? 0 : left(partsTraced, partsToTrace);
        if (changing) work.changing = static_cast<unsigned>(changing->pending());
        work.refine = statistics.unfinished > 0 || askedInRound;
    } else if (framesTraced < static_cast<std::size_t>(settings.accumulationFrames)) {
        work.still = partsOfFrame;
    }
    work.receivers = inView.size();
    FrameBudget::Plan plan = budget.plan(work, partsOfFrame, static_cast<std::uint64_t>(settings.refineRays));
    if (!budget.bounded()) plan.changing = std::min(work.changing, ChangingLights::pieces);
    return plan;
}

/// A frame of a map is as large as its photons are many; a gather's frames are of one size and come in parts.
photons::TraceCounts Transport::State::traceStill(unsigned parts, std::vector<photons::Photon>& photons) const {
    const auto perFrame = static_cast<std::uint64_t>(settings.photonsFromLight);
    photons::TraceCounts counts;
    if (gathering) {
        const std::uint64_t first = photonIndex(partsTraced);
        counts = tracer.trace(first, photonIndex(partsTraced + parts) - first, perFrame, photons);
    } else {
        counts = tracer.trace(framesTraced * perFrame, photonIndex(std::min(parts, partsOfFrame)), photons);
    }
    maps::snowball(photons, *scene, static_cast<unsigned>(settings.snowballSize), settings.snowballRadius);
    return counts;
}

void Transport::State::count(const photons::TraceCounts& counts) {
    statistics.photonsEmitted += counts.emitted;
    statistics.raysTraced += counts.rays;
    statistics.photonsStored += counts.stored;
    statistics.photonsEscaped += counts.escaped;
}

void Transport::State::take(std::vector<photons::Photon>&& photons, unsigned parts) {
    if (gathering) {
        gathering->add(photons, parts, static_cast<unsigned>(partsTraced % partsOfFrame));
        statistics.photonsInMap += photons.size();
        partsTraced += parts;
        if (partsTraced < partsToTrace) spent = std::move(photons);
    } else {
        map.replaceOldest(std::move(photons));
        map.rebuild();
        statistics.photonsInMap = map.photons().size();
        statistics.mapBytes = map.bytes();
        ++framesTraced;
    }
}

/// What was asked for since the last frame is in view; frames without questions go on with what they had.
void Transport::State::collect() {
    if (!askedInRound) return;
    inView.clear();
    for (std::uint32_t r = 0; r < asked.size(); ++r)
        if (asked[r] == round) inView.push_back(r);
}

void Transport::State::ask(std::span<const std::uint32_t> which) {
    if (!askedInRound) ++round;
    askedInRound = true;
    for (const std::uint32_t r : which) asked[r] = round;
}

/// Spends the rays of a frame on what was asked for since the last one. Returns whether any light changed.
bool Transport::State::refine(std::uint64_t rays) {
    if (!gathering) return false;
    const auto start = Clock::now();
    // What texels reflect is made from their sums anew: a part of building, whoever asks for it.
    const auto update = [&] {
        gathering->update();
        const double ms = millisecondsSince(start);
        statistics.buildMs += ms;
        budget.report(FrameBudget::Kind::Renew, 1, ms);
        return false;
    };
    if (!askedInRound && statistics.unfinished == 0) return update();
    wanted.clear();
    for (const std::uint32_t r : inView)
        if (!gathering->finished(r)) wanted.push_back(r);
    statistics.unfinished = wanted.size();
    if (wanted.empty()) return update();
    const std::uint64_t traced = gathering->refine(wanted, rays);
    statistics.gatherRays += traced;
    const double ms = millisecondsSince(start);
    statistics.refineMs += ms;
    budget.report(FrameBudget::Kind::Refine, static_cast<double>(traced), ms);
    return true;
}

/// Looks at the errors of some of what was asked for last, once all of that is refined.
void Transport::State::judge(bool refined) {
    if (!convergence.wanted()) return;
    if (refined) convergence.look();
    if (refined || statistics.unfinished > 0 || inView.empty() || !convergence.due(partsTraced)) return;
    constexpr std::size_t most = 256;
    std::vector<std::uint32_t> sample;
    const std::size_t step = std::max<std::size_t>(1, inView.size() / most);
    for (std::size_t i = 0; i < inView.size(); i += step) sample.push_back(inView[i]);
    std::vector<gather::Estimate> estimates(sample.size());
    explain(sample, estimates);
    convergence.judge(estimates, partsTraced);
    statistics.errorPercent = convergence.errorPercent();
}

void Transport::State::estimate(std::span<const std::uint32_t> which, std::uint64_t revision) {
    auto start = Clock::now();
    answers.assign(which.size(), Rgb(0.0F));
    if (direct && !gathering) {
        directAnswers.resize(which.size());
        direct->estimate(which, directAnswers);
        statistics.directMs += millisecondsSince(start);
        budget.report(FrameBudget::Kind::Answer, 0, millisecondsSince(start));
        start = Clock::now();
        estimator->estimate(which, answers);
        for (std::size_t i = 0; i < which.size(); ++i) answers[i] += directAnswers[i];
    } else {
        estimator->estimate(which, answers);
    }
    if (direct) {
        statistics.directEstimates = direct->receiversComputed();
        statistics.directRays = direct->raysTraced();
    }
    const maps::Visits visits = estimator->visits();
    statistics.mapNodesVisited = visits.nodes + visits.leaves;
    statistics.mapPhotonsVisited = visits.photons;
    for (std::size_t i = 0; i < which.size(); ++i) {
        cache.irradiance[which[i]] = answers[i];
        cache.revision[which[i]] = revision;
    }
    statistics.estimatesMade += which.size();
    const double ms = millisecondsSince(start);
    statistics.estimateMs += ms;
    budget.report(FrameBudget::Kind::Answer, static_cast<double>(which.size()), ms);
}

/// Answers what is in view before the draw asks for it again, in one go on all cores; where not all of it fits, the
/// oldest answers first. Returns whether anything was answered.
bool Transport::State::answer(std::uint64_t most) {
    const std::uint64_t revision = lightRevision;
    if (!behind || !settings.useEstimateCache || revision == 0) return false;
    missing.clear();
    const auto first = std::lower_bound(inView.begin(), inView.end(), nextInView) - inView.begin();
    for (std::size_t i = 0; i < inView.size() && missing.size() < most; ++i) {
        const std::uint32_t r = inView[(static_cast<std::size_t>(first) + i) % inView.size()];
        if (cache.revision[r] != revision) missing.push_back(r);
    }
    behind = missing.size() == most;
    if (missing.empty()) return false;
    nextInView = missing.back() + 1;
    estimate(missing, revision);
    return true;
}

void Transport::State::explain(std::span<const std::uint32_t> which, std::span<gather::Estimate> out) {
    estimator->explain(which, out);
    std::vector<Rgb> directly(which.size());
    std::vector<float> variance(which.size());
    const auto addErrors = [&] {
        for (std::size_t i = 0; i < which.size(); ++i)
            out[i].standardError = std::hypot(out[i].standardError, std::sqrt(variance[i]));
    };
    if (direct) {
        direct->estimate(which, directly, variance);
        if (!gathering)
            for (std::size_t i = 0; i < which.size(); ++i) out[i].irradiance += directly[i];
        addErrors();
    }
    if (!changing || !changing->direct()) return;
    changing->direct()->estimate(which, directly, variance);
    addErrors();
}

} // namespace pie::engine
