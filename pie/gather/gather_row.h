#pragma once
// A row of the cached gather: which surfaces the rays of one receiver met, and how many of them. Made once, read in
// every frame; reading is what a steady frame mostly consists of, so a row is packed for that.
//
// Most surfaces are met by one ray. Their numbers come first, four at a time: a sum without a product. What more rays,
// or shares of them, met follows, its number in 22 bits and its weight in 10: a float without sign, with 4 bits of
// exponent and 6 of fraction, exact for up to 128 rays. What rounding takes from one weight the next one gets, so that
// the weights of a row add up to within 1/128 of a ray and an entry. Rows that are read together lie together, see
// pack().

#include "pie/core/vec.h"
#include "pie/gather/texel_light.h"

#include <bit>
#include <cstdint>
#include <memory>
#include <span>

namespace pie::gather {

class GatherRow {
public:
    /// Numbers are less than this.
    static constexpr std::size_t mostNumbers = std::size_t{1} << 22U;

    struct Part {
        std::uint32_t number = 0; ///< of a radiosity
        float rays = 0;           ///< that met it; need not be whole
    };

    GatherRow() = default;
    /// No number may stand twice. `dark`: number of a radiosity that is always 0, for the places that are left over.
    GatherRow(std::span<const Part> parts, std::uint32_t dark);

    /// Moves the rows `which` of `rows` into one piece of memory, one after the other. It is given back with the last
    /// of them.
    static void pack(std::span<const std::uint32_t> which, std::span<GatherRow> rows);

    /// Calls use(number, weight) once for every number; `each`: weight of one ray.
    template <class Use> void forEach(float each, const Use& use) const;
    /// Puts renumbered(number) in place of every number; different ones must stay different.
    template <class Renumber> void renumber(const Renumber& renumbered);

    /// Σ weight · radiosity.
    [[nodiscard]] Rgb gathered(std::span<const TexelLight::Radiosity> radiosity, float each) const;

    [[nodiscard]] std::size_t bytes() const { return (singlePlaces() + heavyPlaces()) * sizeof(std::uint32_t); }

private:
    static constexpr unsigned weightBits = 10;
    static constexpr unsigned lostBits = 17;               ///< of a float's fraction
    static constexpr std::uint32_t exponent = 119U << 23U; ///< of the least weight, 2⁻⁸
    static constexpr float mostRays = 254;                 ///< that a weight can say
    static constexpr std::uint32_t codeMask = (1U << weightBits) - 1;

    [[nodiscard]] static std::uint32_t code(float rays);
    [[nodiscard]] static float decoded(std::uint32_t entry) {
        return std::bit_cast<float>(((entry & codeMask) << lostBits) + exponent);
    }
    [[nodiscard]] std::size_t singlePlaces() const { return (std::size_t{singles_} + 3) & ~std::size_t{3}; }
    [[nodiscard]] std::size_t heavyPlaces() const { return (std::size_t{heavy_} + 1) & ~std::size_t{1}; }

    std::shared_ptr<std::uint32_t[]> entries_; ///< shares what it points into with the rows it is packed with
    std::uint32_t singles_ = 0;
    std::uint32_t heavy_ = 0;
};

template <class Use> void GatherRow::forEach(float each, const Use& use) const {
    const std::uint32_t* const entries = entries_.get();
    for (std::size_t i = 0; i < singles_; ++i) use(entries[i], each);
    const std::size_t end = singlePlaces() + heavy_;
    for (std::size_t i = singlePlaces(); i < end;) {
        const std::uint32_t number = entries[i] >> weightBits;
        float rays = 0; // many are written in several pieces
        for (; i < end && entries[i] >> weightBits == number; ++i) rays += decoded(entries[i]);
        use(number, each * rays);
    }
}

template <class Renumber> void GatherRow::renumber(const Renumber& renumbered) {
    std::uint32_t* const entries = entries_.get();
    for (std::size_t i = 0; i < singles_; ++i) entries[i] = renumbered(entries[i]);
    for (std::size_t i = singlePlaces(); i < singlePlaces() + heavy_; ++i)
        entries[i] = renumbered(entries[i] >> weightBits) << weightBits | (entries[i] & codeMask);
}

} // namespace pie::gather
