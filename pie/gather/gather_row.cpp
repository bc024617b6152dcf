#include "pie/gather/gather_row.h"

#include <algorithm>
#include <vector>

namespace pie::gather {
namespace {

/// Four channels at once.
using Lanes [[gnu::vector_size(16)]] = float;

Lanes lanes(const TexelLight::Radiosity& light) { return Lanes{light.r, light.g, light.b, light.unused}; }

} // namespace

std::uint32_t GatherRow::code(float rays) {
    const std::uint32_t rounded = (std::bit_cast<std::uint32_t>(rays) + (1U << (lostBits - 1U))) >> lostBits;
    constexpr std::uint32_t least = exponent >> lostBits;
    return rounded < least ? 0 : std::min(rounded - least, codeMask);
}

GatherRow::GatherRow(std::span<const Part> parts, std::uint32_t dark) {
    std::vector<std::uint32_t> singles;
    std::vector<std::uint32_t> heavy;
    float carried = 0;
    for (const Part& part : parts) {
        if (part.rays == 1.0F) {
            singles.push_back(part.number);
            continue;
        }
        float left = part.rays + carried;
        const auto write = [&](float rays) {
            heavy.push_back(part.number << weightBits | code(rays));
            left -= decoded(heavy.back());
        };
        while (left > mostRays) write(mostRays);
        if (left >= decoded(0) / 2) write(left);
        carried = left;
    }
    singles_ = static_cast<std::uint32_t>(singles.size());
    heavy_ = static_cast<std::uint32_t>(heavy.size());
    entries_ = std::make_shared<std::uint32_t[]>(singlePlaces() + heavyPlaces());
    std::uint32_t* const end = std::copy(singles.begin(), singles.end(), entries_.get());
    std::fill(end, entries_.get() + singlePlaces(), dark);
    std::copy(heavy.begin(), heavy.end(), entries_.get() + singlePlaces());
    if (heavyPlaces() > heavy_) entries_[singlePlaces() + heavy_] = dark << weightBits;
}

void GatherRow::pack(std::span<const std::uint32_t> which, std::span<GatherRow> rows) {
    std::size_t bytes = 0;
    for (const std::uint32_t i : which) bytes += rows[i].bytes();
    const auto all = std::make_shared<std::uint32_t[]>(bytes / sizeof(std::uint32_t));
    std::uint32_t* at = all.get();
    for (const std::uint32_t i : which) {
        GatherRow& row = rows[i];
        const std::size_t places = row.bytes() / sizeof(std::uint32_t);
        std::copy_n(row.entries_.get(), places, at);
        row.entries_ = {all, at};
        at += places;
    }
}

Rgb GatherRow::gathered(std::span<const TexelLight::Radiosity> radiosity, float each) const {
    // Several sums, so that an addition need not wait for the last.
    Lanes a{};
    Lanes b{};
    Lanes c{};
    Lanes d{};
    const std::uint32_t* entry = entries_.get();
    const std::uint32_t* const heavy = entry + singlePlaces();
    for (; entry != heavy; entry += 4) {
        a += lanes(radiosity[entry[0]]);
        b += lanes(radiosity[entry[1]]);
        c += lanes(radiosity[entry[2]]);
        d += lanes(radiosity[entry[3]]);
    }
    for (const std::uint32_t* const end = heavy + heavyPlaces(); entry != end; entry += 2) {
        a += decoded(entry[0]) * lanes(radiosity[entry[0] >> weightBits]);
        b += decoded(entry[1]) * lanes(radiosity[entry[1] >> weightBits]);
    }
    const Lanes sum = each * ((a + b) + (c + d));
    return {sum[0], sum[1], sum[2]};
}

} // namespace pie::gather
