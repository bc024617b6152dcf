#pragma once
// Receivers: the points where irradiance is wanted. Vertices of the refined mesh with equal position and normal are one
// receiver: that is the paper's estimate cache (5.4.2) by index instead of by search.

#include "pie/core/vec.h"
#include "pie/scene/mesh.h"

#include <cstdint>
#include <vector>

namespace pie::scene {

struct Receiver {
    Vec3 position{0.0F};
    Vec3 normal{0.0F}; ///< unit, towards the lit side
    /// Where rays start: inset by up to one unit along the surface, away from its borders, because a level's vertex
    /// lies exactly on its neighbours' planes; offset off the surface is left to whoever traces.
    Vec3 inset{0.0F};
    bool twoSided = false; ///< of a two-sided surface: light from both sides counts, as in the level compiler
};

struct Receivers {
    std::vector<Receiver> points;
    std::vector<std::uint32_t>
        ofVertex; ///< Mesh::vertices → points; noReceiver for vertices of surfaces that are not lit
};
inline constexpr std::uint32_t noReceiver = 0xffffffffU;

[[nodiscard]] Receivers makeReceivers(const Mesh& mesh, const level::Level& level);

} // namespace pie::scene
