#include "pie/gather/cached_gather.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace pie::gather {
namespace {

constexpr std::size_t batch = 1024;       // receivers refined between two looks at the budget, at most …
constexpr std::size_t smallestBatch = 32; // … and at least
constexpr std::uint64_t expectedDirectRays = 64;
constexpr std::uint32_t enoughPhotons = 8; // for a first guess

/// Direct light of texels needs less care than that of receivers: hundreds of texels are averaged.
DirectOptions texelDirectOptions(std::uint64_t seed) {
    DirectOptions options;
    options.tolerance = 0.1F;
    options.absoluteTolerance = 2;
    options.tailSamples = 16;
    options.softSamples = 4;
    options.softness = 1;
    options.seed = seed ^ 0x7465786c73ULL;
    return options;
}

} // namespace

GatherOptions CachedGather::checked(GatherOptions options) {
    options.rays = std::bit_ceil(std::clamp(options.rays, 2U, 65'536U));
    options.texelRays = std::bit_ceil(std::clamp(options.texelRays, 2U, 65'536U));
    options.texels.maxTexels =
        std::min(options.texels.maxTexels, GatherRow::mostNumbers / (options.texels.points + 1) - 1);
    return options;
}

CachedGather::CachedGather(const scene::Scene& scene, const lights::LightSet& lights,
                           const intersect::Intersector& intersector, const scene::Receivers& receivers,
                           DirectLight* direct, const GatherOptions& options,
                           std::shared_ptr<const SurfaceTexels> texels)
    : receivers_(receivers), scene_(scene), lights_(lights), intersector_(intersector), direct_(direct),
      options_(checked(options)), keptTexels_(texels ? std::move(texels) : makeTexels(scene, options)),
      texels_(*keptTexels_), bright_(texels_),
      texelDirect_(direct ? std::make_unique<DirectLight>(scene, lights, intersector, texels_.points(),
                                                          texelDirectOptions(options.seed))
                          : nullptr),
      light_(texels_, lights.largestPower(), options.texelsByPhotons ? nullptr : texelDirect_.get(),
             options.standardErrors),
      gatherRays_(scene, intersector, texels_, bright_, receivers, rayOffsetFor(scene), options.seed),
      texelGatherRays_(scene, intersector, texels_, bright_, texels_.points(), rayOffsetFor(scene), options.seed),
      rows_(receivers.points.size()), stage_(receivers.points.size(), Unknown),
      own_(receivers.points.size(), SurfaceTexels::none) {
    if (!direct || options.texelsByPhotons)
        firstHits_ = std::make_unique<PhotonSums>(texels_, lights.largestPower(), false);
    update();
}

CachedGather::~CachedGather() = default;

std::shared_ptr<const SurfaceTexels> CachedGather::makeTexels(const scene::Scene& scene, const GatherOptions& options) {
    return std::make_shared<const SurfaceTexels>(scene, checked(options).texels);
}

void CachedGather::aim(std::span<const photons::Photon> firstHits) { bright_.choose(firstHits); }

Fallen CachedGather::fallen(std::span<const photons::Photon> photons, unsigned parts, unsigned firstPart) {
    texels_.find(photons, found_);
    changed_ = true;
    return {photons, found_, parts, firstPart};
}

/// First hits are direct light: with shadow rays, texels have it from those, and hardly anybody stores them.
void CachedGather::add(std::span<const photons::Photon> photons, unsigned parts, unsigned firstPart) {
    const Fallen all = fallen(photons, parts, firstPart);
    light_.still().add(all, stillHits());
    if (firstHits_) firstHits_->add(all, Hits::First);
    survey();
}

void CachedGather::clear() {
    light_.still().clear(lights_.largestPower());
    if (firstHits_) firstHits_->clear(lights_.largestPower());
    changed_ = true;
}

void CachedGather::takeBack(std::span<const photons::Photon> photons) {
    const Fallen all = fallen(photons, PhotonSums::batches, 0);
    light_.still().takeBack(all, stillHits());
    if (firstHits_) firstHits_->takeBack(all, Hits::First);
}

void CachedGather::mute(std::uint32_t light, const lights::LightSet& alone) {
    if (!direct_) return;
    const DirectLight ofReceivers(scene_, alone, intersector_, receivers_, direct_->options());
    direct_->mute(light, ofReceivers);
    const DirectLight ofTexels(scene_, alone, intersector_, texels_.points(), texelDirect_->options());
    texelDirect_->mute(light, ofTexels);
    light_.renewDirect();
    texelDirect_->estimate(gatheringPoints_, pointDirect_);
    changed_ = true;
}

void CachedGather::setChanging(const DirectLight* direct, double power) {
    changingDirect_ = direct;
    TexelLight::Changing& sums = light_.changing(power);
    sums.first.clear(power);
    sums.later.clear(power);
    changed_ = true;
}

void CachedGather::addChanging(std::span<const photons::Photon> photons, unsigned parts, unsigned firstPart) {
    const Fallen all = fallen(photons, parts, firstPart);
    TexelLight::Changing& sums = light_.changing(1);
    sums.first.add(all, Hits::First);
    sums.later.add(all, Hits::Later);
}

void CachedGather::removeChanging(std::span<const photons::Photon> photons, unsigned parts, unsigned firstPart) {
    const Fallen all = fallen(photons, parts, firstPart);
    TexelLight::Changing& sums = light_.changing(1);
    sums.first.remove(all, Hits::First);
    sums.later.remove(all, Hits::Later);
}

void CachedGather::update() {
    if (!changed_) return;
    changed_ = false;
    light_.update();
    if (firstHits_) firstHits_->update();
    bothWays(light_.radiosity(), true, radiosity_);
}

void CachedGather::bothWays(std::span<const TexelLight::Radiosity> byPhotons, bool direct, Radiosities& both) const {
    both.resize(firstPoint() + pointRows_.size());
    std::copy(byPhotons.begin(), byPhotons.end(), both.begin());
    both[dark()] = {};
    const std::span<const TexelLight::Radiosity> texels = std::span(both).first(firstPoint());
    const float each = 1.0F / static_cast<float>(raysOfPoint());
    parallelChunks(pointRows_.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            const std::uint32_t t = texelOfPoint(p);
            Rgb light = pointRows_[p].gathered(texels, each);
            if (direct) {
                light += direct_ ? pointDirect_[p] : firstHits_->broadIrradiance(t, 1);
                light += light_.broadFirst(t, 1);
            }
            light *= texels_.texels()[t].reflectance;
            both[firstPoint() + p] = {light.x, light.y, light.z, 0.0F};
        }
    });
}

unsigned CachedGather::raysAt(unsigned stage) const {
    return std::max(2U, options_.rays >> (2 * (Fine - std::min<unsigned>(stage, Fine))));
}

unsigned CachedGather::raysOfPoint() const {
    return std::max(2U, std::bit_floor(options_.texelRays / texels_.pointsPerTexel()));
}

unsigned CachedGather::lastStage() const { return options_.reflections > 0 ? Fine : Direct; }

bool CachedGather::finished(std::uint32_t receiver) const { return stage_[receiver] >= lastStage(); }

unsigned CachedGather::samples(std::uint32_t receiver) const {
    const unsigned stage = stage_[receiver];
    return stage > Direct ? raysAt(stage) : stage == Direct ? 1 : 0;
}

std::uint64_t CachedGather::refine(std::span<const std::uint32_t> wanted, std::uint64_t rays) {
    const std::uint64_t before = rays_;
    const std::uint64_t directBefore = direct_ ? direct_->raysTraced() : 0;
    const std::uint64_t texelBefore = texelDirect_ ? texelDirect_->raysTraced() : 0;
    const auto spent = [&] {
        return rays_ - before + (direct_ ? direct_->raysTraced() - directBefore : 0) +
               (texelDirect_ ? texelDirect_->raysTraced() - texelBefore : 0);
    };
    if (direct_) direct_->refine(wanted);
    bool changed = ownTexels(wanted, [&] { return spent() < rays; });
    std::vector<std::uint32_t> now;
    for (unsigned stage = OwnTexel; stage < lastStage() && spent() < rays; ++stage) {
        std::size_t next = 0;
        while (next < wanted.size() && spent() < rays) {
            now.clear();
            // As many as the rays that are left are about enough for.
            const std::uint64_t each = stage > OwnTexel ? raysAt(stage + 1) : expectedDirectRays;
            const std::uint64_t most =
                std::clamp<std::uint64_t>((rays - std::min(rays, spent())) / each, smallestBatch, batch);
            for (; next < wanted.size() && now.size() < most; ++next)
                if (stage_[wanted[next]] == stage) now.push_back(wanted[next]);
            if (now.empty()) break;
            changed = true;
            if (stage > OwnTexel) {
                makeRows(now, raysAt(stage + 1));
            } else if (direct_) {
                std::vector<Rgb> ignored(now.size());
                direct_->estimate(now, ignored);
            }
            for (const std::uint32_t r : now) stage_[r] = static_cast<std::uint8_t>(stage + 1);
        }
    }
    changed_ = changed_ || changed;
    update();
    // Where nothing had to be traced there was still progress.
    return changed ? std::max<std::uint64_t>(spent(), 1) : 0;
}

/// Before anything was asked for: direct light of some texels all over the scene, from which the others take theirs.
void CachedGather::survey() {
    if (surveyed_) return;
    surveyed_ = true;
    constexpr std::uint32_t most = 1024;
    std::vector<std::uint32_t> texels;
    const std::uint32_t step = std::max(1U, texelCount() / most);
    for (std::uint32_t t = 0; t < texelCount(); t += step) texels.push_back(t);
    light_.direct(texels);
}

/// The first guess. Texels in an order without pattern, so that a part of them already is a picture of the whole: the
/// rest take the light of those around them. Returns whether anything was done.
bool CachedGather::ownTexels(std::span<const std::uint32_t> wanted, const std::function<bool()>& go) {
    std::vector<std::uint32_t> which;
    for (const std::uint32_t r : wanted)
        if (stage_[r] == Unknown) which.push_back(r);
    if (which.empty()) return false;
    parallelChunks(which.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const scene::Receiver& receiver = receivers_.points[which[i]];
            if (own_[which[i]] == SurfaceTexels::none) own_[which[i]] = texels_.near(receiver.inset, receiver.normal);
        }
    });
    std::vector<std::uint32_t> texels;
    for (const std::uint32_t r : which)
        if (own_[r] != SurfaceTexels::none && !light_.hasDirect(own_[r])) texels.push_back(own_[r]);
    const auto scattered = [](std::uint32_t t) { return t * 0x9e3779b1U; }; // one to one
    std::sort(texels.begin(), texels.end(),
              [&](std::uint32_t a, std::uint32_t b) { return scattered(a) < scattered(b); });
    texels.erase(std::unique(texels.begin(), texels.end()), texels.end());
    constexpr std::size_t some = 128;
    for (std::size_t first = 0; first < texels.size() && go(); first += some)
        light_.direct(std::span(texels).subspan(first, std::min(some, texels.size() - first)));
    for (const std::uint32_t r : which)
        if (own_[r] == SurfaceTexels::none || light_.hasDirect(own_[r])) stage_[r] = OwnTexel;
    return true;
}

void CachedGather::estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const {
    parallelChunks(which.size(), receiversPerChunk, [&](std::size_t begin, std::size_t end) {
        putDirect(which.subspan(begin, end - begin), irradiance.subspan(begin, end - begin));
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t r = which[i];
            const unsigned stage = stage_[r];
            if (stage > Direct) {
                if (!direct_) irradiance[i] += firstHits_->broadIrradiance(own_[r], enoughFirstHits);
                irradiance[i] += rows_[r].gathered(radiosity_, 1.0F / static_cast<float>(raysAt(stage)));
                continue;
            }
            const std::uint32_t texel =
                stage == Unknown ? texels_.near(receivers_.points[r].inset, receivers_.points[r].normal) : own_[r];
            if (texel == SurfaceTexels::none) continue;
            if (!firstHits_) {
                irradiance[i] += light_.broadIrradiance(texel, enoughPhotons);
                if (stage < Direct) irradiance[i] += light_.broadDirect(texel);
                continue;
            }
            const Rgb all = light_.broadIrradiance(texel, enoughFirstHits);
            const bool twice = stage == Direct && direct_ != nullptr; // direct light is known, and among the photons
            irradiance[i] += twice ? glm::max(all - firstHits_->broadIrradiance(texel, enoughFirstHits), 0.0F) : all;
        }
        addChangingDirect(which.subspan(begin, end - begin), irradiance.subspan(begin, end - begin));
    });
}

void CachedGather::addChangingDirect(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const {
    if (light_.changing() == nullptr) return;
    if (changingDirect_ != nullptr) {
        std::array<Rgb, receiversPerChunk> direct{};
        changingDirect_->estimate(which, std::span(direct).first(which.size()));
        for (std::size_t i = 0; i < which.size(); ++i) irradiance[i] += direct[i];
        return;
    }
    for (std::size_t i = 0; i < which.size(); ++i) {
        const scene::Receiver& receiver = receivers_.points[which[i]];
        const std::uint32_t texel =
            stage_[which[i]] == Unknown ? texels_.near(receiver.inset, receiver.normal) : own_[which[i]];
        irradiance[i] += light_.broadFirst(texel, enoughFirstHits);
    }
}

/// Of those that have shadow rays; 0 for the others.
void CachedGather::putDirect(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const {
    std::array<std::uint32_t, receiversPerChunk> known{};
    std::array<Rgb, receiversPerChunk> light{};
    std::size_t count = 0;
    for (const std::uint32_t r : which)
        if (direct_ && stage_[r] >= Direct) known[count++] = r;
    if (count > 0) direct_->estimate(std::span(known).first(count), std::span(light).first(count));
    count = 0;
    for (std::size_t i = 0; i < which.size(); ++i)
        irradiance[i] = direct_ && stage_[which[i]] >= Direct ? light[count++] : Rgb(0.0F);
}

std::size_t CachedGather::bytes() const {
    std::size_t sum = texels_.bytes() + bright_.bytes() + light_.bytes() + stage_.size() +
                      (own_.size() + placeOf_.size() + gatheringPoints_.size()) * sizeof(std::uint32_t) +
                      (rows_.size() + pointRows_.size()) * sizeof(GatherRow) + pointDirect_.size() * sizeof(Rgb) +
                      radiosity_.size() * sizeof(TexelLight::Radiosity);
    for (const auto* rows : {&rows_, &pointRows_})
        for (const GatherRow& row : *rows) sum += row.bytes();
    for (const auto& pairs : pointPairs_) sum += pairs.size() * sizeof(Pair);
    if (firstHits_) sum += firstHits_->bytes();
    if (texelDirect_) sum += texelDirect_->bytes();
    return sum;
}

} // namespace pie::gather
