#include "pie/engine/changing_lights.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pie::engine {
namespace {

/// By how much lights may outgrow the unit of their sums, or fall short of it.
constexpr double mostGrowth = 1024;

photons::TracerOptions withFirstHits(photons::TracerOptions options) {
    options.storeDirectLight = true;
    return options;
}

} // namespace

ChangingLights::ChangingLights(std::shared_ptr<const scene::Scene> scene, const intersect::Intersector& intersector,
                               const scene::Receivers& receivers, const ChangingOptions& options)
    : scene_(std::move(scene)), options_(options),
      photonsOfPiece_(options.photonsPerFrame == 0 ? 0 : std::max<std::uint64_t>(1, options.photonsPerFrame / pieces)),
      lights_({}, scene_), tracer_(*scene_, lights_, intersector, withFirstHits(options.tracer)),
      ring_(pieces * std::max<std::size_t>(1, options.renewalFrames)) {
    if (options.shadowRays)
        direct_ = std::make_unique<gather::DirectLight>(*scene_, lights_, intersector, receivers, options.direct);
}

void ChangingLights::set(std::size_t number, std::optional<lights::Light> light) {
    if (number >= wanted_.size()) wanted_.resize(number + 1);
    wanted_[number] = std::move(light);
    changed_ = true;
}

bool ChangingLights::commit(gather::CachedGather& gather) {
    if (!std::exchange(changed_, false)) return false;
    std::vector<lights::Light> present;
    for (const auto& light : wanted_)
        if (light) present.push_back(*light);
    // In place: the tracer and the direct light look at it.
    lights_ = lights::LightSet(std::move(present), scene_);
    if (direct_) direct_->change(lights_);
    ++revision_;
    stale_ = ring_.size();
    double power = lights_.largestPower();
    if (!std::isfinite(power)) power = 0;
    const bool larger = power > mostGrowth * power_;
    const bool smaller = power > 0 && power * mostGrowth < power_;
    if (revision_ > 1 && surplus_ == 0 && !larger && !smaller) return true;
    // Sums start again with the ring as it is; but what is far too bright for their unit has no place in them.
    if (smaller)
        for (Piece& piece : ring_) piece.revision = 0;
    power_ = smaller ? power : std::max(power, power_);
    surplus_ = 0;
    gather.setChanging(direct_.get(), power_);
    for (std::size_t i = 0; i < ring_.size(); ++i)
        if (ring_[i].revision != 0) gather.addChanging(ring_[i].photons, partsOfPiece, firstPart(i));
    return true;
}

std::size_t ChangingLights::pending() const {
    if (revision_ == 0) return 0;
    if (stale_ > 0) return stale_;
    if (lights_.empty() || photonsOfPiece_ == 0) return 0;
    const std::size_t all = pieces * options_.stillFrames;
    return all - std::min(all, ring_.size() + surplus_);
}

photons::TraceCounts ChangingLights::trace(std::size_t count) {
    count = std::min(count, pending());
    if (fresh_.size() < count) fresh_.resize(count);
    photons::TraceCounts counts;
    for (freshCount_ = 0; freshCount_ < count; ++freshCount_) {
        const std::size_t piece =
            stale_ > 0 ? (next_ + freshCount_) % ring_.size() : ring_.size() + surplus_ + freshCount_;
        fresh_[freshCount_].clear();
        if (lights_.empty() || photonsOfPiece_ == 0) continue;
        counts +=
            tracer_.trace(piece * photonsOfPiece_, photonsOfPiece_, pieces * photonsOfPiece_, fresh_[freshCount_]);
    }
    return counts;
}

std::int64_t ChangingLights::apply(gather::CachedGather& gather) {
    std::int64_t change = 0;
    for (std::size_t i = 0; i < freshCount_; ++i) {
        change += static_cast<std::int64_t>(fresh_[i].size());
        if (stale_ == 0) {
            gather.addChanging(fresh_[i], partsOfPiece, firstPart(ring_.size() + surplus_));
            ++surplus_;
            continue;
        }
        Piece& piece = ring_[next_];
        const unsigned first = firstPart(next_);
        if (piece.revision != 0) {
            gather.removeChanging(piece.photons, partsOfPiece, first);
            change -= static_cast<std::int64_t>(piece.photons.size());
        }
        gather.addChanging(fresh_[i], partsOfPiece, first);
        piece.revision = revision_;
        piece.photons.swap(fresh_[i]); // what was there serves the next one
        next_ = (next_ + 1) % ring_.size();
        --stale_;
    }
    freshCount_ = 0;
    return change;
}

std::size_t ChangingLights::bytes() const {
    std::size_t sum = direct_ ? direct_->bytes() : 0;
    for (const Piece& piece : ring_) sum += piece.photons.capacity() * sizeof(photons::Photon);
    for (const auto& photons : fresh_) sum += photons.capacity() * sizeof(photons::Photon);
    return sum;
}

} // namespace pie::engine
