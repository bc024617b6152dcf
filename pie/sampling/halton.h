#pragma once
// Halton points: randomness with an address. u(index, dimension) is the radical inverse of the index in the dimension's
// prime base (selective photon tracing, eq 2). Indices that differ by a multiple of Π b^k agree in the leading k digits
// of those dimensions (eq 3 and 5), so such photons follow similar paths; digit permutations keep that property.
//
// A number costs a few nanoseconds: several digits at once are looked up in a table of reversed and permuted digit
// blocks, one table per dimension and block. Halton objects of one seed share their tables
// (2 MB, 2 ms to build; those of the last four seeds are remembered).

#include "pie/core/vec.h"
#include "pie/sampling/hash.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace pie::sampling {

inline constexpr unsigned haltonDimensions = 128;

/// Prime base of a dimension, dimension < haltonDimensions.
[[nodiscard]] std::uint32_t haltonBase(unsigned dimension);

/// The plain radical inverse, in [0, 1).
[[nodiscard]] float radicalInverse(std::uint64_t index, unsigned dimension);

namespace detail {

/// One dimension of one seed: blocks of digits, least significant first, with what each block value adds to u.
struct HaltonRow {
    static constexpr std::size_t maxBlocks = 8;
    std::uint64_t magic = 0;  ///< ceil(2^64 / size): n / size for n < 2^32 is one multiplication
    std::uint32_t size = 2;   ///< values a block can take: base^digits
    std::uint32_t blocks = 0; ///< enough for 32 bits; further digits are below the precision of the result
    const double* values = nullptr;
    std::array<double, maxBlocks + 1> tail{}; ///< what blocks k and up add when all their digits are zero

    [[nodiscard]] float operator()(std::uint64_t index) const {
        const std::uint64_t rest = quotient(index);
        return number(values[index - rest * size], above(rest));
    }
    /// The numbers of consecutive indices, to the bit those of operator().
    void fill(std::uint64_t first, std::span<float> out) const {
        for (std::size_t i = 0; i < out.size();) {
            const std::uint64_t rest = quotient(first + i);
            const double* digits = values + (first + i - rest * size);
            const double high = above(rest);
            // To the end of the block of digits, or to where indices begin again.
            const auto left = static_cast<std::uint64_t>(values + size - digits) - 1;
            const std::size_t end = std::min<std::size_t>(out.size(), i + std::min(left, ~(first + i)) + 1);
            for (; i < end; ++i) out[i] = number(*digits++, high);
        }
    }

private:
    [[nodiscard]] std::uint64_t quotient(std::uint64_t index) const {
        __extension__ using Wide = unsigned __int128;
        return (index >> 32U) != 0 ? index / size
                                   : static_cast<std::uint64_t>((static_cast<Wide>(index) * magic) >> 64U);
    }
    /// What the blocks above the first add.
    [[nodiscard]] double above(std::uint64_t index) const {
        const double* table = values + size;
        double sum = 0.0;
        std::uint32_t block = 1;
        for (; index != 0 && block < blocks; ++block, table += size) {
            const std::uint64_t rest = quotient(index);
            sum += table[index - rest * size];
            index = rest;
        }
        return sum + tail[block];
    }
    static float number(double low, double high) {
        const auto u = static_cast<float>(low + high);
        return u < belowOne ? u : belowOne; // rounding to float must not reach 1
    }
};

struct HaltonTables;

} // namespace detail

/// Halton points of one seed. Seed 0 is the plain sequence in the first 6 dimensions and permuted digits above (plain
/// ones are correlated there); other seeds permute every dimension. Every digit position has its own permutation.
class Halton {
public:
    static constexpr bool polar = false;
    explicit Halton(std::uint64_t seed = 0);
    /// In [0, 1). Dimensions past haltonDimensions wrap onto permutations of their own.
    [[nodiscard]] float operator()(std::uint64_t index, unsigned dimension) const {
        return dimension < haltonDimensions ? rows_[dimension](index) : beyond(index, dimension);
    }
    [[nodiscard]] Vec2 pair(std::uint64_t index, unsigned dimension) const {
        return {(*this)(index, dimension), (*this)(index, dimension + 1)};
    }
    /// The numbers of `out.size()` consecutive indices in one dimension, equal to those of operator() and cheaper.
    void fill(std::uint64_t first, unsigned dimension, std::span<float> out) const {
        if (dimension < haltonDimensions) return rows_[dimension].fill(first, out);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = beyond(first + i, dimension);
    }
    [[nodiscard]] std::uint64_t seed() const { return seed_; }

private:
    [[nodiscard]] float beyond(std::uint64_t index, unsigned dimension) const;

    std::uint64_t seed_;
    std::shared_ptr<const detail::HaltonTables> tables_;
    const detail::HaltonRow* rows_;
};

} // namespace pie::sampling
