// How evenly directions of reflection are spread, by where their random numbers come from: the share of `count`
// cosine-distributed directions that fall into a cap of the hemisphere, against the cap's exact share. A cap may be a
// lamp seen from a wall. Root mean square over many caps and over frames, which are consecutive stretches of a
// sequence.
//
//   halton_bench [largest count]       prints CSV: sequence, count, error
//
// `random`: a generator, the square mapped to directions; `random_rejected`: points of the square outside the disc are
// drawn again. `halton`: dimensions 1 and 2, mapped; `halton_rejected`: the same with rejection. `deep_plain`: the
// radical inverses of the seventh reflection; `deep_permuted`: what Halton gives there.

#include "pie/sampling/directions.h"
#include "pie/sampling/halton.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace {

using pie::Vec2;
using pie::Vec3;

constexpr unsigned deep = 5 + 3 * 7; ///< direction of reflection 7
constexpr std::size_t capCount = 256;
constexpr std::size_t frames = 8;

using Directions = std::function<Vec3()>;
/// What gives the directions of a frame that starts at photon `first`.
using Sequence = std::function<Directions(std::uint64_t first)>;

struct Cap {
    Vec3 axis;
    float cosine = 1;
    double share = 0; ///< of all cosine-distributed directions
};

/// All of it above the horizon: there its projection is an ellipse, so its share is sin² of its half angle times the
/// cosine of its axis.
std::vector<Cap> makeCaps() {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit;
    std::vector<Cap> caps(capCount);
    for (Cap& cap : caps) {
        const double half = (5 + 40 * unit(random)) * std::numbers::pi / 180;
        const double turn = 2 * std::numbers::pi * unit(random);
        const double z = std::sin(half) + (1 - std::sin(half)) * unit(random);
        const double ring = std::sqrt(1 - z * z);
        cap = {Vec3(ring * std::cos(turn), ring * std::sin(turn), z), static_cast<float>(std::cos(half)),
               std::sin(half) * std::sin(half) * z};
    }
    return caps;
}

/// Draws until a point falls into the disc, and lifts it to the hemisphere.
Vec3 rejected(const std::function<Vec2()>& draw) {
    for (;;) {
        const Vec2 p = 2.0F * draw() - 1.0F;
        const float d = glm::dot(p, p);
        if (d <= 1.0F) return {p, std::sqrt(1.0F - d)};
    }
}

Directions generated(std::uint64_t first, bool reject) {
    auto draw = [random = std::mt19937(static_cast<unsigned>(first + 1))]() mutable {
        const auto u = static_cast<float>(random() >> 8U) * 0x1p-24F;
        return Vec2(u, static_cast<float>(random() >> 8U) * 0x1p-24F);
    };
    if (reject) return [draw]() mutable { return rejected(std::ref(draw)); };
    return [draw]() mutable { return pie::sampling::cosineHemisphere(draw()); };
}

Directions addressed(std::uint64_t first, unsigned dimension, bool reject) {
    static const pie::sampling::Halton halton;
    auto draw = [index = first, dimension]() mutable {
        const Vec2 u(halton(index, dimension), halton(index, dimension + 1));
        ++index;
        return u;
    };
    if (reject) return [draw]() mutable { return rejected(std::ref(draw)); };
    return [draw]() mutable { return pie::sampling::cosineHemisphere(draw()); };
}

Directions plain(std::uint64_t first) {
    return [index = first]() mutable {
        const Vec2 u(pie::sampling::radicalInverse(index, deep), pie::sampling::radicalInverse(index, deep + 1));
        ++index;
        return pie::sampling::cosineHemisphere(u);
    };
}

double error(const std::vector<Cap>& caps, const Sequence& sequence, std::size_t count) {
    double sum = 0;
    std::vector<Vec3> directions(count);
    for (std::size_t frame = 0; frame < frames; ++frame) {
        const Directions next = sequence(frame * count);
        for (Vec3& direction : directions) direction = next();
        for (const Cap& cap : caps) {
            std::size_t inside = 0;
            for (const Vec3& direction : directions) inside += glm::dot(direction, cap.axis) >= cap.cosine ? 1 : 0;
            const double off = static_cast<double>(inside) / static_cast<double>(count) - cap.share;
            sum += off * off;
        }
    }
    return std::sqrt(sum / static_cast<double>(frames * caps.size()));
}

} // namespace

int main(int argumentCount, char** arguments) {
    const std::size_t largest = argumentCount > 1 ? std::strtoull(arguments[1], nullptr, 10) : 1U << 16U;
    const std::vector<std::pair<std::string, Sequence>> sequences{
        {"random", [](std::uint64_t first) { return generated(first, false); }},
        {"random_rejected", [](std::uint64_t first) { return generated(first, true); }},
        {"halton", [](std::uint64_t first) { return addressed(first, 1, false); }},
        {"halton_rejected", [](std::uint64_t first) { return addressed(first, 1, true); }},
        {"deep_plain", [](std::uint64_t first) { return plain(first); }},
        {"deep_permuted", [](std::uint64_t first) { return addressed(first, deep, false); }},
    };
    const std::vector<Cap> caps = makeCaps();
    fmt::print("sequence,count,error\n");
    for (const auto& [name, sequence] : sequences)
        for (std::size_t count = 16; count <= largest; count *= 2)
            fmt::print("{},{},{:.6g}\n", name, count, error(caps, sequence, count));
    return 0;
}
