#include "pie/sampling/random.h"

#include <cmath>

namespace pie::sampling {
namespace {
constexpr std::uint64_t maxAttempts = 64;
}

Vec3 Rejection::sphere(std::uint64_t index, unsigned dimension) const {
    for (std::uint64_t attempt = 0; attempt < maxAttempts; ++attempt) {
        // 21 bits a coordinate, in the middle of their cells.
        const std::uint64_t b = bits(index, dimension, 0, attempt);
        const auto coordinate = [&](unsigned shift) {
            return (static_cast<float>(b >> shift & 0x1fffffU) + 0.5F) * 0x1p-20F - 1.0F;
        };
        const Vec3 p(coordinate(0), coordinate(21), coordinate(42));
        const float square = glm::dot(p, p);
        if (square <= 1.0F) return p / std::sqrt(square);
    }
    return {0.0F, 0.0F, 1.0F};
}

Vec3 Rejection::lifted(std::uint64_t index, unsigned dimension, std::uint64_t child) const {
    for (std::uint64_t attempt = 0; attempt < maxAttempts; ++attempt) {
        const Vec2 p = 2.0F * unitSquare(bits(index, dimension, child, attempt)) - 1.0F;
        const float square = glm::dot(p, p);
        if (square < 1.0F) return {p, std::sqrt(1.0F - square)};
    }
    return {0.0F, 0.0F, 1.0F};
}

} // namespace pie::sampling
