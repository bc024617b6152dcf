#pragma once
// The Cornell box as published by its measurers (https://www.graphics.cornell.edu/online/box/data.html), in
// millimetres, front open, with a point light of 100 watts a channel below the ceiling: what accuracy is measured on. y
// is up.

#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace pie::test {

inline constexpr const char* cornellLight = "point 278 500 279.6 100 100 100"; ///< as after pieprobe --light
inline const Vec3 cornellLightPosition{278.0F, 500.0F, 279.6F};
inline constexpr float cornellWatts = 100;

/// Three materials: white .725 .71 .68, red .63 .065 .05, green .14 .45 .091; all surfaces face the light.
[[nodiscard]] scene::Scene cornellScene();
/// The same as text: cornell.obj, which names cornell.mtl. Returns the path of the first.
std::filesystem::path writeCornell(const std::filesystem::path& folder);

/// Points on all surfaces, in proportion to area; the same for the same seed.
[[nodiscard]] std::vector<scene::Receiver> cornellPoints(std::size_t count, unsigned seed = 1);
/// Vertices of the five walls cut into 10 × 10: those on edges (200, each wall's own, inset by a millimetre), and those
/// inside, without what the blocks stand on.
[[nodiscard]] std::vector<scene::Receiver> cornellEdgeVertices();
[[nodiscard]] std::vector<scene::Receiver> cornellInnerVertices();

/// As POINTS for pieprobe, to the last bit.
[[nodiscard]] std::string pointsCsv(const std::vector<scene::Receiver>& receivers);

} // namespace pie::test
