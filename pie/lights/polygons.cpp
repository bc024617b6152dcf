// Triangles of a surface joined to convex polygons: fewer area lights, and exact form factors over whole faces.

#include "pie/lights/import_parts.h"

#include <algorithm>
#include <array>
#include <list>
#include <optional>

namespace pie::lights::detail {
namespace {

using glm::dvec3;
using Polygon = std::vector<Vec3>;

constexpr double flatness = 1e-4;     // sine of the angle by which normals of one plane may differ
constexpr double straightness = 1e-5; // sine of the turn below which a corner counts as straight
constexpr std::size_t maxPieces = 64; // beyond, joining pairs of pairs costs more than it saves

dvec3 areaVector(const Polygon& polygon) {
    dvec3 sum(0.0);
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
        sum += glm::cross(dvec3(polygon[i]) - dvec3(polygon[0]), dvec3(polygon[i + 1]) - dvec3(polygon[0]));
    return 0.5 * sum;
}

/// Drops straight corners; nullopt if some corner turns the wrong way.
std::optional<Polygon> convex(const Polygon& polygon, const dvec3& normal) {
    Polygon kept;
    const std::size_t n = polygon.size();
    for (std::size_t i = 0; i < n; ++i) {
        const dvec3 in = dvec3(polygon[i]) - dvec3(kept.empty() ? polygon[(i + n - 1) % n] : kept.back());
        const dvec3 out = dvec3(polygon[(i + 1) % n]) - dvec3(polygon[i]);
        const double lengths = glm::length(in) * glm::length(out);
        if (!(lengths > 0.0)) continue;
        const double turn = glm::dot(glm::cross(in, out), normal) / lengths;
        if (turn < -straightness || (turn < straightness && glm::dot(in, out) < 0.0)) return std::nullopt;
        if (turn > straightness) kept.push_back(polygon[i]);
    }
    if (kept.size() < 3) return std::nullopt;
    return kept;
}

/// Joins two polygons of one plane along an edge they share, if the result is convex.
std::optional<Polygon> join(const Polygon& a, const Polygon& b) {
    const dvec3 na = areaVector(a);
    const dvec3 nb = areaVector(b);
    if (glm::length(glm::cross(na, nb)) > flatness * glm::length(na) * glm::length(nb) || glm::dot(na, nb) <= 0.0)
        return std::nullopt;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t k = 0; k < b.size(); ++k) {
            if (a[i] != b[(k + 1) % b.size()] || a[(i + 1) % a.size()] != b[k]) continue;
            Polygon joined;
            for (std::size_t j = 1; j <= a.size(); ++j) joined.push_back(a[(i + j) % a.size()]);
            for (std::size_t j = 2; j < b.size(); ++j) joined.push_back(b[(k + j) % b.size()]);
            const dvec3 n = na + nb;
            return convex(joined, n / glm::length(n));
        }
    return std::nullopt;
}

} // namespace

std::vector<Polygon> convexPolygons(const level::Level& level, const level::Surface& surface) {
    std::vector<Polygon> pieces;
    for (std::uint32_t i = 0; i + 2 < surface.indexCount; i += 3) {
        Polygon triangle;
        for (std::uint32_t k = 0; k < 3; ++k)
            triangle.push_back(level.vertices[level.indices[surface.firstIndex + i + k]].position);
        if (glm::length(areaVector(triangle)) > 0.0) pieces.push_back(std::move(triangle));
    }
    if (pieces.size() > maxPieces) return pieces;
    for (bool joined = true; joined;) {
        joined = false;
        for (std::size_t i = 0; i < pieces.size(); ++i)
            for (std::size_t k = i + 1; k < pieces.size();)
                if (auto both = join(pieces[i], pieces[k])) {
                    pieces[i] = std::move(*both);
                    pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(k));
                    joined = true;
                } else {
                    ++k;
                }
    }
    return pieces;
}

} // namespace pie::lights::detail
