#pragma once
// The R sequences of Roberts (2018): multiples of generalised golden ratios modulo 1, and a number costs one
// multiplication. Dimension k of d steps by g^-k, where g^(d+1) = g + 1. For d = 2 that is the R2 sequence.
//
// The direction of emission and that of the first reflection are the four dimensions of R4: they belong together in the
// integral that most of the indirect light comes from, and pairs of R4 are nearly as even as R2. What chooses and
// places a light, and roulette, step by square roots of primes. Deeper reflections take R2 again, with the indices in
// another order each time (aligned runs of 2^k stay together), which makes them unrelated to the rest.

#include "pie/core/vec.h"
#include "pie/sampling/sobol.h"

#include <array>
#include <cstdint>

namespace pie::sampling {

class Kronecker {
public:
    static constexpr bool polar = false;
    explicit Kronecker(std::uint64_t seed = 0) : seed_(seed) {}
    /// In [0, 1).
    [[nodiscard]] float operator()(std::uint64_t index, unsigned dimension) const {
        // Fixed point: products wrap modulo 1 exactly, whatever the index.
        const std::uint64_t shift = mix(seed_ ^ mix(dimension));
        if (dimension < steps.size()) return toUnit(index * steps[dimension] + shift);
        const unsigned group = (dimension - 5) / 3;
        const std::uint64_t block = index >> 32U << 32U;
        const std::uint64_t other =
            block | detail::shuffled(static_cast<std::uint32_t>(index), mix(seed_ ^ mix(block)) + group);
        return toUnit(other * deepSteps[(dimension - 5) % 3] + shift);
    }
    [[nodiscard]] Vec2 pair(std::uint64_t index, unsigned dimension) const {
        return {(*this)(index, dimension), (*this)(index, dimension + 1)};
    }
    [[nodiscard]] std::uint64_t seed() const { return seed_; }

private:
    // Times 2^64, odd.
    static constexpr std::array<std::uint64_t, 8> steps{
        0x6a09e667f3bcc909U,                      // which light: square root of 2
        0xdb4f0b9175ae2165U, 0xbbe0563303a4615fU, // direction of emission: 1/g, 1/g² of R4
        0xbb67ae8584caa73bU, 0x3c6ef372fe94f82bU, // place: square roots of 3 and 5
        0xa0f2ec75a1fe1575U, 0x89e182857d9ed689U, // direction of the first reflection: 1/g³, 1/g⁴ of R4
        0xa54ff53a5f1d36f1U};                     // roulette: square root of 7
    static constexpr std::array<std::uint64_t, 3> deepSteps{0xc13fa9a902a6328fU, 0x91e10da5c79e7b1dU, // direction: R2
                                                            0x9e3779b97f4a7c15U}; // roulette: the golden ratio

    std::uint64_t seed_;
};

} // namespace pie::sampling
