#pragma once
// Sobol points with Owen's scrambling: u(index, dimension) with an address, like Halton's, in base 2 throughout.
//
// Any 2^k consecutive indices from a multiple of 2^k fall one into each of 2^k equal spans of every dimension;
// dimensions are numbered so that the direction of emission (photon dimensions 1 and 2) is the first pair, a (0,
// 2)-sequence, and the direction of the first reflection (5 and 6) the second: these four belong together in the
// integral that most of the indirect light comes from. Photon dimensions past the table use its first three again, with
// the indices in another order each time (padding, as Burley 2020): well spread among themselves, unrelated to the
// rest.
//
// Scrambling flips every bit of a value by a hash of the bits before it (Owen 1995, by Laine and Karras's hash of
// reversed bits, 2011), one scramble per seed, dimension and block of 2^32 indices: over seeds every number is uniform.
// Initial direction numbers: Joe and Kuo 2008.

#include "pie/core/vec.h"
#include "pie/sampling/hash.h"

#include <array>
#include <cstdint>

namespace pie::sampling {

namespace detail {

/// Flips each bit by a hash of the lower ones: Owen's scrambling of a value whose bits are reversed.
[[nodiscard]] constexpr std::uint32_t scrambleReversed(std::uint32_t x, std::uint32_t key) {
    x ^= x * 0x3d20adeaU;
    x += key;
    x *= (key >> 16U) | 1U;
    x ^= x * 0x05526c56U;
    x ^= x * 0x53a22864U;
    return x;
}
[[nodiscard]] constexpr std::uint32_t reversed(std::uint32_t x) {
    x = (x >> 1U & 0x55555555U) | (x & 0x55555555U) << 1U;
    x = (x >> 2U & 0x33333333U) | (x & 0x33333333U) << 2U;
    x = (x >> 4U & 0x0f0f0f0fU) | (x & 0x0f0f0f0fU) << 4U;
    x = (x >> 8U & 0x00ff00ffU) | (x & 0x00ff00ffU) << 8U;
    return x >> 16U | x << 16U;
}
/// The order in which padded dimensions take the indices of a block of 2^32: aligned runs of 2^k stay together.
[[nodiscard]] constexpr std::uint32_t shuffled(std::uint32_t index, std::uint64_t key) {
    return reversed(scrambleReversed(reversed(index), static_cast<std::uint32_t>(mix(key))));
}

} // namespace detail

inline constexpr unsigned sobolDimensions = 10;

class Sobol {
public:
    static constexpr bool polar = false;
    explicit Sobol(std::uint64_t seed = 0) : seed_(seed) {}
    /// In [0, 1).
    [[nodiscard]] float operator()(std::uint64_t index, unsigned dimension) const;
    [[nodiscard]] Vec2 pair(std::uint64_t index, unsigned dimension) const {
        return {(*this)(index, dimension), (*this)(index, dimension + 1)};
    }
    [[nodiscard]] std::uint64_t seed() const { return seed_; }

private:
    std::uint64_t seed_;
};

/// Before scrambling, as a 32-bit fraction; column < sobolDimensions.
[[nodiscard]] std::uint32_t sobolBits(std::uint32_t index, unsigned column);

} // namespace pie::sampling
