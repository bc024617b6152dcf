#include "pie/reference/path_tracer.h"

#include "pie/core/parallel.h"
#include "pie/reference/batch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

namespace pie::reference {
namespace {

/// Batches before an error is believed, and receivers that are in work at once: their state is kept.
constexpr std::uint64_t firstBatches = 16;
constexpr std::size_t receiversAtOnce = 256;

std::uint64_t addressOf(const scene::Receiver& receiver, std::uint64_t seed) {
    std::uint64_t address = seed;
    for (const Vec3& v : {receiver.inset, receiver.normal})
        for (int i = 0; i < 3; ++i) address = mix(address, std::bit_cast<std::uint32_t>(v[i] + 0.0F)); // −0 is 0
    return address;
}

float liftOf(const scene::Scene& scene) {
    if (scene.bounds.empty()) return 0.0F;
    const float diagonal = glm::length(scene.bounds.size());
    const float farthest = lights::largestCoordinate(scene.bounds, Vec3(0.0F));
    return std::max(std::min(0.125F, diagonal / 32768.0F), 1e-6F * farthest);
}

double channelMean(const glm::dvec3& c) { return (c.x + c.y + c.z) / 3.0; }

/// A receiver in work: one side of it or both, and the means of its batches.
struct Work {
    std::vector<Start> starts;
    std::vector<glm::dvec3> batches;
    std::uint64_t wanted = firstBatches;
    glm::dvec3 sharp{0.0};
    bool exact = false;
};

Value valueOf(const Work& work) {
    Value value;
    value.irradiance = work.sharp;
    const auto count = static_cast<double>(work.batches.size());
    if (work.batches.size() < 2) return value;
    glm::dvec3 mean(0.0);
    for (const glm::dvec3& batch : work.batches) mean += batch;
    mean /= count;
    glm::dvec3 squares(0.0);
    double squareOfMeans = 0;
    for (const glm::dvec3& batch : work.batches) {
        const glm::dvec3 off = batch - mean;
        squares += off * off;
        squareOfMeans += channelMean(off) * channelMean(off);
    }
    value.irradiance += mean;
    value.standardError = glm::sqrt(squares / (count * (count - 1.0)));
    value.meanError = std::sqrt(squareOfMeans / (count * (count - 1.0)));
    value.paths = static_cast<std::uint64_t>(work.batches.size()) * pathsPerBatch * work.starts.size();
    return value;
}

} // namespace

struct PathTracer::State : Shared {
    explicit State(Shared shared) : Shared(std::move(shared)) {}
    void start(const scene::Receiver& receiver, Work& work) const;
    void refine(std::vector<Work>& works) const;
};

PathTracer::PathTracer(std::shared_ptr<const scene::Scene> scene, std::span<const lights::Light> lights,
                       const intersect::Intersector& intersector, const Options& options) {
    auto sources = std::make_unique<const Sources>(lights, *scene);
    auto map = std::make_unique<const ChoiceMap>(*scene, *sources, intersector, options.seed);
    const float lift = liftOf(*scene);
    state_ = std::make_unique<const State>(Shared{std::move(scene), intersector, options, std::move(sources),
                                                  std::move(map), sampling::Halton(options.seed), lift});
}

PathTracer::~PathTracer() = default;

void PathTracer::State::start(const scene::Receiver& receiver, Work& work) const {
    const Vec3& at = receiver.inset;
    const bool somewhere = std::abs(at.x) < 1e15F && std::abs(at.y) < 1e15F && std::abs(at.z) < 1e15F;
    if (!somewhere || !(std::abs(glm::dot(receiver.normal, receiver.normal) - 1.0F) < 1e-3F)) {
        work.wanted = 0; // a receiver nowhere, or without a side, is dark
        work.exact = true;
        return;
    }
    const std::uint64_t address = addressOf(receiver, options.seed);
    work.starts.push_back(makeStart(*this, receiver.inset, receiver.normal, address));
    if (receiver.twoSided) work.starts.push_back(makeStart(*this, receiver.inset, -receiver.normal, mix(address, 1)));
    for (const Start& side : work.starts) work.sharp += side.sharp;
    const bool soft = std::any_of(work.starts.begin(), work.starts.end(), [](const Start& s) { return s.anySoft; });
    work.exact = sources->size() == 0 || (options.recursionDepth == 0 && !soft);
    if (work.exact) work.wanted = 0;
}

/// Adds batches to all that want some, until nobody does.
void PathTracer::State::refine(std::vector<Work>& works) const {
    const std::uint64_t most = std::max<std::uint64_t>(2, options.mostPaths / pathsPerBatch);
    for (Work& work : works) work.wanted = std::min(most, work.wanted);
    std::vector<std::pair<Work*, std::size_t>> jobs;
    for (;;) {
        jobs.clear();
        for (Work& work : works)
            for (std::size_t b = work.batches.size(); b < work.wanted; ++b) jobs.emplace_back(&work, b);
        if (jobs.empty()) return;
        for (Work& work : works) work.batches.resize(std::max<std::size_t>(work.batches.size(), work.wanted));
        parallelChunks(jobs.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t j = begin; j < end; ++j) {
                glm::dvec3 sum(0.0);
                for (const Start& side : jobs[j].first->starts) sum += traceBatch(*this, side, jobs[j].second);
                jobs[j].first->batches[jobs[j].second] = sum;
            }
        });
        for (Work& work : works) {
            if (work.exact) continue;
            const Value value = valueOf(work);
            const double allowed = options.target * std::abs(channelMean(value.irradiance));
            if (value.meanError <= allowed) continue;
            const auto done = static_cast<double>(work.batches.size());
            const double ratio = allowed > 0 ? value.meanError / allowed : 2.0;
            const double needed = done * std::min(2.0, 1.05 * ratio * ratio);
            work.wanted = std::min(most, static_cast<std::uint64_t>(std::ceil(needed)));
        }
    }
}

void PathTracer::trace(std::span<const scene::Receiver> receivers, std::span<Value> values,
                       const std::function<void(std::size_t)>& progress) const {
    for (std::size_t first = 0; first < receivers.size(); first += receiversAtOnce) {
        const std::size_t count = std::min(receiversAtOnce, receivers.size() - first);
        std::vector<Work> works(count);
        parallelChunks(count, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) state_->start(receivers[first + i], works[i]);
        });
        state_->refine(works);
        for (std::size_t i = 0; i < count; ++i) {
            Value value = valueOf(works[i]);
            value.reached = value.meanError <= state_->options.target * std::abs(channelMean(value.irradiance));
            values[first + i] = value;
        }
        if (progress) progress(first + count);
    }
}

} // namespace pie::reference
