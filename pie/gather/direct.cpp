#include "pie/gather/direct.h"

#include "pie/core/parallel.h"
#include "pie/gather/direct_job.h"
#include "pie/gather/numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pie::gather {
namespace {

using intersect::Hit;
using intersect::Ray;

/// Points nearer to a lamp's plane, in ray offsets, are on it.
constexpr float onPlaneOffsets = 0.02F;
constexpr std::size_t batchSize = 64; // receivers whose rays are traced together

/// What gets through to the sky: the product over filters in front of the first sky surface; 0 where the first other
/// surface is not sky, or there is none.
class SkyTracer {
public:
    explicit SkyTracer(const DirectLight::Context& context) : context_(context) {}

    void trace(RayBatch& batch) {
        for (std::size_t i = 0; i < batch.rays.size(); ++i)
            if (batch.needsSky[i] != 0) {
                batch.through[i] = Rgb(1.0F);
                under_.push_back({static_cast<std::uint32_t>(i), batch.rays[i], intersect::noTriangle});
            }
        for (int crossing = 0; crossing < mostCrossings && !under_.empty(); ++crossing) advance(batch);
        for (const Under& left : under_) batch.through[left.number] = Rgb(0.0F);
        under_.clear();
    }

private:
    struct Under {
        std::uint32_t number;
        Ray ray;
        std::uint32_t last = intersect::noTriangle; ///< crossed last
    };

    void advance(RayBatch& batch) {
        rays_.clear();
        for (const Under& ray : under_) rays_.push_back(ray.ray);
        hits_.assign(rays_.size(), Hit{});
        context_.intersector.closest(rays_, hits_);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < under_.size(); ++i) {
            Under ray = under_[i];
            const Hit& hit = hits_[i];
            Rgb& through = batch.through[ray.number];
            if (!hit.found()) {
                through = Rgb(0.0F);
                continue;
            }
            const scene::Interaction met = context_.scene.material(hit.triangle).interaction;
            if (met == scene::Interaction::Sky) continue;
            // Rounding may bring a triangle back that was just crossed: it filters once and is stepped over widely.
            const bool again = hit.triangle == ray.last;
            if (met != scene::Interaction::Filter)
                through = Rgb(0.0F);
            else if (!again)
                through *= context_.scene.transmittance(hit.triangle, hit.u, hit.v);
            if (maxChannel(through) <= 0.0F) continue;
            ray.last = hit.triangle;
            ray.ray.tMin = std::nextafter(hit.t + (again ? 1e-4F : 1e-6F) * hit.t, std::numeric_limits<float>::max());
            under_[kept++] = ray;
        }
        under_.resize(kept);
    }

    const DirectLight::Context& context_;
    std::vector<Under> under_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
};

/// Answers all rays of a batch.
class BatchTracer {
public:
    explicit BatchTracer(const DirectLight::Context& context) : context_(context), sky_(context) {}

    void trace(RayBatch& batch) {
        batch.through.assign(batch.rays.size(), Rgb(0.0F));
        rays_.clear();
        numbers_.clear();
        for (std::size_t i = 0; i < batch.rays.size(); ++i) {
            if (batch.needsSky[i] != 0) continue;
            rays_.push_back(batch.rays[i]);
            numbers_.push_back(static_cast<std::uint32_t>(i));
        }
        through_.assign(rays_.size(), Rgb(0.0F));
        if (!rays_.empty()) intersect::transmittance(context_.intersector, context_.scene, rays_, through_);
        for (std::size_t i = 0; i < rays_.size(); ++i) batch.through[numbers_[i]] = through_[i];
        if (rays_.size() < batch.rays.size()) sky_.trace(batch);
    }

private:
    const DirectLight::Context& context_;
    SkyTracer sky_;
    std::vector<Ray> rays_;
    std::vector<std::uint32_t> numbers_;
    std::vector<Rgb> through_;
};

} // namespace

float rayOffsetFor(const scene::Scene& scene) {
    if (scene.bounds.empty()) return 1.0F;
    const float diagonal = glm::length(scene.bounds.size());
    const Vec3 farthest = glm::max(glm::abs(scene.bounds.lower), glm::abs(scene.bounds.upper));
    // A unit in a level of usual size; at 10⁷ units the next float is a unit away.
    return std::max(std::min(1.0F, diagonal / 4096.0F), 1e-6F * maxChannel(farthest));
}

DirectLight::DirectLight(const scene::Scene& scene, const lights::LightSet& lights,
                         const intersect::Intersector& intersector, const scene::Receivers& receivers,
                         const DirectOptions& options)
    : receivers_(receivers),
      context_(std::make_unique<Context>(Context{
          scene, intersector, options, Sources(lights.lights(), options.softness, onPlaneOffsets * rayOffsetFor(scene)),
          rayOffsetFor(scene)})),
      state_(std::make_unique<std::atomic<std::uint8_t>[]>(receivers.points.size())),
      irradiance_(std::make_unique<Rgb[]>(receivers.points.size())),
      variance_(std::make_unique<float[]>(receivers.points.size())) {}

DirectLight::~DirectLight() = default;

float DirectLight::rayOffset() const { return context_->offset; }
const DirectOptions& DirectLight::options() const { return context_->options; }

std::size_t DirectLight::bytes() const {
    return receivers_.points.size() * (sizeof(Rgb) + sizeof(float) + 1) + context_->sources.bytes();
}

void DirectLight::change(const lights::LightSet& lights) {
    context_->sources = Sources(lights.lights(), context_->options.softness, onPlaneOffsets * context_->offset);
    for (std::size_t r = 0; r < receivers_.points.size(); ++r) state_[r].store(Unknown, std::memory_order_relaxed);
}

void DirectLight::mute(std::uint32_t light, const DirectLight& alone) {
    context_->sources.mute(light);
    std::vector<std::uint32_t> which;
    for (std::uint32_t r = 0; r < receivers_.points.size(); ++r)
        if (known(r)) which.push_back(r);
    std::vector<Rgb> part(which.size());
    alone.estimate(which, part);
    for (std::size_t i = 0; i < which.size(); ++i) {
        if (part[i] == Rgb(0.0F)) continue;
        irradiance_[which[i]] = glm::max(irradiance_[which[i]] - part[i], 0.0F);
        state_[which[i]].store(Rough, std::memory_order_relaxed);
    }
}

void DirectLight::refine(std::span<const std::uint32_t> which) {
    std::vector<std::uint32_t> again;
    for (const std::uint32_t r : which) {
        if (!rough(r)) continue;
        state_[r].store(Unknown, std::memory_order_relaxed);
        again.push_back(r);
    }
    std::vector<Rgb> ignored(again.size());
    estimate(again, ignored);
}

void DirectLight::estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const {
    estimate(which, irradiance, {});
}

void DirectLight::estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance,
                           std::span<float> variance) const {
    if (context_->sources.size() == 0) {
        std::fill(irradiance.begin(), irradiance.end(), Rgb(0.0F));
        std::fill(variance.begin(), variance.end(), 0.0F);
        return;
    }
    // Known ones first, so that the chunks below share the work that is left evenly.
    std::vector<std::uint32_t> missing;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < which.size(); ++i) {
        if (state_[which[i]].load(std::memory_order_acquire) >= Ready) {
            irradiance[i] = irradiance_[which[i]];
            if (!variance.empty()) variance[i] = variance_[which[i]];
        } else {
            missing.push_back(which[i]);
            places.push_back(i);
        }
    }
    if (missing.empty()) return;
    std::vector<Rgb> results(missing.size());
    std::vector<float> variances(missing.size());
    parallelChunks(missing.size(), batchSize, [&](std::size_t begin, std::size_t end) {
        compute(std::span(missing).subspan(begin, end - begin), std::span(results).subspan(begin, end - begin),
                std::span(variances).subspan(begin, end - begin));
    });
    for (std::size_t i = 0; i < missing.size(); ++i) {
        irradiance[places[i]] = results[i];
        if (!variance.empty()) variance[places[i]] = variances[i];
    }
}

void DirectLight::compute(std::span<const std::uint32_t> which, std::span<Rgb> irradiance,
                          std::span<float> variance) const {
    std::vector<DirectJob> jobs;
    jobs.reserve(which.size());
    for (const std::uint32_t receiver : which) jobs.emplace_back(*context_, receivers_.points[receiver]);

    BatchTracer tracer(*context_);
    RayBatch batch;
    std::vector<DirectJob*> running;
    running.reserve(jobs.size());
    for (DirectJob& job : jobs) running.push_back(&job);
    std::uint64_t rays = 0;
    while (!running.empty()) {
        batch.rays.clear();
        batch.needsSky.clear();
        std::erase_if(running, [&](DirectJob* job) { return !job->request(batch); });
        tracer.trace(batch);
        rays += batch.rays.size();
        for (DirectJob* job : running) job->absorb(batch);
    }
    rays_ += rays;
    computed_ += which.size();

    for (std::size_t i = 0; i < which.size(); ++i) {
        irradiance[i] = jobs[i].irradiance();
        variance[i] = static_cast<float>(std::min(jobs[i].variance(), double{std::numeric_limits<float>::max()}));
        std::uint8_t empty = Unknown;
        if (state_[which[i]].compare_exchange_strong(empty, BeingWritten, std::memory_order_relaxed)) {
            irradiance_[which[i]] = irradiance[i];
            variance_[which[i]] = variance[i];
            state_[which[i]].store(Ready, std::memory_order_release);
        }
    }
}

} // namespace pie::gather
