#include "pie/sampling/sobol.h"

namespace pie::sampling {
namespace {

/// A primitive polynomial over the field of two (degree, inner coefficients) and odd initial numbers.
struct Column {
    unsigned degree, polynomial;
    std::array<std::uint32_t, 5> initial;
};
constexpr std::array<Column, sobolDimensions> columns{{{0, 0, {}},
                                                       {1, 0, {1}},
                                                       {2, 1, {1, 3}},
                                                       {3, 1, {1, 3, 1}},
                                                       {3, 2, {1, 1, 1}},
                                                       {4, 1, {1, 1, 3, 3}},
                                                       {4, 4, {1, 3, 5, 13}},
                                                       {5, 2, {1, 1, 5, 5, 17}},
                                                       {5, 4, {1, 1, 5, 5, 5}},
                                                       {5, 7, {1, 1, 7, 11, 19}}}};

/// Column by photon dimension: direction of emission, direction of the first reflection, choice of the light, place,
/// roulette, direction of the second reflection.
constexpr std::array<unsigned, sobolDimensions> columnOf{4, 0, 1, 5, 6, 2, 3, 7, 8, 9};

/// Direction numbers, most significant bit first.
constexpr std::array<std::uint32_t, 32> directionNumbers(const Column& column) {
    std::array<std::uint32_t, 32> numbers{};
    for (unsigned i = 0; i < numbers.size(); ++i) {
        std::uint32_t m = 1;
        if (i < column.degree) {
            m = column.initial[i];
        } else if (column.degree > 0) {
            const auto before = [&](unsigned k) { return numbers[i - k] >> (31U - (i - k)); };
            m = before(column.degree) ^ (before(column.degree) << column.degree);
            for (unsigned k = 1; k < column.degree; ++k)
                if ((column.polynomial >> (column.degree - 1 - k) & 1U) != 0) m ^= before(k) << k;
        }
        numbers[i] = m << (31U - i);
    }
    return numbers;
}

/// What each byte of the index contributes, bits reversed as scrambling wants them.
using ByteTables = std::array<std::array<std::uint32_t, 256>, 4>;

std::array<ByteTables, sobolDimensions> makeTables() {
    std::array<ByteTables, sobolDimensions> tables{};
    for (std::size_t c = 0; c < columns.size(); ++c) {
        const auto numbers = directionNumbers(columns[c]);
        for (std::size_t byte = 0; byte < 4; ++byte)
            for (std::size_t value = 0; value < 256; ++value)
                for (std::size_t bit = 0; bit < 8; ++bit)
                    if ((value >> bit & 1U) != 0) tables[c][byte][value] ^= detail::reversed(numbers[8 * byte + bit]);
    }
    return tables;
}
const std::array<ByteTables, sobolDimensions> tables = makeTables();

std::uint32_t reversedBits(std::uint32_t index, unsigned column) {
    const ByteTables& t = tables[column];
    return t[0][index & 0xffU] ^ t[1][index >> 8U & 0xffU] ^ t[2][index >> 16U & 0xffU] ^ t[3][index >> 24U];
}

} // namespace

std::uint32_t sobolBits(std::uint32_t index, unsigned column) { return detail::reversed(reversedBits(index, column)); }

float Sobol::operator()(std::uint64_t index, unsigned dimension) const {
    const std::uint64_t block = mix(seed_ ^ mix(index >> 32U));
    auto within = static_cast<std::uint32_t>(index);
    unsigned column = 0;
    if (dimension < sobolDimensions) {
        column = columnOf[dimension];
    } else {
        // Three to a reflection: its direction and roulette are spread together.
        const unsigned group = (dimension - 5) / 3;
        column = (dimension - 5) % 3;
        within = detail::shuffled(within, block + group);
    }
    const auto key = static_cast<std::uint32_t>(mix(block ^ (std::uint64_t{dimension} << 32U)));
    return toUnit(detail::reversed(detail::scrambleReversed(reversedBits(within, column), key)));
}

} // namespace pie::sampling
