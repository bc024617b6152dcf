#pragma once
// Numbers without order that have an address all the same: a bijective mix of 64 bits, and what is made of it.

#include <cstdint>

namespace pie::sampling {

/// The finaliser of splitmix64: a bijection whose output bits all depend on all input bits.
[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15U;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31U);
}

inline constexpr float belowOne = 0x1.fffffep-1F; ///< the largest float in [0, 1)

/// The leading 24 bits as a number in [0, 1): as many as a float holds.
[[nodiscard]] constexpr float toUnit(std::uint64_t bits) { return static_cast<float>(bits >> 40U) * 0x1p-24F; }
[[nodiscard]] constexpr float toUnit(std::uint32_t bits) { return static_cast<float>(bits >> 8U) * 0x1p-24F; }

/// A hash in [0, 1) of two numbers: shifts (Cranley-Patterson) and choices that need no low discrepancy.
[[nodiscard]] constexpr float hash01(std::uint64_t a, std::uint64_t b) { return toUnit(mix(mix(a) ^ b)); }

/// Where `i` goes in a permutation of 0 … count - 1 that `key` chooses; 0 < count, i < count. A bijection of the next
/// power of two, walked until it comes back below count: two steps at most in the mean.
[[nodiscard]] constexpr std::uint64_t permuted(std::uint64_t i, std::uint64_t count, std::uint64_t key) {
    std::uint64_t mask = count - 1;
    for (unsigned shift = 1; shift < 64; shift *= 2) mask |= mask >> shift;
    const std::uint64_t factor = mix(key) | 1U;
    const std::uint64_t other = mix(key ^ 0x5851f42d4c957f2dU) | 1U;
    unsigned half = 1;
    while (half < 32 && (mask >> (2 * half)) != 0) ++half;
    do {
        // Odd factors and xors with higher bits are bijections below the mask.
        i = (i + (key >> 7U)) & mask;
        i = (i * factor) & mask;
        i ^= i >> half;
        i = (i * other) & mask;
        i ^= i >> half;
        i = (i * 0x9e3779b97f4a7c15U) & mask;
        i ^= i >> half;
    } while (i >= count);
    return i;
}

} // namespace pie::sampling
