// Frames that keep photons: the engine's photon map with its estimators, and nanoflann in their place.

#include "apps/piebench/frames.h"
#include "apps/piebench/nanoflann_photons.h"
#include "pie/core/clock.h"
#include "pie/core/parallel.h"
#include "pie/engine/options.h"
#include "pie/gather/direct.h"
#include "pie/gather/nearest_photons.h"
#include "pie/maps/realtime.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace piebench {
namespace {

using pie::Clock;
using pie::Rgb;
using pie::Vec3;
using pie::photons::Photon;

/// Trees of photons, and irradiance from them without light that shadow rays bring.
class PhotonStore {
public:
    virtual ~PhotonStore() = default;
    virtual void build(std::vector<Photon>&& photons) = 0; ///< of one frame, in place of the oldest
    virtual void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const = 0;
    [[nodiscard]] virtual std::size_t count() const = 0;
    [[nodiscard]] virtual std::size_t bytes() const = 0;
    [[nodiscard]] virtual std::size_t estimatorBytes() const { return 0; }
};

class EngineMap final : public PhotonStore {
public:
    EngineMap(const Subject& subject, const pie::gather::NearestOptions& options, std::size_t frames)
        : map_(frames), estimator_(*subject.of->scene, subject.receivers, map_, options) {}
    void build(std::vector<Photon>&& photons) override {
        map_.replaceOldest(std::move(photons));
        map_.rebuild();
    }
    void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const override {
        estimator_.estimate(which, irradiance);
    }
    [[nodiscard]] std::size_t count() const override { return map_.photons().size(); }
    [[nodiscard]] std::size_t bytes() const override { return map_.bytes(); }
    [[nodiscard]] std::size_t estimatorBytes() const override { return estimator_.bytes(); }

private:
    pie::maps::RealtimeMap map_;
    pie::gather::NearestPhotons estimator_;
};

/// nanoflann's own set of the k nearest, behind the paper's filters: the slice (eq 3.12) and the incoming direction.
class Filtered {
public:
    // NOLINTBEGIN(readability-identifier-naming): the names nanoflann asks for
    using DistanceType = float;
    using IndexType = std::uint32_t;
    using CountType = std::size_t;

    Filtered(const PhotonCloud& cloud, const pie::gather::NearestOptions& options, std::uint32_t* numbers,
             float* distances)
        : cloud_(cloud), options_(options), numbers_(numbers), distances_(distances), nearest_(options.maxCount) {}
    void look(const pie::scene::Receiver& at, float radius) {
        at_ = &at;
        nearest_.init(numbers_, distances_);
        // It has no search that is bounded by number and radius. What it takes for the k-th distance so far bounds it.
        distances_[options_.maxCount - 1] = std::nextafter(radius * radius, 2 * radius * radius);
    }
    [[nodiscard]] CountType size() const { return nearest_.size(); }
    [[nodiscard]] bool full() const { return nearest_.full(); }
    [[nodiscard]] DistanceType worstDist() const { return nearest_.worstDist(); }
    bool addPoint(DistanceType distance, IndexType number) {
        const Photon& photon = cloud_.photons[number];
        if (options_.indirectOnly && photon.bounce == 0) return true;
        const float height = glm::dot(photon.position - at_->position, at_->normal);
        if (sliced() && std::abs(height) > options_.slice.halfThickness) return true;
        if (options_.incomingDirection && !at_->twoSided && glm::dot(photon.direction, at_->normal) >= 0.0F)
            return true;
        return nearest_.addPoint(distance, number);
    }
    // NOLINTEND(readability-identifier-naming)

private:
    [[nodiscard]] bool sliced() const { return options_.volume != pie::gather::SearchVolume::Sphere; }

    const PhotonCloud& cloud_;
    const pie::gather::NearestOptions& options_;
    std::uint32_t* numbers_;
    float* distances_;
    nanoflann::KNNResultSet<float, std::uint32_t> nearest_;
    const pie::scene::Receiver* at_ = nullptr;
};

/// The paper's estimate, k nearest over pi r², on nanoflann's tree. The k-th photon, which made the radius, does not
/// count, as in ours.
class NanoflannMap final : public PhotonStore {
public:
    NanoflannMap(const Subject& subject, const pie::gather::NearestOptions& options, std::size_t frames)
        : subject_(subject), options_(options), frames_(frames) {
        const float diagonal = glm::length(subject.of->scene->bounds.size());
        options_.maxRadius = std::min(options.maxRadius, diagonal);
    }
    void build(std::vector<Photon>&& photons) override {
        frames_[arrivals_++ % frames_.size()] = std::move(photons);
        cloud_.photons.clear();
        for (const auto& frame : frames_) cloud_.photons.insert(cloud_.photons.end(), frame.begin(), frame.end());
        index_ = std::make_unique<NanoflannIndex>(3, cloud_, nanoflann::KDTreeSingleIndexAdaptorParams(10));
        index_->buildIndex();
    }
    void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const override {
        std::fill(irradiance.begin(), irradiance.end(), Rgb(0.0F));
        if (cloud_.photons.empty() || options_.maxCount == 0 || !(options_.maxRadius > 0.0F)) return;
        const float scale = 1.0F / static_cast<float>(std::min(arrivals_, frames_.size()));
        constexpr std::size_t taskSize = 64;
        pie::parallelChunks(which.size(), taskSize, [&](std::size_t begin, std::size_t end) {
            std::vector<std::uint32_t> numbers(options_.maxCount);
            std::vector<float> distances(options_.maxCount);
            Filtered set(cloud_, options_, numbers.data(), distances.data());
            for (std::size_t i = begin; i < end; ++i) {
                const pie::scene::Receiver& at = subject_.receivers.points[which[i]];
                set.look(at, options_.maxRadius);
                index_->findNeighbors(set, &at.position.x, nanoflann::SearchParams());
                const std::size_t count = set.full() ? set.size() - 1 : set.size();
                const float radius = std::max(set.full() ? std::sqrt(distances[set.size() - 1]) : options_.maxRadius,
                                              1e-3F * options_.maxRadius);
                Rgb sum(0.0F);
                for (std::size_t j = 0; j < count; ++j) sum += cloud_.photons[numbers[j]].flux;
                irradiance[i] = sum * (scale / (std::numbers::pi_v<float> * radius * radius));
            }
        });
    }
    [[nodiscard]] std::size_t count() const override { return cloud_.photons.size(); }
    [[nodiscard]] std::size_t bytes() const override {
        std::size_t kept = cloud_.photons.capacity();
        for (const auto& frame : frames_) kept += frame.capacity();
        return kept * sizeof(Photon) + (index_ ? index_->usedMemory(*index_) : 0);
    }

private:
    const Subject& subject_;
    pie::gather::NearestOptions options_;
    PhotonCloud cloud_;
    std::vector<std::vector<Photon>> frames_;
    std::size_t arrivals_ = 0;
    std::unique_ptr<NanoflannIndex> index_;
};

class MapFrames final : public Frames {
public:
    MapFrames(Estimator estimator, const Subject& subject, const pie::engine::Settings& settings,
              const pie::photons::TracerOptions& options, const Schedule& schedule)
        : subject_(subject), schedule_(schedule), colours_(subject), lights_(subject.of->lights, subject.of->scene),
          answers_(subject.which.size()), directLight_(subject.which.size()) {
        const auto start = Clock::now();
        intersector_ =
            pie::intersect::makeIntersector(settings.intersector, *subject.of->scene, subject.of->level->tree);
        pie::photons::TracerOptions own = options;
        own.photonsPerFrame = schedule.emitted;
        tracer_ = std::make_unique<pie::photons::PhotonTracer>(*subject.of->scene, lights_, *intersector_, own);
        pie::gather::NearestOptions search = pie::engine::nearestOptions(settings);
        search.indirectOnly = false; // whatever is among the photons counts
        if (estimator == Estimator::Nanoflann)
            photons_ = std::make_unique<NanoflannMap>(subject, search, schedule.frames);
        else
            photons_ = std::make_unique<EngineMap>(subject, search, schedule.frames);
        if (!options.storeDirectLight) {
            pie::gather::DirectOptions directOptions;
            directOptions.softSamples = static_cast<unsigned>(settings.directSamples);
            directOptions.absoluteTolerance = settings.directTolerance;
            directOptions.seed = settings.seed;
            direct_ = std::make_unique<pie::gather::DirectLight>(*subject.of->scene, lights_, *intersector_,
                                                                 subject.receivers, directOptions);
            direct_->estimate(subject.which, answers_);
        }
        prepareMs_ = pie::millisecondsSince(start);
    }

    Stages next() override {
        Stages stages;
        const auto start = Clock::now();
        const double processor = pie::processorMilliseconds();
        std::vector<Photon> traced;
        tracer_->trace(frame_++ * schedule_.emitted, schedule_.emitted, traced);
        stages.trace = pie::millisecondsSince(start);
        photonsNew_ = traced.size();
        const auto built = Clock::now();
        photons_->build(std::move(traced));
        stages.build = pie::millisecondsSince(built);
        const auto searched = Clock::now();
        photons_->estimate(subject_.which, answers_);
        if (direct_) {
            direct_->estimate(subject_.which, directLight_);
            for (std::size_t i = 0; i < answers_.size(); ++i) answers_[i] += directLight_[i];
        }
        stages.estimate = pie::millisecondsSince(searched);
        stages.upload = colours_.fill(answers_);
        stages.processor = pie::processorMilliseconds() - processor;
        stages.total = pie::millisecondsSince(start);
        return stages;
    }
    [[nodiscard]] std::span<const Rgb> answers() const override { return answers_; }
    [[nodiscard]] std::uint64_t photons() const override { return photons_->count(); }
    [[nodiscard]] std::uint64_t photonsNew() const override { return photonsNew_; }
    [[nodiscard]] Memory memory() const override {
        const auto receivers = static_cast<double>(subject_.receivers.points.size());
        const std::size_t held = photons_->estimatorBytes() + (direct_ ? direct_->bytes() : 0);
        return {static_cast<double>(sizeof(pie::scene::Receiver) + sizeof(Rgb)) + static_cast<double>(held) / receivers,
                static_cast<double>(photons_->bytes()) /
                    static_cast<double>(std::max<std::size_t>(1, photons_->count()))};
    }
    [[nodiscard]] double prepareMs() const override { return prepareMs_; }

private:
    const Subject& subject_;
    Schedule schedule_;
    Colours colours_;
    pie::lights::LightSet lights_;
    std::unique_ptr<pie::intersect::Intersector> intersector_;
    std::unique_ptr<pie::photons::PhotonTracer> tracer_;
    std::unique_ptr<PhotonStore> photons_;
    std::unique_ptr<pie::gather::DirectLight> direct_; ///< null: first hits are among the photons
    std::vector<Rgb> answers_, directLight_;
    std::uint64_t frame_ = 0, photonsNew_ = 0;
    double prepareMs_ = 0;
};

} // namespace

std::unique_ptr<Frames> makeMapFrames(Estimator estimator, const Subject& subject,
                                      const pie::engine::Settings& settings, const pie::photons::TracerOptions& options,
                                      const Schedule& schedule) {
    return std::make_unique<MapFrames>(estimator, subject, settings, options, schedule);
}

} // namespace piebench
