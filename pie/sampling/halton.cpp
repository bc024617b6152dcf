#include "pie/sampling/halton.h"

#include <algorithm>
#include <mutex>
#include <numeric>
#include <utility>
#include <vector>

namespace pie::sampling {
namespace {

constexpr unsigned plainDimensions = 6;      // of seed 0
constexpr std::uint32_t maxBlockSize = 1024; // 8 KB a table: the one that consecutive indices walk through stays in L1

constexpr std::array<std::uint32_t, haltonDimensions> makePrimes() {
    std::array<std::uint32_t, haltonDimensions> primes{};
    std::size_t found = 0;
    for (std::uint32_t candidate = 2; found < primes.size(); ++candidate) {
        bool prime = true;
        for (std::size_t i = 0; i < found && primes[i] * primes[i] <= candidate; ++i)
            prime &= candidate % primes[i] != 0;
        if (prime) primes[found++] = candidate;
    }
    return primes;
}
constexpr auto primes = makePrimes();

constexpr std::uint64_t address(std::uint64_t seed, unsigned dimension, unsigned digit) {
    return mix(mix(mix(seed) ^ dimension) ^ digit);
}

/// The permutation of one digit position (Fisher-Yates); the identity where the plain sequence is wanted.
std::vector<std::uint32_t> digitPermutation(std::uint64_t seed, unsigned dimension, unsigned digit) {
    std::vector<std::uint32_t> permutation(primes[dimension]);
    std::iota(permutation.begin(), permutation.end(), 0U);
    if (seed == 0 && dimension < plainDimensions) return permutation;
    std::uint64_t state = address(seed, dimension, digit);
    for (auto left = static_cast<std::uint32_t>(permutation.size()); left > 1; --left) {
        state = mix(state);
        std::swap(permutation[left - 1], permutation[state % left]);
    }
    return permutation;
}

} // namespace

namespace detail {

struct HaltonTables {
    static constexpr std::size_t expectedValues = 240'000;
    std::array<HaltonRow, haltonDimensions> rows;
    std::vector<double> values;

    explicit HaltonTables(std::uint64_t seed) {
        std::vector<std::size_t> starts;
        values.reserve(expectedValues);
        for (unsigned dimension = 0; dimension < haltonDimensions; ++dimension) {
            starts.push_back(values.size());
            build(rows[dimension], seed, dimension);
        }
        for (std::size_t i = 0; i < rows.size(); ++i) rows[i].values = values.data() + starts[i];
    }

private:
    void build(HaltonRow& row, std::uint64_t seed, unsigned dimension) {
        const std::uint32_t base = primes[dimension];
        std::uint32_t digits = 1;
        row.size = base;
        while (row.size * base <= maxBlockSize) {
            row.size *= base;
            ++digits;
        }
        row.magic = ~std::uint64_t{0} / row.size + 1;
        double place = 1.0;
        for (std::uint64_t reach = 1; (reach >> 32U) == 0; reach *= row.size, ++row.blocks) {
            const std::size_t first = values.size();
            values.resize(first + row.size, 0.0);
            std::size_t stride = 1;
            for (std::uint32_t digit = 0; digit < digits; ++digit, stride *= base) {
                place /= base;
                const auto permutation = digitPermutation(seed, dimension, row.blocks * digits + digit);
                for (std::size_t i = 0; i < row.size; ++i) values[first + i] += permutation[i / stride % base] * place;
            }
        }
        for (std::size_t block = row.blocks; block-- > 0;)
            row.tail[block] = row.tail[block + 1] + values[values.size() - (row.blocks - block) * row.size];
    }
};

} // namespace detail

namespace {

/// Tables of the seeds used last, so that short-lived Halton objects of one seed do not build them again and again.
std::shared_ptr<const detail::HaltonTables> tablesOf(std::uint64_t seed) {
    constexpr std::size_t remembered = 4;
    using Known = std::vector<std::pair<std::uint64_t, std::shared_ptr<const detail::HaltonTables>>>;
    static std::mutex mutex;
    // Never taken down: a level may still be on its way to the light in another thread when the program ends.
    static Known& known = *std::make_unique<Known>().release(); // latest last
    const std::lock_guard lock(mutex);
    const auto found = std::find_if(known.begin(), known.end(), [&](const auto& entry) { return entry.first == seed; });
    if (found != known.end()) {
        std::rotate(found, found + 1, known.end());
        return known.back().second;
    }
    if (known.size() == remembered) known.erase(known.begin());
    known.emplace_back(seed, std::make_shared<const detail::HaltonTables>(seed));
    return known.back().second;
}

} // namespace

std::uint32_t haltonBase(unsigned dimension) { return primes[dimension % haltonDimensions]; }

float radicalInverse(std::uint64_t index, unsigned dimension) {
    const std::uint32_t base = haltonBase(dimension);
    double sum = 0.0;
    for (double place = 1.0; index != 0; index /= base) {
        place /= base;
        sum += static_cast<double>(index % base) * place;
    }
    return std::min(static_cast<float>(sum), belowOne);
}

Halton::Halton(std::uint64_t seed) : seed_(seed), tables_(tablesOf(seed)), rows_(tables_->rows.data()) {}

float Halton::beyond(std::uint64_t index, unsigned dimension) const {
    // Rare (paths of more than 40 bounces), so no tables: digits go through d → (a d + c) mod b, a permutation because
    // b is prime.
    const std::uint32_t base = haltonBase(dimension);
    double sum = 0.0;
    double place = 1.0;
    for (unsigned digit = 0; place > 0x1p-33; ++digit, index /= base) {
        const std::uint64_t random = address(seed_, dimension, digit);
        const std::uint64_t factor = 1 + (random >> 32U) % (base - 1);
        place /= base;
        sum += static_cast<double>((factor * (index % base) + (random & 0xffffffffU)) % base) * place;
    }
    return std::min(static_cast<float>(sum), belowOne);
}

} // namespace pie::sampling
