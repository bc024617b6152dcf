#include "pie/core/parallel.h"
#include "pie/gather/area.h"

#include <algorithm>
#include <cmath>

namespace pie::gather {
namespace {

constexpr float largestCode = 65535;

// Square roots are stored: small shares, which divide, keep their relative precision.
std::uint16_t encode(double share) {
    const double root = std::sqrt(std::clamp(share / static_cast<double>(AreaTable::largestShare), 0.0, 1.0));
    return static_cast<std::uint16_t>(std::lround(root * static_cast<double>(largestCode)));
}

float decode(std::uint16_t code) {
    const float root = static_cast<float>(code) * (1.0F / largestCode);
    return AreaTable::largestShare * root * root;
}

} // namespace

AreaTable::AreaTable(const TrueArea& area, const scene::Receivers& receivers) : area_(area), receivers_(receivers) {
    rowCount_ = receivers.points.size();
    for (std::size_t i = 0; i < receivers.points.size(); ++i) {
        if (!receivers.points[i].twoSided) continue;
        if (backRow_.empty()) backRow_.resize(receivers.points.size(), scene::noReceiver);
        backRow_[i] = static_cast<std::uint32_t>(rowCount_++);
    }
    rows_ = std::make_unique<Row[]>(rowCount_);
    state_ = std::make_unique<std::atomic<std::uint8_t>[]>(rowCount_);
}

std::size_t AreaTable::rowOf(std::uint32_t receiver, bool back) const { return back ? backRow_[receiver] : receiver; }

AreaTable::Row AreaTable::makeRow(std::uint32_t receiver, bool back) const {
    std::array<float, entries> radii{};
    std::array<double, entries> integrals{};
    for (std::size_t i = 0; i < entries; ++i)
        radii[i] = area_.maxRadius() * std::pow(range, static_cast<float>(i) / static_cast<float>(entries - 1) - 1.0F);
    const scene::Receiver& at = receivers_.points[receiver];
    area_.integrals(at.position, back ? -at.normal : at.normal, radii, integrals, area_.cellsSeenFrom(at));
    Row row{};
    for (std::size_t i = 0; i < entries; ++i) {
        const double disc =
            discIntegral(area_.kernel()) * static_cast<double>(radii[i]) * static_cast<double>(radii[i]);
        row[i] = disc > 0 ? encode(integrals[i] / disc) : std::uint16_t{0};
    }
    return row;
}

float AreaTable::share(std::uint32_t receiver, bool back, float radius) const {
    const std::size_t index = rowOf(receiver, back);
    Row made;
    const Row* row = &rows_[index];
    if (state_[index].load(std::memory_order_acquire) != 2) {
        made = makeRow(receiver, back);
        std::uint8_t empty = 0;
        if (state_[index].compare_exchange_strong(empty, 1, std::memory_order_relaxed)) {
            rows_[index] = made;
            state_[index].store(2, std::memory_order_release);
        }
        row = &made; // whoever else is writing writes the same
    }
    if (!(area_.maxRadius() > 0.0F)) return 0.0F;
    const float place =
        std::clamp(static_cast<float>(entries - 1) * (1.0F + std::log(radius / area_.maxRadius()) / std::log(range)),
                   0.0F, static_cast<float>(entries - 1));
    const auto i = std::min(static_cast<std::size_t>(place), entries - 2);
    const float part = place - static_cast<float>(i);
    return (1.0F - part) * decode((*row)[i]) + part * decode((*row)[i + 1]);
}

void AreaTable::prepare(std::span<const std::uint32_t> which) const {
    parallelChunks(which.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            (void)share(which[i], false, area_.maxRadius());
            if (receivers_.points[which[i]].twoSided) (void)share(which[i], true, area_.maxRadius());
        }
    });
}

std::size_t AreaTable::bytes() const {
    return rowCount_ * (sizeof(Row) + 1) + backRow_.capacity() * sizeof(std::uint32_t);
}

} // namespace pie::gather
