#include "pie/sampling/framed.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pie::sampling {
namespace {

constexpr double turnsPerRing = 3.0; // strata of a ring over rings: near the equator a stratum is about as high as wide

float below(double x) { return std::min(static_cast<float>(x), belowOne); }

/// Stratum `number` of `count`, and where in it.
Vec2 inStratum(std::uint64_t number, std::uint64_t count, const Vec2& jitter) {
    const auto rings = std::max<std::uint64_t>(
        1, static_cast<std::uint64_t>(std::lround(std::sqrt(static_cast<double>(count) / turnsPerRing))));
    const std::uint64_t narrow = count / rings;
    const std::uint64_t wideOnes = count % rings; // rings of narrow + 1 strata, the first ones
    const std::uint64_t inWide = wideOnes * (narrow + 1);
    const bool wide = number < inWide;
    const std::uint64_t strata = wide ? narrow + 1 : narrow;
    const std::uint64_t first = wide ? number / strata * strata : inWide + (number - inWide) / strata * strata;
    const auto n = static_cast<double>(count);
    return {below((static_cast<double>(first) + static_cast<double>(jitter.x) * static_cast<double>(strata)) / n),
            below((static_cast<double>(number - first) + static_cast<double>(jitter.y)) / static_cast<double>(strata))};
}

Vec2 unitSquare(std::uint64_t bits) { return {toUnit(bits), toUnit(static_cast<std::uint32_t>(bits))}; }

} // namespace

Framed::Framed(std::uint64_t seed, std::uint64_t pointsPerFrame)
    : seed_(mix(seed)), count_(std::max<std::uint64_t>(1, pointsPerFrame)),
      golden_(static_cast<std::uint64_t>(0.6180339887498949 * static_cast<double>(count_))) {
    golden_ = std::max<std::uint64_t>(1, golden_);
    while (std::gcd(golden_, count_) != 1) ++golden_;
}

Framed::Place Framed::place(std::uint64_t index, unsigned dimension) const {
    const std::uint64_t frame = index / count_;
    const std::uint64_t number = index - frame * count_;
    const std::uint64_t key = mix(mix(seed_ + frame) ^ dimension);
    if (dimension > 1) return {permuted(number, count_, key), key};
    __extension__ using Wide = unsigned __int128;
    const Wide step = dimension == 0 ? 1 : golden_;
    return {static_cast<std::uint64_t>((step * number + key % count_) % count_), key};
}

float Stratified::operator()(std::uint64_t index, unsigned dimension) const {
    const Place p = place(index, dimension);
    return below((static_cast<double>(p.point) + static_cast<double>(hash01(p.key, p.point))) /
                 static_cast<double>(pointsPerFrame()));
}
Vec2 Stratified::pair(std::uint64_t index, unsigned dimension) const {
    const Place p = place(index, dimension);
    return child(p.key, p.point, pointsPerFrame());
}
Vec2 Stratified::child(std::uint64_t key, std::uint64_t child, std::uint64_t count) const {
    return inStratum(child, count, unitSquare(mix(mix(key) ^ child)));
}

Spiral::Spiral(std::uint64_t seed, std::uint64_t pointsPerFrame, std::uint64_t children)
    : Framed(seed, pointsPerFrame), frame_(turnsOf(this->pointsPerFrame())), children_(turnsOf(children)) {}

std::shared_ptr<const Spiral::Turns> Spiral::turnsOf(std::uint64_t count) {
    auto turns = std::make_shared<Turns>();
    turns->reserve(count);
    const auto n = static_cast<double>(count);
    double turn = 0.0;
    for (std::uint64_t k = 0; k < count; ++k) {
        const double height = 1.0 - 2.0 * (static_cast<double>(k) + 0.5) / n;
        if (k > 0) turn += 3.6 / std::sqrt(n * (1.0 - height * height)) / (2.0 * 3.141592653589793);
        turn -= std::floor(turn);
        turns->push_back(below(turn));
    }
    return turns;
}

Vec2 Spiral::point(const Turns& turns, std::uint64_t number, std::uint64_t key) {
    const Vec2 move = unitSquare(mix(key));
    const double turn = static_cast<double>(turns[number]) + static_cast<double>(move.y);
    return {below((static_cast<double>(number) + static_cast<double>(move.x)) / static_cast<double>(turns.size())),
            below(turn - std::floor(turn))};
}

float Spiral::operator()(std::uint64_t index, unsigned dimension) const {
    const Place p = place(index, dimension);
    return below((static_cast<double>(p.point) + static_cast<double>(hash01(p.key, 0))) /
                 static_cast<double>(pointsPerFrame()));
}
Vec2 Spiral::pair(std::uint64_t index, unsigned dimension) const {
    const Place p = place(index, dimension);
    return point(*frame_, p.point, p.key);
}
Vec2 Spiral::child(std::uint64_t key, std::uint64_t child, std::uint64_t count) const {
    // Past the bound on branches a hit has one child.
    return count == children_->size() ? point(*children_, child, key) : unitSquare(mix(mix(key) ^ child));
}

} // namespace pie::sampling
