#pragma once
// Halton points: randomness with an address. u(index, dimension) is the radical inverse of the index in the dimension's
// prime base (selective photon tracing, eq 2). Indices that differ by a multiple of Π b^k agree in the leading k digits
// of those dimensions (eq 3 and 5), so such photons follow similar paths; digit permutations keep that property.

#include <cstdint>

namespace pie::sampling {

inline constexpr unsigned haltonDimensions = 128;

/// Prime base of a dimension, dimension < haltonDimensions.
[[nodiscard]] std::uint32_t haltonBase(unsigned dimension);

/// The plain radical inverse, in [0, 1).
[[nodiscard]] float radicalInverse(std::uint64_t index, unsigned dimension);

/// Halton points of one seed. Seed 0 is the plain sequence in the first 6 dimensions and permuted digits above (plain
/// ones are correlated there); other seeds permute every dimension.
class Halton {
public:
    explicit Halton(std::uint64_t seed = 0) : seed_(seed) {}
    /// In [0, 1). Dimensions past haltonDimensions wrap onto permutations of their own.
    [[nodiscard]] float operator()(std::uint64_t index, unsigned dimension) const;

private:
    std::uint64_t seed_;
};

/// A hash in [0, 1) of two numbers: shifts (Cranley-Patterson) and choices that need no low discrepancy.
[[nodiscard]] float hash01(std::uint64_t a, std::uint64_t b);

} // namespace pie::sampling
