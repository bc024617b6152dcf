#include "pie/sampling/sequence.h"

#include <algorithm>
#include <cmath>

namespace pie::sampling {
namespace {

float fraction(double x) { return std::min(static_cast<float>(x - std::floor(x)), 0x1.fffffep-1F); }

} // namespace

Sequence makeSequence(Distribution distribution, const SequenceOptions& options) {
    switch (distribution) {
    case Distribution::Halton: break;
    case Distribution::Sobol: return Sobol(options.seed);
    case Distribution::R2: return Kronecker(options.seed);
    case Distribution::Explicit: return Random(options.seed);
    case Distribution::Rejection: return Rejection(options.seed);
    case Distribution::Stratified: return Stratified(options.seed, options.pointsPerFrame);
    case Distribution::Spiral: return Spiral(options.seed, options.pointsPerFrame, options.children);
    }
    return Halton(options.seed);
}

bool isPolar(const Sequence& sequence) {
    return std::visit([](const auto& s) { return std::remove_cvref_t<decltype(s)>::polar; }, sequence);
}

void fill(const Sequence& sequence, std::uint64_t first, unsigned dimension, std::span<float> out) {
    std::visit(
        [&]<class Numbers>(const Numbers& s) {
            if constexpr (std::same_as<Numbers, Halton>)
                s.fill(first, dimension, out);
            else
                for (std::size_t i = 0; i < out.size(); ++i) out[i] = s(first + i, dimension);
        },
        sequence);
}

void fillPairs(const Sequence& sequence, std::uint64_t first, unsigned dimension, std::span<float> x,
               std::span<float> y) {
    std::visit(
        [&]<class Numbers>(const Numbers& s) {
            if constexpr (std::same_as<Numbers, Halton>) {
                s.fill(first, dimension, x);
                s.fill(first, dimension + 1, y);
            } else {
                for (std::size_t i = 0; i < x.size(); ++i) {
                    const Vec2 u = s.pair(first + i, dimension);
                    x[i] = u.x;
                    y[i] = u.y;
                }
            }
        },
        sequence);
}

void fillDirections(const Sequence& sequence, std::uint64_t first, unsigned dimension, std::span<float> x,
                    std::span<float> y) {
    const auto* rejection = std::get_if<Rejection>(&sequence);
    if (rejection == nullptr) return fillPairs(sequence, first, dimension, x, y);
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Vec2 u = invertUniformSphere(rejection->sphere(first + i, dimension));
        x[i] = u.x;
        y[i] = u.y;
    }
}

Vec2 shiftedHammersley(const Vec2& own, std::uint32_t j, std::uint32_t count, std::uint32_t branch) {
    return {fraction(own.x + static_cast<double>(j) / count + branch * 0.7548776662466927),
            fraction(own.y + static_cast<double>(radicalInverse(j, 0)) + branch * 0.5698402909980532)};
}

} // namespace pie::sampling
