#pragma once
// All lights of a scene, and the choice between them for a photon. Light i of n gets photons in proportion to its
// power; which light and which point of its own Halton sequence a photon index means is a pure function of the index.

#include "pie/lights/light.h"
#include "pie/sampling/halton.h"

#include <memory>
#include <span>

namespace pie::lights {

class LightSet {
public:
    LightSet() = default;
    LightSet(std::vector<Light> lights, std::shared_ptr<const scene::Scene> scene);

    [[nodiscard]] std::span<const Light> lights() const { return lights_; }
    [[nodiscard]] Rgb totalPower() const { return totalPower_; } ///< watts
    [[nodiscard]] bool empty() const { return meanChannel(totalPower_) <= 0.0F; }
    [[nodiscard]] const SkyPortals& portals() const { return portals_; }
    /// Light that photon `index` comes from and the ray it starts on. `flux` is the light's power over the probability
    /// of choosing it: divide by the number of photons emitted. Uses Halton dimensions 0 (light) to 4.
    [[nodiscard]] Emission emit(const sampling::Halton& halton, std::uint64_t index) const;
    static constexpr unsigned dimensions = 5;

private:
    std::vector<Light> lights_;
    std::vector<double> cumulative_; ///< of power shares, ends with 1
    std::shared_ptr<const scene::Scene> scene_;
    SkyPortals portals_;
    Rgb totalPower_{0.0F};
};

} // namespace pie::lights
