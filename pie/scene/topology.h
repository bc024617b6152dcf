#pragma once
// Which triangles meet in which edge, kept up to date while edges are split. An edge joins two positions, whatever the
// surface: splitting it splits every triangle that has it, so that neighbours stay matched. Not for use outside
// pie/scene.

#include "pie/scene/mesh.h"
#include "pie/scene/position_index.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace pie::scene {

class Topology {
public:
    static constexpr std::uint32_t none = FlatIndex::none;

    struct Edge {
        std::uint32_t a = 0, b = 0;  ///< positions, a < b
        std::uint32_t corner = none; ///< first of the corners that start this edge: 3 × triangle + i
        std::uint32_t count = 0;     ///< triangles that have it; 0: split, or given up
    };

    /// Takes the triangles of the mesh; those without area are dropped. The mesh must not be touched until finish().
    explicit Topology(Mesh& mesh);

    [[nodiscard]] std::size_t edgeCount() const { return edges_.size(); }
    [[nodiscard]] const Edge& edge(std::uint32_t e) const { return edges_[e]; }
    [[nodiscard]] std::span<const Vec3> positions() const { return positions_; }
    [[nodiscard]] std::size_t triangleCount() const { return mesh_.triangles.size() - dropped_; }
    [[nodiscard]] std::size_t vertexCount() const { return mesh_.vertices.size(); }
    [[nodiscard]] float squaredLength(std::uint32_t e) const;
    /// Calls use(t, i) for the triangles of the edge: corner i of Mesh::triangles[t] starts it.
    template <class Use> void forEachTriangle(std::uint32_t e, const Use& use) const {
        for (std::uint32_t corner = edges_[e].corner; corner != none; corner = next_[corner])
            use(corner / 3, corner % 3);
    }
    /// The edge that starts at corner i of triangle t.
    [[nodiscard]] std::uint32_t edgeOf(std::uint32_t t, std::uint32_t i) const { return cornerEdge_[3 * t + i]; }

    /// The edges that some triangle has, each once, surface by surface: who visits many edges does so place by place.
    [[nodiscard]] std::vector<std::uint32_t> edgesInOrder() const;

    /// The position in the middle of the edge, an existing one where there is one; none when the edge is so short that
    /// floats have no point there.
    [[nodiscard]] std::uint32_t middle(std::uint32_t e);
    /// Splits all triangles of the edge at `position`, whose attributes lie at `share` of the way from a to b. Edges
    /// made or met again are appended to `touched`, and where asked for, old ones that got other triangles to `beside`.
    /// Returns the number of triangles split.
    std::size_t split(std::uint32_t e, std::uint32_t position, float share, std::vector<std::uint32_t>& touched,
                      std::vector<std::uint32_t>* beside = nullptr);
    /// Drops the triangles that are flat to `tolerance`.
    void dropFlat(double tolerance);
    /// True when `position`, which lies `off` the edge, may end it: no triangle of the edge is turned over by that, and
    /// none is so thin that the position is its neighbour rather than a vertex on its edge.
    [[nodiscard]] bool splitsWell(std::uint32_t e, std::uint32_t position, double off) const;

    /// Hands the mesh back: dropped triangles leave, the rest are ordered by surface, older before newer.
    void finish();

private:
    /// The corner attributes that one split made, found again by the two attribute vertices they lie between.
    struct Made {
        std::uint32_t from = 0, to = 0, vertex = 0;
    };

    std::uint32_t edgeBetween(std::uint32_t p, std::uint32_t q);
    void link(std::uint32_t corner, std::uint32_t e);
    void unlink(std::uint32_t corner);
    void drop(std::uint32_t triangle);
    [[nodiscard]] std::vector<std::uint32_t> trianglesBySurface() const;
    std::uint32_t addVertex(std::uint32_t from, std::uint32_t to, float share, std::uint32_t position);
    std::uint32_t between(std::uint32_t from, std::uint32_t to, float share, std::uint32_t position);

    Mesh& mesh_;
    std::size_t dropped_ = 0;
    std::vector<Vec3> positions_;
    PositionIndex positionIndex_;
    std::vector<std::uint32_t> positionOf_; ///< Mesh::vertices → positions_
    std::vector<Edge> edges_;
    FlatIndex edgeIndex_;
    std::vector<std::uint32_t> cornerEdge_, next_, previous_; ///< per corner
    std::vector<Made> made_;
    FlatIndex madeIndex_;
};

} // namespace pie::scene
