#pragma once
// Random numbers with an address: a hash of index, dimension and attempt. What the paper draws from a generator
// (pi-engine 3.4.1), so that quasi-random points have something to be compared with.

#include "pie/core/vec.h"
#include "pie/sampling/hash.h"

#include <cstdint>

namespace pie::sampling {

/// Explicit sampling: independent numbers, mapped to directions by inversion.
class Random {
public:
    static constexpr bool polar = false;
    explicit Random(std::uint64_t seed = 0) : key_(mix(seed)) {}
    /// In [0, 1).
    [[nodiscard]] float operator()(std::uint64_t index, unsigned dimension) const {
        return toUnit(bits(index, dimension));
    }
    [[nodiscard]] Vec2 pair(std::uint64_t index, unsigned dimension) const {
        return unitSquare(bits(index, dimension));
    }
    /// Of child `child` of a split; another for every branch.
    [[nodiscard]] Vec2 child(std::uint64_t index, unsigned dimension, std::uint64_t child) const {
        return unitSquare(bits(index, dimension, child + 1));
    }

protected:
    [[nodiscard]] std::uint64_t bits(std::uint64_t index, unsigned dimension, std::uint64_t child = 0,
                                     std::uint64_t attempt = 0) const {
        return mix(mix(mix(key_ ^ dimension) + index) ^ (child << 16U) ^ attempt);
    }
    [[nodiscard]] static Vec2 unitSquare(std::uint64_t bits) {
        return {toUnit(bits), toUnit(static_cast<std::uint32_t>(bits))};
    }

private:
    std::uint64_t key_;
};

/// Rejection sampling (pi-engine fig 3.5): points of a cube until one lies in the ball, of a square until one lies in
/// the disc. 1.9 and 1.3 attempts in the mean; after 64 (once in 10^21 and 10^42) the last one is taken for the middle.
class Rejection : public Random {
public:
    static constexpr bool polar = true;
    using Random::Random;
    /// Uniform on the sphere.
    [[nodiscard]] Vec3 sphere(std::uint64_t index, unsigned dimension) const;
    /// Cosine-distributed about +z: uniform in the disc, lifted.
    [[nodiscard]] Vec3 cosine(std::uint64_t index, unsigned dimension) const { return lifted(index, dimension, 0); }
    [[nodiscard]] Vec3 cosineChild(std::uint64_t index, unsigned dimension, std::uint64_t child) const {
        return lifted(index, dimension, child + 1);
    }

private:
    [[nodiscard]] Vec3 lifted(std::uint64_t index, unsigned dimension, std::uint64_t child) const;
};

} // namespace pie::sampling
