#pragma once
// The surface that exists: the integral of a kernel over the surfaces of the scene inside the search volume (a ball cut
// to a slice, pi-engine fig 3.8, or another: SearchVolume) and facing like the receiver. It replaces the π r² of the
// paper, which at an edge counts twice and in a corner four times the surface there is (boundary bias,
// pi-engine 3.5.2).
//
// TrueArea answers exactly, for one receiver and some radii: each triangle is clipped by the slice, then cut with the
// circle in which the ball meets its plane; sectors and triangles have closed forms (the straight parts of Cone and
// Gaussian: Gauss-Legendre, 8 points). AreaTable asks it once per receiver, when the receiver is first used, and
// interpolates from then on.
//
// Which photons belong to the surface that is counted is decided by `SurfaceTest`, in the same terms, so that flux and
// area always speak of the same surface. Two exceptions remain, both of which count surface that no photon reaches:
// coplanar triangles that overlap in part (exact duplicates are counted once), and surface hidden inside other
// geometry.
//
// Where photon maps are split by visibility cell, a receiver's photons are those of the cells it may see, and so is its
// surface: triangles are then cut into pieces by cell, once.

#include "pie/core/vec.h"
#include "pie/gather/kernel.h"
#include "pie/gather/search_volume.h"
#include "pie/maps/partition.h"
#include "pie/photons/photon.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace pie::gather {

struct SliceOptions {
    /// Units above and below the receiver's plane. Not a multiple of the grid level editors snap to, lest a surface lie
    /// in the border, where rounding decides. Thicker: more leaking between steps; thinner: fewer photons on curves.
    float halfThickness = 3.9F;
    /// Least cosine between the receiver's normal and that of the surface, 0 to 1. 0.7: a little more than 45 degrees.
    float minCosine = 0.7F;
};

/// The side of its surface a photon fell on: the triangle's normal, turned for light from behind two-sided surfaces.
[[nodiscard]] Vec3 litNormal(const scene::Scene& scene, const photons::Photon& photon);

/// Whether a photon lies on the surface an estimate counts. On one side of the receiver or, two-sided, on both.
struct SurfaceTest {
    enum class Side : std::uint8_t { None, Front, Back };
    const scene::Scene& scene;
    Vec3 point, normal;
    SliceOptions slice;
    bool twoSided = false;

    [[nodiscard]] Side operator()(const photons::Photon& photon) const {
        const float height = glm::dot(photon.position - point, normal);
        if (!(height <= slice.halfThickness && height >= -slice.halfThickness)) return Side::None;
        return facing(photon);
    }
    /// The same, however far the photon is from the receiver's plane.
    [[nodiscard]] Side facing(const photons::Photon& photon) const {
        const float cosine = glm::dot(litNormal(scene, photon), normal);
        if (cosine > slice.minCosine) return Side::Front;
        return twoSided && -cosine > slice.minCosine ? Side::Back : Side::None;
    }
};

class TrueArea {
public:
    /// Keeps a reference to `scene`. Radii asked for must not be larger than `maxRadius`, which is cut down to the
    /// diagonal of the scene. A Sphere is a Slice of infinite thickness. `partition`: how photons are divided among
    /// maps; null for one map.
    TrueArea(const scene::Scene& scene, Kernel kernel, const SliceOptions& slice, float maxRadius,
             SearchVolume volume = SearchVolume::Slice, std::shared_ptr<const maps::Partition> partition = nullptr);
    ~TrueArea();
    TrueArea(const TrueArea&) = delete;
    TrueArea& operator=(const TrueArea&) = delete;
    [[nodiscard]] SearchVolume volume() const { return volume_; }
    [[nodiscard]] float maxRadius() const { return maxRadius_; }
    [[nodiscard]] Kernel kernel() const { return kernel_; }
    [[nodiscard]] const SliceOptions& slice() const { return slice_; }

    using Cells = maps::VisibilityCells::Set;
    static constexpr Cells allCells = ~Cells{0};
    /// Those that the receiver may see; all where there is no partition.
    [[nodiscard]] Cells cellsSeenFrom(const scene::Receiver& at) const;
    /// integrals[i]: square units weighted by the kernel of radius radii[i], of the surfaces that face along `normal`
    /// and lie in one of `cells`.
    void integrals(const Vec3& point, const Vec3& normal, std::span<const float> radii, std::span<double> integrals,
                   Cells cells = allCells) const;
    [[nodiscard]] double integral(const Vec3& point, const Vec3& normal, float radius, Cells cells = allCells) const;
    [[nodiscard]] std::size_t bytes() const;

private:
    /// Of the grid.
    struct GridCells {
        std::array<std::uint32_t, 3> first{}, last{}; ///< inclusive
    };
    [[nodiscard]] GridCells cellsOf(const Box& box) const;
    template <class Visit> void forEachFacing(const Box& box, const Vec3& normal, const Visit& visit) const;
    [[nodiscard]] bool faces(std::uint32_t triangle, const Vec3& normal) const;
    /// Square of the largest distance from the receiver within the volume of this radius.
    [[nodiscard]] float extentSquared(float radius) const;

    struct Pieces;
    std::shared_ptr<const maps::Partition> partition_;
    std::unique_ptr<const Pieces> pieces_; ///< null: triangles are whole
    const scene::Scene& scene_;            ///< of the pieces, if there are any
    Kernel kernel_;
    SearchVolume volume_;
    SliceOptions slice_;
    float maxRadius_;
    // A uniform grid over the triangles that can store photons; a triangle is listed in every cell its box touches.
    float cellSize_ = 1;
    std::array<std::uint32_t, 3> counts_{1, 1, 1};
    std::vector<std::uint32_t> cellBegin_;
    std::vector<std::uint32_t> cellTriangles_;
    /// What is asked of every triangle near by, close together.
    struct Outline {
        Box box;
        Vec3 normal{0.0F};
        std::array<std::uint8_t, 3> firstCell{}; ///< of the grid
        std::uint8_t cell = 0;                   ///< of visibility
        bool twoSided = false;
    };
    std::vector<Outline> outlines_; ///< of all triangles of the scene
};

/// One short table per receiver (two for two-sided ones): the share of the whole disc that exists, by radius.
class AreaTable {
public:
    static constexpr std::size_t entries = 24;
    /// Radii reach from maxRadius / range to maxRadius in equal ratios; below, the share at the smallest is used.
    static constexpr float range = 64;
    /// Shares are stored in 16 bits, up to this; more (surfaces stacked inside the slice) is cut off.
    static constexpr float largestShare = 16;

    /// Keeps references to both.
    AreaTable(const TrueArea& area, const scene::Receivers& receivers);
    /// Share of the whole disc of this radius, 0 to largestShare: the kernel's integral over the surfaces is
    /// share · discIntegral(kernel) · radius². `back`: on the back of a two-sided receiver. From any thread.
    [[nodiscard]] float share(std::uint32_t receiver, bool back, float radius) const;
    /// Fills the tables of these receivers ahead of time, in parallel.
    void prepare(std::span<const std::uint32_t> which) const;
    [[nodiscard]] std::size_t bytes() const;

private:
    using Row = std::array<std::uint16_t, entries>;
    [[nodiscard]] Row makeRow(std::uint32_t receiver, bool back) const;
    [[nodiscard]] std::size_t rowOf(std::uint32_t receiver, bool back) const;

    const TrueArea& area_;
    const scene::Receivers& receivers_;
    std::vector<std::uint32_t> backRow_; ///< of two-sided receivers; empty when there are none
    std::size_t rowCount_ = 0;
    std::unique_ptr<Row[]> rows_;
    /// Per row: 0 not made, 1 being written by some thread, 2 ready.
    std::unique_ptr<std::atomic<std::uint8_t>[]> state_;
};

} // namespace pie::gather
