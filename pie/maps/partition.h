#pragma once
// How photons are divided among several maps (pi-engine 5.3.4): by the direction in which the surface they fell on
// faces (Larsen and Christensen 2003), by the cell of the level's visibility that they lie in, or by both; and which of
// these maps matter to a receiver. Made once for a scene, asked from any thread.
//
// Normals have 54 classes: the six faces of a cube, nine squares each, so that what lies along the axes, as most of a
// level does, is a class of its own. What a class holds is known exactly, as a box around the normals of its triangles,
// and so is whether it can hold one within a given angle of a receiver's normal, however near to the border of its
// class that is.
//
// Cells are VisibilityCells. A receiver sees those that its cluster may see, and nothing behind a wall.

#include "pie/maps/visibility_cells.h"
#include "pie/photons/photon.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <array>
#include <cstdint>
#include <vector>

namespace pie::maps {

enum class SplitBy : std::uint8_t { None, Normal, Cell, Both };

class Partition {
public:
    static constexpr std::size_t mostClasses = 54;

    /// Keeps references to both; `tree` may be empty: then there is one cell.
    Partition(const scene::Scene& scene, const level::Tree& tree, SplitBy by);
    [[nodiscard]] bool byNormal() const { return by_ == SplitBy::Normal || by_ == SplitBy::Both; }
    [[nodiscard]] std::size_t cells() const { return cells_.size(); }

    /// The map of a photon. Its position must be finite.
    struct Place {
        std::uint8_t cell = 0, normal = 0;
        friend bool operator==(const Place&, const Place&) = default;
    };
    [[nodiscard]] Place placeOf(const photons::Photon& photon) const;

    /// Maps that matter to a receiver, as sets of bits.
    struct Seen {
        std::uint64_t classes = ~std::uint64_t{0};
        VisibilityCells::Set cells = ~VisibilityCells::Set{0};
        /// Whatever is in these classes faces within the angle: no photon of them need be asked.
        bool allFace = false;

        [[nodiscard]] bool holds(const Place& place) const {
            return (classes >> place.normal & cells >> place.cell & 1U) != 0;
        }
    };
    /// Classes that can hold a normal whose cosine with the receiver's, or with its reverse where that is two-sided, is
    /// above `minCosine`; and cells that may be seen from it.
    [[nodiscard]] Seen seenFrom(const scene::Receiver& at, float minCosine) const;
    /// The second half of that.
    [[nodiscard]] VisibilityCells::Set cellsSeenFrom(const scene::Receiver& at) const;

    /// The pieces of a side of a triangle by cell.
    [[nodiscard]] std::vector<VisibilityCells::Piece> cut(std::uint32_t triangle, bool back) const;

    [[nodiscard]] std::size_t bytes() const;

private:
    void classify();
    [[nodiscard]] const Vec3& normalOf(std::uint32_t triangle) const { return scene_.normals[triangle]; }

    const scene::Scene& scene_;
    SplitBy by_;
    VisibilityCells cells_;
    float lift_; ///< units off the surface where its cell is looked up: surfaces lie in the planes that divide cells
    std::vector<std::array<std::uint8_t, 2>> classes_; ///< by triangle: of its front and of its back
    /// Per class, the least and the largest component of its normals, by axis; NaN where it has none.
    std::array<std::array<std::array<float, mostClasses>, 3>, 2> normals_;
};

} // namespace pie::maps
