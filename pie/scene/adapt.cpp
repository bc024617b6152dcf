#include "pie/scene/adapt.h"

#include "pie/scene/geometry.h"
#include "pie/scene/topology.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pie::scene {
namespace {

/// Splits between two looks at the values: enough to fill a batch of rays, few enough that the worst comes first.
constexpr std::size_t fewestSplits = 256;
constexpr std::size_t widestEdge = 16; // triangles that meet in one edge and are split at once
constexpr std::size_t splitShare = 8;  // of a mesh of so many times the vertices

/// Values by place, each asked for once.
class Samples {
public:
    std::uint32_t add(const SurfacePoint& point) {
        const std::uint64_t direction = hashPosition(rounded(point.normal)) ^ point.surface * 0x9e3779b9U;
        const std::uint32_t hash = mixBits(std::uint64_t{hashPosition(point.position)} << 32U ^ direction);
        const std::uint32_t known = index_.find(hash, [&](std::uint32_t i) {
            return points_[i].position == point.position && points_[i].surface == point.surface &&
                   rounded(points_[i].normal) == rounded(point.normal);
        });
        if (known != FlatIndex::none) return known;
        const auto number = static_cast<std::uint32_t>(points_.size());
        points_.push_back(point);
        index_.insert(hash, number);
        return number;
    }
    /// Of everything added since the last call.
    void evaluate(const ValueAt& valueAt) {
        const std::size_t first = values_.size();
        if (first == points_.size()) return;
        values_.resize(points_.size(), 0.0F);
        valueAt(std::span(points_).subspan(first), std::span(values_).subspan(first));
    }
    [[nodiscard]] float operator[](std::uint32_t i) const { return values_[i]; }
    [[nodiscard]] std::size_t size() const { return points_.size(); }

private:
    /// Interpolation and rounding make as much of a difference.
    static Vec3 rounded(const Vec3& normal) { return glm::round(normal * 1000.0F); }

    std::vector<SurfacePoint> points_;
    std::vector<float> values_;
    FlatIndex index_;
};

class Adaption {
public:
    Adaption(Mesh& mesh, const AdaptOptions& options, const ValueAt& valueAt)
        : mesh_(mesh), options_(options), valueAt_(valueAt), topology_(mesh) {}

    AdaptStatistics run() {
        std::vector<std::uint32_t> fresh = topology_.edgesInOrder();
        while (!options_.stop.stop_requested()) {
            probe(fresh);
            fresh.clear();
            if (!splitWorst(fresh)) break;
        }
        topology_.finish();
        statistics_.probes = samples_.size();
        return statistics_;
    }

private:
    /// An edge as one triangle has it: samples of its ends and its middle.
    struct Probe {
        std::uint32_t edge = 0, a = 0, b = 0, middle = 0;
    };

    [[nodiscard]] Vec3 position(const MeshTriangle& triangle, std::uint32_t i) const {
        return mesh_.vertices[triangle.vertices[i]].position;
    }

    [[nodiscard]] Vec3 normalOf(const MeshTriangle& triangle, std::uint32_t i) const {
        const Vec3 stored = mesh_.vertices[triangle.vertices[i]].normal;
        const float length = glm::length(stored);
        if (length > 0.0F && std::isfinite(length)) return stored / length;
        const glm::dvec3 across = areaVector(position(triangle, 0), position(triangle, 1), position(triangle, 2));
        const double size = glm::length(across);
        return size > 0 && std::isfinite(size) ? Vec3(across / size) : Vec3(0.0F, 0.0F, 1.0F);
    }

    std::uint32_t sampleAt(const MeshTriangle& triangle, const Vec3& at, const Vec3& normal) {
        const Vec3 inwards = (position(triangle, 0) + position(triangle, 1) + position(triangle, 2)) / 3.0F - at;
        const float length = glm::length(inwards);
        const float share = length > 0.0F ? std::min(insetShare, insetUnits / length) : 0.0F;
        return samples_.add({at, normal, at + share * inwards, triangle.surface});
    }

    void probe(std::span<const std::uint32_t> edges) {
        std::vector<Probe> probes;
        for (const std::uint32_t e : edges) {
            if (topology_.edge(e).count == 0 || !longEnough(e)) continue;
            topology_.forEachTriangle(e, [&](std::uint32_t t, std::uint32_t i) {
                const MeshTriangle& triangle = mesh_.triangles[t];
                const std::uint32_t j = following(i);
                const Vec3 a = position(triangle, i);
                const Vec3 b = position(triangle, j);
                const Vec3 normalA = normalOf(triangle, i);
                const Vec3 normalB = normalOf(triangle, j);
                const Vec3 sum = normalA + normalB;
                const float length = glm::length(sum);
                const Vec3 normal = length > 1e-6F ? sum / length : normalA;
                probes.push_back({e, sampleAt(triangle, a, normalA), sampleAt(triangle, b, normalB),
                                  sampleAt(triangle, 0.5F * (a + b), normal)});
            });
        }
        samples_.evaluate(valueAt_);
        for (std::size_t i = 0; i < probes.size();) {
            const std::uint32_t e = probes[i].edge;
            float off = 0;
            for (; i < probes.size() && probes[i].edge == e; ++i)
                off = std::max(
                    off, std::abs(samples_[probes[i].middle] - 0.5F * (samples_[probes[i].a] + samples_[probes[i].b])));
            const float urgency = off * std::sqrt(topology_.squaredLength(e));
            if (!(off > options_.tolerance) || !std::isfinite(urgency)) continue;
            // Bits of a positive float grow with its value; older before newer.
            heap_.push_back(std::uint64_t{std::bit_cast<std::uint32_t>(urgency)} << 32U |
                            static_cast<std::uint32_t>(~e));
            std::push_heap(heap_.begin(), heap_.end());
        }
    }

    [[nodiscard]] bool longEnough(std::uint32_t e) const {
        const float squared = topology_.squaredLength(e);
        return std::isfinite(squared) && squared >= 4 * options_.smallestEdge * options_.smallestEdge;
    }

    /// The longest edge of the triangles that have e, or of their neighbours across a longer one, and so on.
    [[nodiscard]] std::uint32_t longestFrom(std::uint32_t e) const {
        for (;;) {
            std::uint32_t longest = e;
            topology_.forEachTriangle(e, [&](std::uint32_t t, std::uint32_t) {
                for (std::uint32_t i = 0; i < 3; ++i) {
                    const std::uint32_t other = topology_.edgeOf(t, i);
                    if (topology_.squaredLength(other) > topology_.squaredLength(longest)) longest = other;
                }
            });
            if (longest == e) return e;
            e = longest;
        }
    }

    /// False when nothing was left to split, or no room.
    bool splitWorst(std::vector<std::uint32_t>& fresh) {
        std::size_t left = std::max(fewestSplits, mesh_.vertices.size() / splitShare);
        while (!heap_.empty() && left > 0) {
            std::pop_heap(heap_.begin(), heap_.end());
            const auto e = ~static_cast<std::uint32_t>(heap_.back());
            heap_.pop_back();
            while (topology_.edge(e).count != 0) {
                const std::uint32_t longest = longestFrom(e);
                const std::size_t triangles = topology_.edge(longest).count;
                if (topology_.vertexCount() + triangles > options_.maxVertices ||
                    topology_.triangleCount() + triangles > options_.maxTriangles)
                    return false;
                const std::uint32_t middle = topology_.middle(longest);
                if (middle == Topology::none) break;
                statistics_.splits += topology_.split(longest, middle, 0.5F, fresh);
                left -= std::min<std::size_t>(left, 1);
            }
        }
        return !fresh.empty();
    }

    Mesh& mesh_;
    const AdaptOptions& options_;
    const ValueAt& valueAt_;
    Topology topology_;
    Samples samples_;
    std::vector<std::uint64_t> heap_;
    AdaptStatistics statistics_;
};

} // namespace

AdaptStatistics adapt(Mesh& mesh, const AdaptOptions& options, const ValueAt& valueAt) {
    RefineOptions coarse;
    coarse.maxEdge = options.coarseEdge;
    // A triangle that is split brings one vertex at most.
    coarse.maxSplits = options.maxVertices - std::min(options.maxVertices, mesh.vertices.size() + widestEdge);
    coarse.maxTriangles = options.maxTriangles;
    coarse.tolerance = options.junctionTolerance;
    coarse.stop = options.stop;
    const RefineStatistics before = refine(mesh, coarse);
    AdaptStatistics statistics = Adaption(mesh, options, valueAt).run();
    statistics.tJunctions += before.tJunctions;
    // Where surfaces cross, a new edge can pass an old vertex.
    if (!options.stop.stop_requested()) statistics.tJunctions += closeTJunctions(mesh, options.junctionTolerance);
    return statistics;
}

} // namespace pie::scene
