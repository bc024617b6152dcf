#pragma once
// Light on surface texels: photons summed up, and direct light by shadow rays.
//
// Photons only add their flux to their texel. Sums are 64-bit integers in units of a fixed share of the scene's power:
// adding is exact whatever the order, so any number of threads give the same bits, and what is removed again leaves
// exactly zero behind, after any number of frames (floats drift).
//
// Protocol: add() and remove() photons, direct() for the texels whose direct light is wanted, then update(); reads see
// the state of the last update(). One thread calls these at a time.
//
// With `batches`, the same sums are kept for 16 batches of photons, apart: the spread between batches is the noise of
// whatever is made of the texels (standard errors).

#include "pie/core/vec.h"
#include "pie/gather/direct.h"
#include "pie/gather/texels.h"
#include "pie/photons/photon.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pie::gather {

class TexelLight {
public:
    static constexpr unsigned batches = 16;

    /// `power`: watts of all lights together, largest channel of absolute values; sets the unit of the sums, 2⁻³⁴ of
    /// it. `direct` answers for texels.points(), or is null: then direct light has to come from photons. References
    /// must outlive it.
    TexelLight(const SurfaceTexels& texels, double power, const DirectLight* direct, bool keepBatches);

    /// Photon i of n counts to batch 16 i / n. Each carries its share of one frame's light.
    void add(std::span<const photons::Photon> photons) { change(photons, 1); }
    void remove(std::span<const photons::Photon> photons) { change(photons, -1); }
    /// Frames whose photons are in the sums.
    [[nodiscard]] std::int64_t frames() const { return frames_; }
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
    /// Irradiance from photons around texel `texel`, from the finest level that holds `enough` photons;
    /// `photons`, when given, receives their number.
    [[nodiscard]] Rgb broadIrradiance(std::uint32_t texel, std::uint32_t enough, std::int64_t* photons = nullptr) const;
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
    /// True when no photon is left in any sum.
    [[nodiscard]] bool empty() const;
    [[nodiscard]] std::size_t bytes() const;

private:
    using Sum = std::array<std::int64_t, 4>; ///< red, green, blue; photons
    void sumDirect();
    void change(std::span<const photons::Photon> photons, std::int64_t sign);
    [[nodiscard]] Rgb irradiance(const Sum& sum, const SurfaceTexels::Texel& texel, double scale) const;

    const SurfaceTexels& texels_;
    const DirectLight* directLight_;
    double unit_ = 1; ///< watts
    std::int64_t frames_ = 0;
    std::vector<std::vector<Sum>> sums_; ///< by level; those past 0 are made by update()
    std::vector<Sum> batchSums_;         ///< texel · 16 + batch
    std::vector<Radiosity> radiosity_;
    std::vector<Rgb> direct_;
    std::vector<float> directError_;
    std::vector<std::uint8_t> directKnown_;
    /// By level from 1: what is known of direct light, summed over area (r, g, b; area). Made by update().
    std::vector<std::vector<glm::vec4>> directSums_;
    bool directChanged_ = false;
};

} // namespace pie::gather
