#pragma once
// Point sets of a known size: the photons of a frame, or the children of a split hit, share one set (pi-engine 3.4).
//
// Photon `index` is number index mod n of frame floor(index / n), with n points in a frame. Its point in dimension d is
// one of the n points of the set, in an order of d's own, so that dimensions are unrelated; a frame and dimension of
// its own jitter or shift makes every number uniform over frames. All is a pure function of (index, dimension), as
// ever.
//
// Dimension 0, which light, goes through the set in order, and dimension 1, the direction of emission, in steps of the
// golden section, both round and round from somewhere: photons of one light are consecutive, and such a run is spread
// over the whole set.

//
// Pairs are polar: the first number is the share of the measure nearer to the pole, the second the turn about it.

#include "pie/core/vec.h"
#include "pie/sampling/hash.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace pie::sampling {

class Framed {
public:
    static constexpr bool polar = true;
    [[nodiscard]] std::uint64_t pointsPerFrame() const { return count_; }
    /// Of a hit that splits.
    [[nodiscard]] std::uint64_t childKey(std::uint64_t index, unsigned dimension, std::uint32_t branch) const {
        return mix(mix(mix(seed_ ^ dimension) + index) ^ branch);
    }

protected:
    Framed(std::uint64_t seed, std::uint64_t pointsPerFrame);
    struct Place {
        std::uint64_t point = 0; ///< of the set
        std::uint64_t key = 0;   ///< of frame and dimension
    };
    [[nodiscard]] Place place(std::uint64_t index, unsigned dimension) const;

private:
    std::uint64_t seed_, count_, golden_;
};

/// One random point in each of n strata of equal measure (eq 3.11). n = M N need not have factors: some of the M rings
/// have one stratum more than others, and are as much wider.
class Stratified : public Framed {
public:
    Stratified(std::uint64_t seed, std::uint64_t pointsPerFrame) : Framed(seed, pointsPerFrame) {}
    [[nodiscard]] float operator()(std::uint64_t index, unsigned dimension) const;
    [[nodiscard]] Vec2 pair(std::uint64_t index, unsigned dimension) const;
    /// Child `child` of `count` of the hit that `key` names, as a set of its own.
    [[nodiscard]] Vec2 child(std::uint64_t key, std::uint64_t child, std::uint64_t count) const;
};

/// The spiral of Saff and Kuijlaars (fig 3.6): n points from pole to pole at equal steps of height, each turned on from
/// the last by 3.6 / sqrt(n (1 - h²)). In a frame of its own all of it is turned and shifted along by one number each,
/// so that unlike the original it is right in the mean at the poles, too.
class Spiral : public Framed {
public:
    Spiral(std::uint64_t seed, std::uint64_t pointsPerFrame, std::uint64_t children);
    [[nodiscard]] float operator()(std::uint64_t index, unsigned dimension) const;
    [[nodiscard]] Vec2 pair(std::uint64_t index, unsigned dimension) const;
    [[nodiscard]] Vec2 child(std::uint64_t key, std::uint64_t child, std::uint64_t count) const;

private:
    using Turns = std::vector<float>; ///< of every point, from the first
    [[nodiscard]] static std::shared_ptr<const Turns> turnsOf(std::uint64_t count);
    [[nodiscard]] static Vec2 point(const Turns& turns, std::uint64_t number, std::uint64_t key);

    std::shared_ptr<const Turns> frame_, children_;
};

} // namespace pie::sampling
