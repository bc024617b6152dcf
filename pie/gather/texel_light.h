#pragma once
// Light on surface texels: photons summed up, and direct light by shadow rays.
//
// Photons of lights that may change any moment are summed apart from the others, their first hits apart from later
// ones: what such a light does is renewed every few frames, and the rest stands. A scene without such lights has no
// such sums.
//
// Protocol: add() and remove() photons, direct() for the texels whose direct light is wanted, then update(); reads see
// the state of the last update(). One thread calls these at a time.

#include "pie/core/vec.h"
#include "pie/gather/direct.h"
#include "pie/gather/photon_sums.h"
#include "pie/gather/texels.h"
#include "pie/photons/photon.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace pie::gather {

class TexelLight {
public:
    static constexpr unsigned batches = PhotonSums::batches;

    /// `power` as PhotonSums has it. `direct` answers for texels.points(), or is null: then direct light has to come
    /// from photons. References must outlive it.
    TexelLight(const SurfaceTexels& texels, double power, const DirectLight* direct, bool keepBatches);

    /// A frame of photons of the lights that stand still. Where they fell is found here; still() takes them found.
    void add(std::span<const photons::Photon> photons);
    void remove(std::span<const photons::Photon> photons);
    [[nodiscard]] PhotonSums& still() { return still_; }
    [[nodiscard]] const PhotonSums& still() const { return still_; }

    /// Of lights that may change. First hits are direct light.
    struct Changing {
        PhotonSums first, later;
    };
    /// Makes empty sums on the first call.
    [[nodiscard]] Changing& changing(double power);
    [[nodiscard]] const Changing* changing() const { return changing_.get(); }

    /// Computes the direct light of these texels where that was not done yet, in parallel. Returns how many were new.
    std::size_t direct(std::span<const std::uint32_t> texels);
    [[nodiscard]] bool hasDirect(std::uint32_t texel) const { return directKnown_.empty() || directKnown_[texel] != 0; }
    /// Makes radiosities from sums.
    void update();

    /// Irradiance times reflectance of a texel, direct and indirect, watts per square unit.
    struct alignas(16) Radiosity {
        float r = 0, g = 0, b = 0, unused = 0;
    };
    [[nodiscard]] std::span<const Radiosity> radiosity() const { return radiosity_; }
    /// Of one level of the texels, coarser than 0.
    [[nodiscard]] std::vector<Radiosity> coarseRadiosity(std::size_t level) const;
    /// Photons' part of the radiosity from one batch alone, as an estimate of the whole. Only with batches.
    [[nodiscard]] std::vector<Radiosity> batchRadiosity(unsigned batch) const;
    /// Irradiance from photons around texel `texel`, see PhotonSums, without first hits of lights that may change.
    [[nodiscard]] Rgb broadIrradiance(std::uint32_t texel, std::uint32_t enough, std::int64_t* photons = nullptr) const;
    /// Those first hits.
    [[nodiscard]] Rgb broadFirst(std::uint32_t texel, std::uint32_t enough) const;
    /// Takes the direct light of all known texels from `direct` once more, whose lights have changed.
    void renewDirect();
    /// Direct light of the texel, or, while that is not known, of the known ones around it.
    [[nodiscard]] Rgb broadDirect(std::uint32_t texel) const;
    [[nodiscard]] Rgb directIrradiance(std::uint32_t texel) const {
        return direct_.empty() ? Rgb(0.0F) : direct_[texel];
    }
    /// Standard error of a texel's direct radiosity, mean over the channels: from the pairs of its points.
    [[nodiscard]] float directError(std::uint32_t texel) const {
        return directError_.empty() ? 0.0F : directError_[texel];
    }
    [[nodiscard]] std::uint32_t photons(std::uint32_t texel) const;
    [[nodiscard]] std::size_t bytes() const;

private:
    void sumDirect();
    void takeDirect(std::span<const std::uint32_t> texels);

    const SurfaceTexels& texels_;
    const DirectLight* directLight_;
    PhotonSums still_;
    std::unique_ptr<Changing> changing_;
    std::vector<Radiosity> radiosity_;
    std::vector<Rgb> direct_;
    std::vector<float> directError_;
    std::vector<std::uint8_t> directKnown_;
    /// By level from 1: what is known of direct light, summed over area (r, g, b; area). Made by update().
    std::vector<std::vector<glm::vec4>> directSums_;
    bool directChanged_ = false;
};

} // namespace pie::gather
