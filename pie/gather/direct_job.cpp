#include "pie/gather/direct_job.h"

#include "pie/sampling/halton.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace pie::gather {
namespace {

/// Lights shadow tested together in the first round; later rounds double what was tested.
constexpr std::size_t firstRound = 16;
/// Points of a soft source that are tried until one contributes: parts of it may lie below the horizon.
constexpr unsigned tries = 16;
/// Light one ray to a soft source may stand for, of the absolute tolerance: several sources err together.
constexpr double softTolerance = 0.3;

std::uint64_t mix(std::uint64_t a, std::uint64_t b) {
    // SplitMix64's finaliser over a running sum.
    std::uint64_t z = a + 0x9e3779b97f4a7c15ULL * (b + 1);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
}

std::uint64_t addressOf(const scene::Receiver& receiver, std::uint64_t seed) {
    std::uint64_t address = seed;
    for (const Vec3& v : {receiver.position, receiver.normal})
        for (int i = 0; i < 3; ++i) address = mix(address, std::bit_cast<std::uint32_t>(v[i] + 0.0F)); // −0 is 0
    return address;
}

double mean(const glm::dvec3& c) { return (c.x + c.y + c.z) / 3; }

} // namespace

DirectJob::DirectJob(const DirectLight::Context& context, const scene::Receiver& receiver)
    : context_(context), place_{receiver.position, receiver.inset, receiver.normal, receiver.twoSided,
                                glm::length(receiver.inset - receiver.position)},
      address_(addressOf(receiver, context.options.seed)) {
    bound();
}

float DirectJob::hash(std::uint64_t dimension) const { return sampling::hash01(address_, dimension); }

void DirectJob::bound() {
    const Sources& sources = context_.sources;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        const float value = sources.bound(i, place_);
        if (!(value > 0.0F)) continue;
        waiting_.push_back({std::min(value, std::numeric_limits<float>::max()), static_cast<std::uint32_t>(i)});
        tail_ += static_cast<double>(waiting_.back().bound);
    }
    std::make_heap(waiting_.begin(), waiting_.end());
}

double DirectJob::seen() const {
    glm::dvec3 sum(0);
    for (const Tested& tested : tested_) sum += tested.seen();
    return std::max(0.0, mean(sum));
}

/// A draw from the tail is between 0 and tail / tailSamples: the standard deviation of their sum is at most
/// tail / (2 sqrt(tailSamples)).
double DirectJob::tailAllowed(double seen) const {
    const DirectOptions& options = context_.options;
    if (options.exhaustive || options.tailSamples == 0) return 0;
    return 2 * std::sqrt(static_cast<double>(options.tailSamples)) *
           (static_cast<double>(options.tolerance) * seen + static_cast<double>(options.absoluteTolerance));
}

void DirectJob::takeHead(RayBatch& batch) {
    const std::size_t round = context_.options.exhaustive ? waiting_.size() : std::max(firstRound, tested_.size());
    // Until rays say otherwise, what is under test counts as seen.
    double hoped = seen();
    for (std::size_t taken = 0; taken < round && !waiting_.empty() && tail_ > tailAllowed(hoped); ++taken) {
        std::pop_heap(waiting_.begin(), waiting_.end());
        const Bounded next = waiting_.back();
        waiting_.pop_back();
        tail_ = waiting_.empty() ? 0 : std::max(0.0, tail_ - static_cast<double>(next.bound));
        test(next.source, 1, context_.options.exhaustive ? context_.sources[next.source].samples : 1, batch);
        hoped += std::max(0.0, mean(glm::dvec3(tested_.back().unoccluded)));
    }
}

/// Further rays to soft lights, as many as what they could give deserves. What their first ray met does not matter: to
/// go on only where light was seen would lose what is seen in part.
void DirectJob::refineSoft(RayBatch& batch) {
    if (context_.options.exhaustive) return;
    // What one ray may stand for.
    const double finest = seen() / std::max(1U, context_.options.softSamples) +
                          softTolerance * static_cast<double>(context_.options.absoluteTolerance);
    for (std::uint32_t i = 0; i < tested_.size(); ++i) {
        const Tested& tested = tested_[i];
        const unsigned most = context_.sources[tested.source].samples;
        if (most <= 1 || tested.contributions == 0) continue;
        const double wanted = std::ceil(mean(glm::abs(glm::dvec3(tested.unoccluded))) / finest);
        if (!(wanted > 1)) continue;
        const auto samples = static_cast<unsigned>(std::min(wanted, static_cast<double>(most)));
        if (samples > tested.samples) ask(i, samples - tested.samples, batch);
    }
}

void DirectJob::drawTail(RayBatch& batch) {
    if (waiting_.empty() || !(tail_ > 0)) return;
    // Summed anew: `tail_` has been counted down.
    double total = 0;
    for (const Bounded& waiting : waiting_) total += static_cast<double>(waiting.bound);
    std::sort(waiting_.begin(), waiting_.end(), [&](const Bounded& a, const Bounded& b) {
        return context_.sources.rank(a.source) < context_.sources.rank(b.source);
    });
    const unsigned draws = context_.options.tailSamples;
    const double step = total / draws;
    const double first = step * static_cast<double>(hash(0));
    double sum = 0;
    unsigned draw = 0; // the next one is at first + draw · step
    for (const Bounded& waiting : waiting_) {
        sum += static_cast<double>(waiting.bound);
        unsigned times = 0;
        while (draw < draws && first + draw * step < sum) {
            ++times;
            ++draw;
        }
        if (times == 0) continue;
        test(waiting.source, times * step / static_cast<double>(waiting.bound), times, batch);
        tested_.back().draws = times;
    }
}

void DirectJob::test(std::uint32_t source, double weight, unsigned samples, RayBatch& batch) {
    Tested tested;
    tested.source = source;
    tested.weight = weight;
    tested.unoccluded = context_.sources.unoccluded(source, place_);
    tested_.push_back(tested);
    if (tested.unoccluded != Rgb(0.0F))
        ask(static_cast<std::uint32_t>(tested_.size() - 1), std::min(samples, context_.sources[source].samples), batch);
}

void DirectJob::ask(std::uint32_t number, unsigned samples, RayBatch& batch) {
    Tested& tested = tested_[number];
    const bool soft = context_.sources[tested.source].samples > 1;
    const std::uint64_t light = 2 * (std::uint64_t{tested.source} + 1);
    const Vec2 shift = soft ? Vec2(hash(light), hash(light + 1)) : Vec2(0.5F);
    unsigned traced = 0;
    for (unsigned i = 0; traced < samples && i < samples + tries; ++i) {
        const auto n = static_cast<double>(tested.samples++);
        const Vec2 u(static_cast<float>(glm::fract(static_cast<double>(shift.x) + n * 0.7548776662466927)),
                     static_cast<float>(glm::fract(static_cast<double>(shift.y) + n * 0.5698402909980532)));
        const lights::Illumination way = context_.sources.sample(tested.source, place_, glm::min(u, Vec2(0.99999994F)));
        const float contribution = meanChannel(glm::abs(way.irradiance));
        if (!(contribution > 0.0F)) continue;
        ++traced;
        const float side = glm::dot(way.towards, place_.normal) < 0.0F ? -1.0F : 1.0F;
        intersect::Ray ray;
        ray.origin = place_.inset + side * context_.offset * place_.normal;
        ray.direction = way.towards;
        if (!way.needsSky && std::isfinite(way.distance)) {
            const Vec3 to = context_.sources.pointFor(tested.source, place_) + way.distance * way.towards - ray.origin;
            const float distance = glm::length(to);
            if (distance > 0.0F) ray.direction = to / distance;
            ray.tMax = distance - std::min(context_.offset, 0.5F * distance);
        }
        asked_.push_back({number, static_cast<std::uint32_t>(batch.rays.size()), contribution});
        batch.rays.push_back(ray);
        batch.needsSky.push_back(way.needsSky ? 1 : 0);
        if (!soft) break;
    }
}

bool DirectJob::request(RayBatch& batch) {
    asked_.clear();
    while (stage_ != Stage::Done && asked_.empty()) {
        if (stage_ == Stage::Head) {
            takeHead(batch);
            // Done with the head once what waits is small against what is seen.
            if (asked_.empty() && (waiting_.empty() || tail_ <= tailAllowed(seen()))) stage_ = Stage::Soft;
        } else if (stage_ == Stage::Soft) {
            refineSoft(batch);
            stage_ = Stage::Tail;
        } else {
            drawTail(batch);
            stage_ = Stage::Done;
        }
    }
    return !asked_.empty();
}

void DirectJob::absorb(const RayBatch& batch) {
    for (const Asked& asked : asked_) {
        Tested& tested = tested_[asked.tested];
        tested.contributions += static_cast<double>(asked.contribution);
        const glm::dvec3 through(batch.through[asked.ray]);
        tested.through += static_cast<double>(asked.contribution) * through;
        if (context_.sources[tested.source].samples > 1)
            drawn_.push_back(
                {asked.tested, static_cast<double>(asked.contribution), mean(glm::dvec3(tested.unoccluded) * through)});
    }
}

Rgb DirectJob::irradiance() const {
    glm::dvec3 sum(0);
    for (const Tested& tested : tested_) sum += tested.seen();
    Rgb result(0.0F);
    for (int i = 0; i < 3; ++i)
        if (sum[i] > 0) result[i] = static_cast<float>(std::min(sum[i], double{std::numeric_limits<float>::max()}));
    return result;
}

} // namespace pie::gather
