#pragma once
// A photon as it is stored: one hit of a path.

#include "pie/core/vec.h"

#include <cstdint>

namespace pie::photons {

struct Photon {
    Vec3 position{0.0F};
    Vec3 direction{0.0F}; ///< in which it travelled (towards the surface), unit
    Rgb flux{0.0F};       ///< watts arriving, already divided by the number of photons emitted in its frame
    std::uint32_t triangle = 0;
    std::uint32_t id = 0;    ///< number within its batch in the order of tracing: breaks ties
    std::uint8_t bounce = 0; ///< 0: direct light
};

} // namespace pie::photons
