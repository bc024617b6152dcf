#pragma once
// Photons of one group of lights, summed into surface texels.
//
// Photons only add their flux to their texel. Sums are 64-bit integers in units of a fixed share of the lights' power:
// adding is exact whatever the order, so any number of threads give the same bits, and what is removed again leaves
// exactly zero behind, after any number of frames (floats drift).
//
// A frame may come in parts, of which it has sixteen; sums are worth as many frames as parts are in them. With
// `keepBatches` the sixteen are also kept apart: the spread between batches is the noise of whatever is made of the
// texels (standard errors).
//
// Protocol: add() and remove(), then update(); reads see the state of the last update(). One thread calls these at a
// time.

#include "pie/core/vec.h"
#include "pie/gather/texels.h"
#include "pie/photons/photon.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pie::gather {

/// Photons of some parts of a frame, in the order of their indices, with the texels they fell on: these are found once
/// for all sums that the photons go into. Each carries its share of a whole frame's light.
struct Fallen {
    std::span<const photons::Photon> photons;
    std::span<const std::uint32_t> texels; ///< SurfaceTexels::find of each
    unsigned parts = 16, firstPart = 0;
};
/// Which of them count. First hits are direct light.
enum class Hits : std::uint8_t { All, First, Later };

class PhotonSums {
public:
    static constexpr unsigned batches = 16; ///< and parts of a frame

    /// `power`: watts of the lights together, largest channel of absolute values; sets the unit of the sums, 2⁻³⁴ of
    /// it. `texels` must outlive it.
    PhotonSums(const SurfaceTexels& texels, double power, bool keepBatches);

    /// They count to the batches from number `firstPart` on, in turns. What is removed was added alike.
    void add(const Fallen& fallen, Hits hits = Hits::All);
    void remove(const Fallen& fallen, Hits hits = Hits::All);
    /// Takes photons out without taking parts out: of a light that sends nothing any more. Not with batches.
    void takeBack(const Fallen& fallen, Hits hits = Hits::All) { change(fallen, hits, -1); }
    /// Back to none, and to units of another power.
    void clear(double power);

    [[nodiscard]] std::int64_t parts() const { return parts_; } ///< in the sums
    /// Sums of the coarser levels.
    void update();

    /// Of a texel of level 0, watts per square unit.
    [[nodiscard]] Rgb irradiance(std::uint32_t texel, std::size_t level = 0) const;
    /// Of level 0 from one batch alone, as an estimate of the whole. Only with batches.
    [[nodiscard]] Rgb batchIrradiance(std::uint32_t texel, unsigned batch) const;
    /// Around texel `texel`, from the finest level that holds `enough` photons; `photons`, when given, receives their
    /// number.
    [[nodiscard]] Rgb broadIrradiance(std::uint32_t texel, std::uint32_t enough, std::int64_t* photons = nullptr) const;
    [[nodiscard]] std::int64_t photons(std::uint32_t texel) const { return sums_[0][texel][3]; }
    [[nodiscard]] bool keepsBatches() const { return !batchSums_.empty(); }
    /// True when no photon is left in any sum.
    [[nodiscard]] bool empty() const;
    [[nodiscard]] std::size_t bytes() const;

private:
    using Sum = std::array<std::int64_t, 4>; ///< red, green, blue; photons
    void change(const Fallen& fallen, Hits hits, std::int64_t sign);
    void setUnit(double power);
    [[nodiscard]] Rgb irradiance(const Sum& sum, const SurfaceTexels::Texel& texel, double frames) const;
    [[nodiscard]] double frames() const { return static_cast<double>(parts_) / batches; }

    const SurfaceTexels& texels_;
    double unit_ = 1; ///< watts
    std::int64_t parts_ = 0;
    std::vector<std::vector<Sum>> sums_; ///< by level; those past 0 are made by update()
    std::vector<Sum> batchSums_;         ///< texel · 16 + batch
};

} // namespace pie::gather
