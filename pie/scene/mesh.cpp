#include "pie/scene/mesh.h"

#include "pie/core/parallel.h"
#include "pie/scene/geometry.h"
#include "pie/scene/point_grid.h"
#include "pie/scene/topology.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

namespace pie::scene {
namespace {

bool drawn(const level::Level& level, const level::Surface& surface) {
    if (surface.shader >= level.shaders.size()) return false;
    if (!level.shaders[surface.shader].drawn()) return false;
    return surface.model >= level.models.size() || level.models[surface.model].drawn;
}

/// A position in the interior of an edge.
struct Junction {
    std::uint32_t position = Topology::none;
    float share = 0; ///< of the way from a to b
};

/// The junction nearest to the middle of the edge, so that the pieces come out even.
Junction findJunction(const Topology& topology, std::uint32_t e, const PointGrids& grids, double tolerance) {
    Junction found;
    const Topology::Edge& edge = topology.edge(e);
    if (edge.count == 0) return found;
    const Vec3 a = topology.positions()[edge.a];
    const Vec3 b = topology.positions()[edge.b];
    const glm::dvec3 along = glm::dvec3(b) - glm::dvec3(a);
    const double length = glm::length(along);
    if (!(length > 0) || !std::isfinite(length)) return found;
    const double radius = reachOf(length, tolerance);
    const double end = radius / length;
    const double perSquared = 1.0 / (length * length);
    double best = std::numeric_limits<double>::infinity();
    grids.forLength(length).nearSegment(a, b, radius, [&](const PointGrid::Entry& entry) {
        const glm::dvec3 d = glm::dvec3(entry.position) - glm::dvec3(a);
        const double t = glm::dot(d, along) * perSquared;
        if (!(t > end && t < 1.0 - end)) return;
        const glm::dvec3 away = d - t * along;
        if (glm::dot(away, away) >= radius * radius) return;
        const double off = glm::length(away);
        const double fromMiddle = std::abs(t - 0.5);
        if (fromMiddle > best || (fromMiddle == best && entry.point >= found.position)) return;
        if (!topology.splitsWell(e, entry.point, off)) return;
        best = fromMiddle;
        found = {entry.point, static_cast<float>(t)};
    });
    return found;
}

double meanLength(const Topology& topology, std::span<const std::uint32_t> edges) {
    double sum = 0;
    for (const std::uint32_t e : edges) sum += std::sqrt(topology.squaredLength(e));
    return edges.empty() ? 1.0 : sum / static_cast<double>(edges.size());
}

/// Slivers no wider than the rounding of positions would keep the vertices beside them from being closed.
void dropNoise(Topology& topology, double tolerance) {
    if (tolerance > 0) topology.dropFlat(tolerance / 8);
}

/// Closing makes no new positions: every split ends an edge at a point that was there before. That comes to an end in
/// any mesh of surfaces; the bound is for heaps of triangles that are not one.
std::size_t close(Topology& topology, double tolerance, std::size_t maxTriangles) {
    if (!(tolerance > 0)) return 0;
    const std::vector<std::uint32_t> edges = topology.edgesInOrder();
    const PointGrids grids(topology.positions(), meanLength(topology, edges));
    std::vector<Junction> junctions(edges.size());
    parallelChunks(edges.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) junctions[i] = findJunction(topology, edges[i], grids, tolerance);
    });
    std::size_t closed = 0;
    const std::size_t most = 16 * edges.size();
    std::vector<std::uint32_t> waiting;
    const auto closeAt = [&](std::uint32_t e, const Junction& junction) {
        if (junction.position == Topology::none || topology.edge(e).count == 0) return;
        if (closed >= most || topology.triangleCount() + topology.edge(e).count > maxTriangles) return;
        topology.split(e, junction.position, junction.share, waiting, &waiting);
        ++closed;
    };
    for (std::size_t i = 0; i < edges.size(); ++i) {
        closeAt(edges[i], junctions[i]);
        while (!waiting.empty()) {
            const std::uint32_t e = waiting.back();
            waiting.pop_back();
            closeAt(e, findJunction(topology, e, grids, tolerance));
        }
    }
    return closed;
}

/// Edges by length, longest first, older before newer: one integer each, so that a heap of them is quick.
class EdgeQueue {
public:
    EdgeQueue(const Topology& topology, float limit) : topology_(topology), squaredLimit_(limit * limit) {
        for (std::uint32_t e = 0; e < topology.edgeCount(); ++e) {
            const std::uint64_t key = keyOf(e);
            if (key != 0) heap_.push_back(key);
        }
        std::make_heap(heap_.begin(), heap_.end());
        queued_.assign(topology.edgeCount(), true);
    }

    void offer(std::uint32_t e) {
        if (queued_.size() < topology_.edgeCount()) queued_.resize(topology_.edgeCount(), false);
        const std::uint64_t key = keyOf(e);
        if (queued_[e] || key == 0) return;
        queued_[e] = true;
        heap_.push_back(key);
        std::push_heap(heap_.begin(), heap_.end());
    }

    /// The longest edge that some triangle still has, or none.
    std::uint32_t take() {
        while (!heap_.empty()) {
            std::pop_heap(heap_.begin(), heap_.end());
            const auto e = ~static_cast<std::uint32_t>(heap_.back());
            heap_.pop_back();
            queued_[e] = false;
            if (topology_.edge(e).count != 0) return e;
        }
        return Topology::none;
    }

private:
    /// Bits of a positive float grow with its value. 0: nothing to do.
    [[nodiscard]] std::uint64_t keyOf(std::uint32_t e) const {
        const float squared = topology_.squaredLength(e);
        if (topology_.edge(e).count == 0 || !(squared > squaredLimit_) || !std::isfinite(squared)) return 0;
        return std::uint64_t{std::bit_cast<std::uint32_t>(squared)} << 32U | static_cast<std::uint32_t>(~e);
    }

    const Topology& topology_;
    float squaredLimit_;
    std::vector<std::uint64_t> heap_;
    std::vector<bool> queued_;
};

void splitLongest(Topology& topology, const RefineOptions& options, float limit, std::size_t& splits) {
    EdgeQueue queue(topology, limit);
    std::vector<std::uint32_t> touched;
    while (splits < options.maxSplits && !options.stop.stop_requested()) {
        const std::uint32_t e = queue.take();
        if (e == Topology::none) return;
        if (topology.triangleCount() + topology.edge(e).count > options.maxTriangles) return;
        const std::uint32_t position = topology.middle(e);
        if (position == Topology::none) continue;
        touched.clear();
        splits += topology.split(e, position, 0.5F, touched);
        for (const std::uint32_t t : touched) queue.offer(t);
    }
}

float longestEdge(const Topology& topology) {
    float squared = 0;
    for (std::uint32_t e = 0; e < topology.edgeCount(); ++e)
        if (topology.edge(e).count != 0) squared = std::max(squared, topology.squaredLength(e));
    return std::sqrt(squared);
}

} // namespace

Mesh makeMesh(const level::Level& level) {
    Mesh mesh;
    mesh.vertices.reserve(level.vertices.size());
    mesh.triangles.reserve(level.indices.size() / 3);
    constexpr std::uint32_t unset = 0xffffffffU;
    std::vector<std::uint32_t> copyOf(level.vertices.size(), unset);
    std::vector<std::uint32_t> copied; // of this surface
    for (std::size_t s = 0; s < level.surfaces.size(); ++s) {
        const level::Surface& surface = level.surfaces[s];
        if (!drawn(level, surface)) continue;
        for (std::size_t i = surface.firstIndex; i + 2 < std::size_t{surface.firstIndex} + surface.indexCount; i += 3) {
            const std::array<std::uint32_t, 3> from{level.indices[i], level.indices[i + 1], level.indices[i + 2]};
            if (withoutArea(level.vertices[from[0]].position, level.vertices[from[1]].position,
                            level.vertices[from[2]].position))
                continue;
            MeshTriangle& triangle = mesh.triangles.emplace_back();
            triangle.surface = static_cast<std::uint32_t>(s);
            for (std::size_t k = 0; k < 3; ++k) {
                std::uint32_t& copy = copyOf[from[k]];
                if (copy == unset) {
                    copy = static_cast<std::uint32_t>(mesh.vertices.size());
                    mesh.vertices.push_back(level.vertices[from[k]]);
                    copied.push_back(from[k]);
                }
                triangle.vertices[k] = copy;
            }
        }
        for (const std::uint32_t v : copied) copyOf[v] = unset;
        copied.clear();
    }
    return mesh;
}

RefineStatistics refine(Mesh& mesh, const RefineOptions& options) {
    RefineStatistics statistics;
    Topology topology(mesh);
    const bool byLength = options.maxEdge < std::numeric_limits<float>::infinity();
    const bool byCount = options.maxSplits != std::numeric_limits<std::size_t>::max();
    const float limit = byLength ? std::max(options.maxEdge, 0.0F) : 0.0F;
    dropNoise(topology, options.tolerance);
    statistics.tJunctions = close(topology, options.tolerance, options.maxTriangles);
    if (options.maxSplits > 0 && (byLength || byCount)) {
        splitLongest(topology, options, limit, statistics.splits);
        // Where surfaces cross, a new edge can pass an old vertex.
        if (!options.stop.stop_requested())
            statistics.tJunctions += close(topology, options.tolerance, options.maxTriangles);
    }
    statistics.longestEdge = longestEdge(topology);
    topology.finish();
    return statistics;
}

std::size_t closeTJunctions(Mesh& mesh, float tolerance) {
    RefineOptions options;
    options.maxSplits = 0;
    options.tolerance = tolerance;
    return refine(mesh, options).tJunctions;
}

} // namespace pie::scene
