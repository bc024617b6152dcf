#include "pie/scene/topology.h"

#include "pie/scene/geometry.h"

#include <algorithm>
#include <cmath>

namespace pie::scene {
namespace {

/// Where a split has made more attribute vertices than this, they are searched by hash instead of one by one.
constexpr std::size_t shortSearch = 16;

level::Vertex mixed(const level::Vertex& a, const level::Vertex& b, float share, const Vec3& position) {
    level::Vertex mean;
    const float rest = 1.0F - share;
    mean.position = position;
    const Vec3 normal = rest * a.normal + share * b.normal;
    const float length = glm::length(normal);
    mean.normal = length > 1e-6F ? normal / length : a.normal;
    mean.texture = rest * a.texture + share * b.texture;
    mean.lightmap = rest * a.lightmap + share * b.lightmap;
    mean.colour = Rgba8(rest * Vec4(a.colour) + share * Vec4(b.colour) + 0.5F);
    return mean;
}

std::uint64_t pairKey(std::uint32_t low, std::uint32_t high) { return std::uint64_t{low} << 32U | high; }

} // namespace

Topology::Topology(Mesh& mesh)
    : mesh_(mesh), positionIndex_(mesh.vertices.size()), positionOf_(mesh.vertices.size(), none),
      edgeIndex_(mesh.triangles.size() * 2) {
    std::size_t kept = 0;
    for (const MeshTriangle& triangle : mesh.triangles) {
        const auto at = [&](std::size_t i) { return mesh.vertices[triangle.vertices[i]].position; };
        if (!withoutArea(at(0), at(1), at(2))) mesh.triangles[kept++] = triangle;
    }
    mesh.triangles.resize(kept);
    cornerEdge_.assign(3 * kept, none);
    next_.assign(3 * kept, none);
    previous_.assign(3 * kept, none);
    positions_.reserve(mesh.vertices.size());
    edges_.reserve(kept * 2);
    for (std::uint32_t t = 0; t < kept; ++t) {
        const std::array<std::uint32_t, 3>& vertices = mesh.triangles[t].vertices;
        for (const std::uint32_t v : vertices)
            if (positionOf_[v] == none) positionOf_[v] = positionIndex_.add(positions_, mesh.vertices[v].position);
        for (std::uint32_t i = 0; i < 3; ++i)
            link(3 * t + i, edgeBetween(positionOf_[vertices[i]], positionOf_[vertices[following(i)]]));
    }
}

float Topology::squaredLength(std::uint32_t e) const {
    const Vec3 d = positions_[edges_[e].b] - positions_[edges_[e].a];
    return glm::dot(d, d);
}

std::uint32_t Topology::middle(std::uint32_t e) {
    const Edge& edge = edges_[e];
    const Vec3 p = positions_[edge.a];
    const Vec3 q = positions_[edge.b];
    const Vec3 mean = 0.5F * (p + q);
    // Near the end of what floats resolve, the middle is rounded away from the edge, or onto one of its ends.
    const glm::dvec3 exact = 0.5 * (glm::dvec3(p) + glm::dvec3(q));
    const glm::dvec3 off = glm::dvec3(mean) - exact;
    const glm::dvec3 along = glm::dvec3(q) - glm::dvec3(p);
    if (!(glm::dot(off, off) < 1e-4 * glm::dot(along, along))) return none;
    return positionIndex_.add(positions_, mean);
}

std::uint32_t Topology::edgeBetween(std::uint32_t p, std::uint32_t q) {
    const std::uint32_t a = std::min(p, q);
    const std::uint32_t b = std::max(p, q);
    const std::uint32_t hash = mixBits(pairKey(a, b));
    const std::uint32_t known =
        edgeIndex_.find(hash, [&](std::uint32_t e) { return edges_[e].a == a && edges_[e].b == b; });
    if (known != none) return known;
    const auto number = static_cast<std::uint32_t>(edges_.size());
    edges_.push_back({a, b, none, 0});
    edgeIndex_.insert(hash, number);
    return number;
}

void Topology::link(std::uint32_t corner, std::uint32_t e) {
    Edge& edge = edges_[e];
    cornerEdge_[corner] = e;
    previous_[corner] = none;
    next_[corner] = edge.corner;
    if (edge.corner != none) previous_[edge.corner] = corner;
    edge.corner = corner;
    ++edge.count;
}

void Topology::unlink(std::uint32_t corner) {
    Edge& edge = edges_[cornerEdge_[corner]];
    if (previous_[corner] != none)
        next_[previous_[corner]] = next_[corner];
    else
        edge.corner = next_[corner];
    if (next_[corner] != none) previous_[next_[corner]] = previous_[corner];
    --edge.count;
}

std::uint32_t Topology::addVertex(std::uint32_t from, std::uint32_t to, float share, std::uint32_t position) {
    const auto vertex = static_cast<std::uint32_t>(mesh_.vertices.size());
    const level::Vertex mean = mixed(mesh_.vertices[from], mesh_.vertices[to], share, positions_[position]);
    mesh_.vertices.push_back(mean);
    positionOf_.push_back(position);
    return vertex;
}

std::uint32_t Topology::between(std::uint32_t from, std::uint32_t to, float share, std::uint32_t position) {
    const std::uint32_t hash = mixBits(pairKey(from, to));
    if (made_.size() <= shortSearch) {
        for (const Made& made : made_)
            if (made.from == from && made.to == to) return made.vertex;
    } else {
        const std::uint32_t known =
            madeIndex_.find(hash, [&](std::uint32_t i) { return made_[i].from == from && made_[i].to == to; });
        if (known != none) return made_[known].vertex;
    }
    made_.push_back({from, to, addVertex(from, to, share, position)});
    if (made_.size() == shortSearch + 1) {
        madeIndex_ = FlatIndex();
        for (std::uint32_t i = 0; i < made_.size(); ++i)
            madeIndex_.insert(mixBits(pairKey(made_[i].from, made_[i].to)), i);
    } else if (made_.size() > shortSearch + 1) {
        madeIndex_.insert(hash, static_cast<std::uint32_t>(made_.size() - 1));
    }
    return made_.back().vertex;
}

void Topology::drop(std::uint32_t triangle) {
    for (std::uint32_t i = 0; i < 3; ++i) unlink(3 * triangle + i);
    mesh_.triangles[triangle].vertices = {none, none, none};
    ++dropped_;
}

void Topology::dropFlat(double tolerance) {
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
        const std::array<std::uint32_t, 3>& v = mesh_.triangles[t].vertices;
        if (v[0] == none) continue;
        const auto at = [&](std::size_t i) { return positions_[positionOf_[v[i]]]; };
        if (flat({at(0), at(1), at(2)}, tolerance)) drop(t);
    }
}

bool Topology::splitsWell(std::uint32_t e, std::uint32_t position, double off) const {
    const glm::dvec3 a(positions_[edges_[e].a]);
    const glm::dvec3 b(positions_[edges_[e].b]);
    const glm::dvec3 p(positions_[position]);
    const glm::dvec3 along = b - a;
    const double length = glm::length(along);
    for (std::uint32_t corner = edges_[e].corner; corner != none; corner = next_[corner]) {
        const std::uint32_t apex = mesh_.triangles[corner / 3].vertices[following(following(corner % 3))];
        const glm::dvec3 c(positions_[positionOf_[apex]]);
        const glm::dvec3 across = glm::cross(along, c - a);
        const double share = glm::dot(c - a, along) / (length * length);
        const bool beside = share > 0.01 && share < 0.99;
        if (beside && off >= 0.25 * glm::length(across) / length) return false;
        if (glm::dot(glm::cross(p - a, c - a), across) <= 0 || glm::dot(glm::cross(b - p, c - p), across) <= 0)
            return false;
    }
    return true;
}

std::size_t Topology::split(std::uint32_t e, std::uint32_t position, float share, std::vector<std::uint32_t>& touched,
                            std::vector<std::uint32_t>* beside) {
    const std::uint32_t a = edges_[e].a;
    const std::size_t triangles = edges_[e].count;
    const std::uint32_t nearA = edgeBetween(a, position);
    const std::uint32_t nearB = edgeBetween(position, edges_[e].b);
    touched.push_back(nearA);
    touched.push_back(nearB);
    made_.clear();
    while (edges_[e].corner != none) {
        const std::uint32_t i = edges_[e].corner % 3;
        const std::uint32_t j = following(i);
        const std::uint32_t k = following(j);
        const std::uint32_t t = edges_[e].corner / 3;
        const MeshTriangle whole = mesh_.triangles[t];
        const std::uint32_t apex = positionOf_[whole.vertices[k]];
        if (apex == position) { // no area is left on either side
            drop(t);
            continue;
        }
        unlink(3 * t + i);
        const bool forward = positionOf_[whole.vertices[i]] == a;
        const std::uint32_t m = forward ? between(whole.vertices[i], whole.vertices[j], share, position)
                                        : between(whole.vertices[j], whole.vertices[i], share, position);
        const auto other = static_cast<std::uint32_t>(mesh_.triangles.size());
        mesh_.triangles[t].vertices[j] = m;
        mesh_.triangles.push_back(whole);
        mesh_.triangles.back().vertices[i] = m;
        cornerEdge_.resize(cornerEdge_.size() + 3, none);
        next_.resize(next_.size() + 3, none);
        previous_.resize(previous_.size() + 3, none);
        const std::uint32_t kept = cornerEdge_[3 * t + j];
        unlink(3 * t + j);
        link(3 * other + j, kept);
        link(3 * t + i, forward ? nearA : nearB);
        link(3 * other + i, forward ? nearB : nearA);
        const std::uint32_t across = edgeBetween(position, apex);
        link(3 * t + j, across);
        link(3 * other + k, across);
        touched.push_back(across);
        if (beside != nullptr) beside->insert(beside->end(), {kept, cornerEdge_[3 * t + k]});
    }
    return triangles;
}

std::vector<std::uint32_t> Topology::trianglesBySurface() const {
    std::vector<std::uint32_t> begin;
    for (const MeshTriangle& triangle : mesh_.triangles) {
        if (triangle.vertices[0] == none) continue;
        if (begin.size() < std::size_t{triangle.surface} + 2) begin.resize(std::size_t{triangle.surface} + 2, 0);
        ++begin[triangle.surface + 1];
    }
    for (std::size_t s = 1; s < begin.size(); ++s) begin[s] += begin[s - 1];
    std::vector<std::uint32_t> ordered(triangleCount());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
        if (mesh_.triangles[t].vertices[0] != none) ordered[begin[mesh_.triangles[t].surface]++] = t;
    return ordered;
}

std::vector<std::uint32_t> Topology::edgesInOrder() const {
    std::vector<std::uint32_t> ordered;
    ordered.reserve(2 * triangleCount());
    std::vector<bool> seen(edges_.size(), false);
    for (const std::uint32_t t : trianglesBySurface())
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t e = cornerEdge_[3 * t + i];
            if (seen[e]) continue;
            seen[e] = true;
            ordered.push_back(e);
        }
    return ordered;
}

void Topology::finish() {
    std::vector<MeshTriangle> ordered;
    ordered.reserve(triangleCount());
    for (const std::uint32_t t : trianglesBySurface()) ordered.push_back(mesh_.triangles[t]);
    mesh_.triangles = std::move(ordered);
}

} // namespace pie::scene
