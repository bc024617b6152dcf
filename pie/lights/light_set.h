#pragma once
// All lights of a scene, and the choice between them for a photon. Light i of n gets photons in proportion to its
// power; which light and which point of its own sequence a photon index means is a pure function of the index.
//
// Halton dimension 0 picks the light from the cumulative power shares; dimensions 1 to 4 are used as they are. The
// photons of a light with share [a, b) are those with Φ2(index) in [a, b): cut at multiples of 2^-k, each piece is
// every 2^k-th index, and since 2^k has no factor 3, 5, 7 or 11, any b^j consecutive ones of those fall one into each
// of the b^j spans of every other dimension. So each light sees a well-distributed sequence of its own without a count
// per light, nothing is rescaled (the remap of selective photon tracing, 4.1, loses digits), and indices that differ by
// a multiple of 2^k0 3^k1 5^k2 … still follow similar paths from the same light (eq 5).
//
// A sky counts as one entry per direction and a polygon as one per triangle and side, so that dimension 0 chooses those
// as well.

#include "pie/lights/light.h"
#include "pie/sampling/sequence.h"

#include <memory>
#include <span>

namespace pie::lights {

class LightSet {
public:
    LightSet() = default;
    /// Lights without power, or with one that is not finite, stay in the list and emit nothing. Negative lights (the
    /// level compiler knows them) are chosen by their absolute power and send negative flux.
    LightSet(std::vector<Light> lights, std::shared_ptr<const scene::Scene> scene);

    [[nodiscard]] std::span<const Light> lights() const { return lights_; }
    [[nodiscard]] Rgb totalPower() const { return totalPower_; } ///< watts
    /// Watts of all lights together, largest channel of absolute values: the compiler's negative lights send as large
    /// photons as others.
    [[nodiscard]] double largestPower() const;
    [[nodiscard]] bool empty() const { return entries_.empty(); } ///< nothing to emit
    [[nodiscard]] const SkyPortals& portals() const { return portals_; }
    /// Photons of a muted light carry no flux; those of the others stay as they are, to the bit.
    void mute(std::uint32_t light);
    /// Mutes all lights but this one, which is muted no more: its part of what the whole set sends.
    void muteAllBut(std::uint32_t light);
    [[nodiscard]] bool muted(std::uint32_t light) const { return !muted_.empty() && muted_[light] != 0; }
    /// Light that photon `index` comes from and the ray it starts on. `flux` is the light's power over the probability
    /// of choosing it: divide by the number of photons emitted. Uses dimensions 0 (light) to 4. `light`, when
    /// given, receives its number in `lights()`. Not to be called when empty().
    [[nodiscard]] Emission emit(const sampling::Sequence& sequence, std::uint64_t index,
                                std::uint32_t* light = nullptr) const;
    /// The same for consecutive indices, out[i] for `first` + i, to the bit and cheaper.
    void emit(const sampling::Sequence& sequence, std::uint64_t first, std::span<Emission> out) const;
    static constexpr unsigned dimensions = 5;

private:
    enum class Part : std::uint8_t { Whole, Triangle, Direction };
    /// What dimension 0 chooses from.
    struct Entry {
        std::uint32_t light = 0;
        std::uint32_t number = 0; ///< Triangle: of `triangles_`; Direction: of the sky's
        Part part = Part::Whole;
        double scale = 0; ///< one over the probability of choosing it
    };
    /// Of an area light, moved off its surface to where rays start.
    struct Triangle {
        Vec3 corner{0.0F}, side1{0.0F}, side2{0.0F}, normal{0.0F};
        Rgb flux{0.0F}; ///< of its photons
    };
    void addPolygon(std::uint32_t light, const AreaLight& polygon);
    void add(const Entry& entry, const Rgb& watts);
    void finish();
    void emitFrom(const Entry& entry, const std::array<float, 4>& u, bool polar, Emission& out) const;
    [[nodiscard]] const Entry& choose(float u) const;

    std::vector<Light> lights_;
    std::vector<std::uint8_t> muted_; ///< by light; empty: none
    std::vector<Entry> entries_;
    std::vector<Triangle> triangles_;
    std::vector<double> cumulative_;   ///< of power shares per entry, ends with 1
    std::vector<std::uint32_t> guide_; ///< first entry that can be meant, by the leading bits of u
    std::shared_ptr<const scene::Scene> scene_;
    SkyPortals portals_;
    glm::dvec3 sum_{0.0}; ///< of the powers of the entries
    Rgb totalPower_{0.0F};
};

} // namespace pie::lights
