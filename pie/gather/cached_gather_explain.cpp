// What a gather knows about its error.

#include "pie/gather/cached_gather.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pie::gather {
namespace {

double mean(const TexelLight::Radiosity& b) { return static_cast<double>(b.r + b.g + b.b) / 3; }

/// Squared standard error of a mean over values of batches, from their sum and the sum of their squares.
double squaredError(double sum, double squares) {
    constexpr double count = TexelLight::batches;
    return std::max(0.0, squares - sum * sum / count) / (count * (count - 1));
}

std::vector<double> noiseOf(std::span<const std::vector<TexelLight::Radiosity>> batches) {
    std::vector<double> noise(batches.front().size());
    for (std::size_t i = 0; i < noise.size(); ++i) {
        double sum = 0;
        double squares = 0;
        for (const auto& radiosity : batches) {
            sum += mean(radiosity[i]);
            squares += mean(radiosity[i]) * mean(radiosity[i]);
        }
        noise[i] = squaredError(sum, squares);
    }
    return noise;
}

} // namespace

/// What all receivers are explained with.
struct CachedGather::Explanation {
    std::vector<Radiosities> batches; ///< photons of one batch alone, both ways
    Radiosities coarse;               ///< of level 1; empty: there is none
    std::vector<double> noise;        ///< squared standard error of each radiosity by its photons, both ways
    std::vector<double> variance;     ///< of each point's own gather, mean over the channels

    /// Twice the variance of a stratum from its two rays. What photons add to their difference is taken out again: it
    /// is in the spread of the batches already.
    [[nodiscard]] double pair(std::span<const TexelLight::Radiosity> radiosity, const Pair& pair) const {
        const auto [a, b] = pair.numbers;
        const std::array<double, 2> weights{pair.weights[0], pair.weights[1]};
        const auto light = [&](std::uint32_t i) { return i == SurfaceTexels::none ? 0.0 : mean(radiosity[i]); };
        const auto its = [&](std::uint32_t i) { return i == SurfaceTexels::none || noise.empty() ? 0.0 : noise[i]; };
        const double difference = weights[0] * light(a) - weights[1] * light(b);
        if (a == b) return difference * difference - std::pow(weights[0] - weights[1], 2) * its(a);
        return difference * difference - weights[0] * weights[0] * its(a) - weights[1] * weights[1] * its(b);
    }
};

void CachedGather::explain(std::span<const std::uint32_t> which, std::span<Estimate> estimates) const {
    std::vector<Rgb> irradiance(which.size());
    estimate(which, irradiance);
    Explanation with;
    if (options_.standardErrors) {
        for (unsigned b = 0; b < TexelLight::batches; ++b)
            bothWays(light_.batchRadiosity(b), false, with.batches.emplace_back());
        with.noise = noiseOf(with.batches);
        for (std::size_t p = 0; p < pointPairs_.size(); ++p) {
            double sum = 0;
            for (const Pair& pair : pointPairs_[p]) sum += with.pair(radiosity_, pair);
            const auto reflectance = static_cast<double>(meanChannel(texels_.texels()[texelOfPoint(p)].reflectance));
            with.variance.push_back(reflectance * reflectance * std::max(0.0, sum));
        }
    }
    if (texels_.levels() > 1) with.coarse = light_.coarseRadiosity(1);
    parallelChunks(which.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            estimates[i] = {irradiance[i]};
            explainOne(which[i], with, estimates[i]);
        }
    });
}

void CachedGather::explainOne(std::uint32_t receiver, const Explanation& with, Estimate& out) const {
    out.radius = texels_.edge();
    if (stage_[receiver] <= Direct) return;
    const unsigned n = raysAt(stage_[receiver]);
    const float each = 1.0F / static_cast<float>(n);
    const GatherRow& row = rows_[receiver];
    // Which of the two ways a texel is taken depends on the row.
    std::vector<std::uint32_t> large;
    double variance = 0;
    const unsigned points = texels_.pointsPerTexel();
    row.forEach(each, [&](std::uint32_t number, float weight) {
        const double squared = std::pow(static_cast<double>(weight), 2);
        std::uint32_t texel = number;
        if (number >= firstPoint()) {
            const std::uint32_t point = number - firstPoint();
            texel = texelOfPoint(point);
            if (!with.variance.empty()) variance += squared * with.variance[point];
            if (std::find(large.begin(), large.end(), texel) == large.end()) {
                large.push_back(texel);
                out.photons += light_.photons(texel);
            }
        } else {
            out.photons += light_.photons(texel);
        }
        const auto directError = static_cast<double>(light_.directError(texel));
        variance += squared * directError * directError;
    });
    const auto numberOf = [&](const TexelHit& hit) {
        if (hit.texel == SurfaceTexels::none || std::find(large.begin(), large.end(), hit.texel) == large.end())
            return hit.texel;
        const std::uint32_t place = placeOf_[hit.texel * points + nearestPoint(hit.texel, hit.point)];
        return place == SurfaceTexels::none ? hit.texel : firstPoint() + place; // none: its rays weigh nothing
    };
    std::vector<TexelHit> hits;
    gatherRays_.shoot(std::span(&receiver, 1), n, hits);
    double pairs = 0;
    double between = 0; // texels and the next coarser ones
    double within = 0;  // points and their texels
    for (std::size_t k = 0; k + 1 < hits.size(); k += 2) {
        pairs +=
            with.pair(radiosity_, {{numberOf(hits[k]), numberOf(hits[k + 1])}, {hits[k].weight, hits[k + 1].weight}});
        for (const TexelHit& hit : {hits[k], hits[k + 1]}) {
            if (hit.texel == SurfaceTexels::none) continue;
            const auto weight = static_cast<double>(hit.weight);
            if (!with.coarse.empty())
                between += weight * (mean(light_.radiosity()[hit.texel]) -
                                     mean(with.coarse[texels_.texels()[hit.texel].parent]));
            const std::uint32_t number = numberOf(hit);
            if (number < firstPoint()) continue;
            double whole = 0;
            unsigned gathering = 0;
            for (unsigned p = 0; p < points; ++p) {
                const std::uint32_t place = placeOf_[hit.texel * points + p];
                if (place == SurfaceTexels::none) continue;
                whole += mean(radiosity_[firstPoint() + place]);
                ++gathering;
            }
            within += weight * (mean(radiosity_[number]) - whole / gathering);
        }
    }
    variance += std::max(0.0, pairs);
    if (!with.batches.empty()) {
        double sum = 0;
        double squares = 0;
        for (const Radiosities& batch : with.batches) {
            const auto light = static_cast<double>(meanChannel(row.gathered(batch, each)));
            sum += light;
            squares += light * light;
        }
        variance += squaredError(sum, squares);
    }
    if (!direct_) {
        std::int64_t photons = 0;
        const auto light =
            static_cast<double>(meanChannel(firstHits_->broadIrradiance(own_[receiver], enoughFirstHits, &photons)));
        if (photons > 0) variance += light * light / static_cast<double>(photons); // of about equal power: Poisson
    }
    out.standardError = static_cast<float>(std::sqrt(variance));
    out.bias = static_cast<float>(std::abs(between) + std::abs(within));
}

} // namespace pie::gather
