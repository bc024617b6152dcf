#pragma once
// The few texels that most of the reflected light comes from: the ceiling above a lamp, the floor in the sun. Cosine
// rays meet them rarely and each time with much light, which is most of a gather's noise. So a share of a receiver's
// rays is aimed at them, as at lamps (virtual indirect lights), and both kinds are weighed against each other by the
// balance heuristic (multiple importance sampling, Veach 1997, ch. 9): right on the mean whatever texels are chosen.
//
// Chosen once, from where the photons of one frame reflect; immutable then, and safe from any thread.

#include "pie/core/vec.h"
#include "pie/gather/texels.h"
#include "pie/photons/photon.h"

#include <cstdint>
#include <span>
#include <vector>

namespace pie::gather {

class BrightTexels {
public:
    static constexpr float brighter = 4;         ///< than the mean of all surfaces
    static constexpr std::size_t most = 2048;    ///< those of most power
    static constexpr unsigned fewestPhotons = 4; ///< that a texel has been met by

    /// None.
    explicit BrightTexels(const SurfaceTexels& texels) : texels_(texels) {}
    /// `photons`: of one frame, first hits and later ones, in the order of their indices.
    void choose(std::span<const photons::Photon> photons);

    [[nodiscard]] bool empty() const { return lights_.empty(); }
    [[nodiscard]] std::size_t size() const { return lights_.size(); }
    [[nodiscard]] std::size_t bytes() const;

    /// How much each of them may bring to a receiver, were nothing in between. `sums[i]`: of the first i + 1. Returns
    /// the sum of all.
    float chances(const scene::Receiver& receiver, std::vector<float>& sums) const;
    /// Of one texel; 0 for what is not among them.
    [[nodiscard]] float chance(const scene::Receiver& receiver, std::uint32_t texel) const {
        const std::uint32_t number = place_.empty() ? SurfaceTexels::none : place_[texel];
        return number == SurfaceTexels::none ? 0.0F : chance(receiver, lights_[number]);
    }
    [[nodiscard]] std::uint32_t texel(std::size_t number) const { return lights_[number].texel; }

private:
    struct Light {
        Vec3 centre{0.0F};
        std::uint32_t texel = 0;
        Vec3 normal{0.0F};
        float area = 0;
        float power = 0; ///< reflected, any unit
    };
    [[nodiscard]] static float chance(const scene::Receiver& receiver, const Light& light);

    const SurfaceTexels& texels_;
    std::vector<Light> lights_;        ///< by texel
    std::vector<std::uint32_t> place_; ///< texel → lights_; empty: there are none
};

} // namespace pie::gather
