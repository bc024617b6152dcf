#pragma once
// Surface texels: the surfaces of a scene cut into small pieces that photons are summed into. A texel is what lies in
// one cell of a cubic grid and faces along one of the six axes (the dominant axis of its normal, and its sign), with
// the area that is really there. No parameterisation, no atlas, no seams: every point of every surface has a texel.
//
// A cell that holds little surface (less than `mergeBelow` of a face of the cell) joins a neighbour that lies in the
// same plane, so that no texel has next to no area to divide by.
//
// Coarser levels join eight cells into one, level after level: where photons are few, a coarser texel has enough.
// Level 0 is the finest. Immutable; safe from any thread.
//
// Combines the surface maps of selective photon tracing and of photon map gathering on the GPU (texels of an atlas)
// with the area that exists.

#include "pie/core/vec.h"
#include "pie/photons/photon.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace pie::gather {

struct TexelOptions {
    /// Edge of a cell, units. 0: chosen from the scene, see SurfaceTexels::automaticEdge. Smaller: sharper and noisier.
    float edge = 0;
    /// Points on every texel where direct light is taken, 2 to 64, even: two independent ones in each part of it.
    unsigned points = 4;
    std::size_t maxTexels = 4'000'000; ///< the edge is doubled until they are not more
};

class SurfaceTexels {
public:
    static constexpr std::uint32_t none = 0xffffffffU;
    static constexpr float mergeBelow = 0.3F; ///< of edge²

    explicit SurfaceTexels(const scene::Scene& scene, const TexelOptions& options = {});
    ~SurfaceTexels();
    SurfaceTexels(const SurfaceTexels&) = delete;
    SurfaceTexels& operator=(const SurfaceTexels&) = delete;

    /// An edge with which a scene has some thousand texels, at most 64 units where it is as large as a level.
    [[nodiscard]] static float automaticEdge(const scene::Scene& scene);

    struct Texel {
        float area = 0; ///< square units, more than 0
        Vec3 centre{0.0F};
        Rgb reflectance{0.0F}; ///< mean over its area
        /// Share of its area that stops light: 1 but for filter surfaces (grates, leaves), at least 1/16.
        float coverage = 1;
        std::uint32_t parent = none; ///< texel of the next level
    };
    [[nodiscard]] std::size_t levels() const { return levels_.size(); }
    [[nodiscard]] std::span<const Texel> texels(std::size_t level = 0) const { return levels_[level]; }
    [[nodiscard]] float edge(std::size_t level = 0) const { return edge_ * static_cast<float>(1U << level); }

    /// Texel of level 0 at a point of a triangle, on its back when `back` is set; none where the triangle keeps no
    /// light (sky, the back of what is one-sided).
    [[nodiscard]] std::uint32_t find(std::uint32_t triangle, bool back, const Vec3& point) const;
    /// The same by where a photon fell.
    [[nodiscard]] std::uint32_t find(const photons::Photon& photon) const;
    /// The same for many, in parallel; `found` becomes as long.
    void find(std::span<const photons::Photon> photons, std::vector<std::uint32_t>& found) const;
    /// The texel nearest to a point among those of its cell and the cells around that face along `normal`; none where
    /// there is no surface.
    [[nodiscard]] std::uint32_t near(const Vec3& point, const Vec3& normal) const;

    /// Points spread over texel t: numbers t · pointsPerTexel() and following of `points().points`.
    [[nodiscard]] const scene::Receivers& points() const { return points_; }
    [[nodiscard]] unsigned pointsPerTexel() const { return pointsPerTexel_; }
    [[nodiscard]] std::size_t bytes() const;

private:
    struct Index;
    const scene::Scene& scene_;
    float edge_ = 1;
    unsigned pointsPerTexel_ = 4;
    std::vector<std::vector<Texel>> levels_;
    scene::Receivers points_;
    std::unique_ptr<Index> index_;
};

} // namespace pie::gather
