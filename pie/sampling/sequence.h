#pragma once
// Where the numbers of a photon come from, by name (pi-engine parameters 15 and 16). Every distribution answers
//
//   s(index, dimension)        one number in [0, 1): which light, roulette
//   s.pair(index, dimension)   the numbers of `dimension` and `dimension` + 1: a place, a direction
//
// and is a pure function of seed and address: the same on any thread, in any order. `Sequence` holds one of them. Loops
// over photons open it once, outside (std::visit), so that a number costs no choice.
//
// Directions are made of pairs: `cosine`, and for the children of a split hit `fan`, below.

#include "pie/sampling/directions.h"
#include "pie/sampling/framed.h"
#include "pie/sampling/halton.h"
#include "pie/sampling/kronecker.h"
#include "pie/sampling/random.h"
#include "pie/sampling/sobol.h"

#include <concepts>
#include <cstdint>
#include <span>
#include <variant>

namespace pie::sampling {

enum class Distribution : std::uint8_t {
    Halton,     ///< digits mirrored, a prime base per dimension; coherent in groups (selective photon tracing, eq 5)
    Sobol,      ///< base 2, Owen-scrambled
    R2,         ///< multiples of generalised golden ratios
    Explicit,   ///< random numbers, mapped by inversion (pi-engine 3.4.1)
    Rejection,  ///< random points of a cube until one is in the ball (fig 3.5)
    Stratified, ///< a random point in each of as many strata as a frame has photons (eq 3.11)
    Spiral,     ///< Saff and Kuijlaars (fig 3.6)
};

/// In the order of Distribution.
using Sequence = std::variant<Halton, Sobol, Kronecker, Random, Rejection, Stratified, Spiral>;

struct SequenceOptions {
    std::uint64_t seed = 0;
    std::uint64_t pointsPerFrame = 1; ///< Stratified and Spiral: indices [n p, (n + 1) p) are frame n; 0 counts as 1
    std::uint64_t children = 1;       ///< Spiral: of a split hit
};
/// Costs a table of 2 MB for Halton (shared by those of one seed), 4 bytes per point for Spiral.
[[nodiscard]] Sequence makeSequence(Distribution distribution, const SequenceOptions& options);

/// Whether pairs mean a turn about a pole rather than a place in a square: then directions are to be made by
/// `polarCosineHemisphere`. For whole spheres and cones both are the same.
[[nodiscard]] bool isPolar(const Sequence& sequence);

/// Numbers of consecutive indices, out[i] for `first` + i, to the bit those of single calls and cheaper.
void fill(const Sequence& sequence, std::uint64_t first, unsigned dimension, std::span<float> out);
/// The same for pairs that place something.
void fillPairs(const Sequence& sequence, std::uint64_t first, unsigned dimension, std::span<float> x,
               std::span<float> y);
/// The same for pairs that mean directions of spheres and cones: of Rejection those that its directions invert to.
void fillDirections(const Sequence& sequence, std::uint64_t first, unsigned dimension, std::span<float> x,
                    std::span<float> y);

/// A cosine-distributed direction about +z.
template <class Numbers> [[nodiscard]] Vec3 cosine(const Numbers& s, std::uint64_t index, unsigned dimension) {
    if constexpr (std::same_as<Numbers, Rejection>)
        return s.cosine(index, dimension);
    else if constexpr (Numbers::polar)
        return polarCosineHemisphere(s.pair(index, dimension));
    else
        return cosineHemisphere(s.pair(index, dimension));
}

/// Directions of the children of a split hit, well spread among themselves: `fan(s, …)(j)` is child j of `count`.
/// `branch` tells apart the hits of one index at one reflection.
///
/// Halton, Sobol and R2: the index's own pair, shifted by point j of a Hammersley set. Stratified and Spiral: a set of
/// `count` points of its own. The others: independent.
template <class Numbers>
[[nodiscard]] auto fan(const Numbers& s, std::uint64_t index, unsigned dimension, std::uint32_t branch,
                       std::uint32_t count);

/// Point j of `count` of a Hammersley set and a point of the R2 lattice per branch, so that sister branches do not
/// repeat each other, on top of `own`.
[[nodiscard]] Vec2 shiftedHammersley(const Vec2& own, std::uint32_t j, std::uint32_t count, std::uint32_t branch);

template <class Numbers>
auto fan(const Numbers& s, std::uint64_t index, unsigned dimension, std::uint32_t branch, std::uint32_t count) {
    if constexpr (std::same_as<Numbers, Rejection>) {
        return [=, &s](std::uint32_t j) { return s.cosineChild(index, dimension, std::uint64_t{branch} * count + j); };
    } else if constexpr (std::same_as<Numbers, Random>) {
        return [=, &s](std::uint32_t j) {
            return cosineHemisphere(s.child(index, dimension, std::uint64_t{branch} * count + j));
        };
    } else if constexpr (Numbers::polar) {
        const std::uint64_t key = s.childKey(index, dimension, branch);
        return [=, &s](std::uint32_t j) { return polarCosineHemisphere(s.child(key, j, count)); };
    } else {
        const Vec2 own = s.pair(index, dimension);
        return [=](std::uint32_t j) { return cosineHemisphere(shiftedHammersley(own, j, count, branch)); };
    }
}

} // namespace pie::sampling
