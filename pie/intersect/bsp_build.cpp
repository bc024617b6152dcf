#include "pie/intersect/bsp_build.h"

#include "pie/intersect/intersectors.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pie::intersect {
namespace {

/// Leaves with fewer triangles are not worth another plane.
constexpr std::size_t fullLeaf = 4;
/// Depth that is left to the planes of the level; beyond it a tree is damaged or no help.
constexpr int deepestOfLevel = 128;
/// Planes tried along each axis.
constexpr int candidates = 11;
/// Cost of a plane in units of a triangle test, for the surface area heuristic.
constexpr double planeCost = 1.0;
/// Share of the pieces that may be cut in two before a plane does more harm than good.
constexpr double mostDuplicates = 0.6;

/// What of a triangle lies in the current part of space: a convex polygon.
struct Piece {
    static constexpr std::size_t mostPoints = 12;
    std::uint32_t triangle = 0;
    std::uint32_t count = 0;
    std::array<glm::dvec3, mostPoints> points;
};

struct DoubleBox {
    glm::dvec3 lower{std::numeric_limits<double>::max()};
    glm::dvec3 upper{std::numeric_limits<double>::lowest()};
    void extend(const glm::dvec3& p) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    void extend(const DoubleBox& box) {
        lower = glm::min(lower, box.lower);
        upper = glm::max(upper, box.upper);
    }
    [[nodiscard]] double surface() const {
        if (lower.x > upper.x) return 0;
        const glm::dvec3 d = upper - lower;
        return d.x * d.y + d.y * d.z + d.z * d.x;
    }
};

DoubleBox boxOf(const Piece& piece) {
    DoubleBox box;
    for (std::uint32_t i = 0; i < piece.count; ++i) box.extend(piece.points[i]);
    return box;
}

struct CutPlane {
    glm::dvec3 normal{0.0};
    double distance = 0;
    [[nodiscard]] double from(const glm::dvec3& p) const { return glm::dot(normal, p) - distance; }
};

/// The part in front of the plane (side 1) or behind it (side -1). A polygon with too many corners stays whole: that
/// costs a leaf or two, and misses nothing.
Piece clipped(const Piece& piece, const CutPlane& plane, double side) {
    if (piece.count >= Piece::mostPoints) return piece;
    Piece part;
    part.triangle = piece.triangle;
    for (std::uint32_t i = 0; i < piece.count; ++i) {
        const glm::dvec3& p = piece.points[i];
        const glm::dvec3& q = piece.points[(i + 1) % piece.count];
        const double dp = side * plane.from(p);
        const double dq = side * plane.from(q);
        if (dp >= 0) part.points[part.count++] = p;
        if ((dp < 0) != (dq < 0) && part.count < Piece::mostPoints)
            part.points[part.count++] = p + (q - p) * (dp / (dp - dq));
        if (part.count >= Piece::mostPoints) return piece;
    }
    return part;
}

class Builder {
public:
    Builder(const scene::Scene& scene, const level::Tree& tree, BspNodes& out) : scene_(scene), tree_(tree), out_(out) {
        const Vec3 size = glm::max(glm::abs(scene.bounds.lower), glm::abs(scene.bounds.upper));
        out.extent = scene.bounds.empty() ? 0.0F : glm::max(size.x, glm::max(size.y, size.z));
        near_ = 1e-6 * out.extent;
    }

    void run() {
        std::vector<Piece> pieces;
        pieces.reserve(scene_.triangles.size());
        for (std::size_t t = 0; t < scene_.triangles.size(); ++t) {
            if (scene_.normals[t] == Vec3(0.0F)) continue; // nothing meets a triangle without area
            Piece& piece = pieces.emplace_back();
            piece.triangle = static_cast<std::uint32_t>(t);
            piece.count = 3;
            for (int i = 0; i < 3; ++i) piece.points[static_cast<std::size_t>(i)] = scene_.corner(t, i);
        }
        out_.root = tree_.nodes.empty() ? byAxes(std::move(pieces), 0) : byLevel(std::move(pieces), 0, 0);
    }

private:
    struct Halves {
        std::vector<Piece> front, back;
    };

    [[nodiscard]] Halves halve(const std::vector<Piece>& pieces, const CutPlane& plane) const {
        Halves halves;
        for (const Piece& piece : pieces) {
            double low = std::numeric_limits<double>::infinity();
            double high = -low;
            for (std::uint32_t i = 0; i < piece.count; ++i) {
                const double d = plane.from(piece.points[i]);
                low = std::min(low, d);
                high = std::max(high, d);
            }
            // On the plane: a level's surfaces face the open side, and that is where rays come from.
            if (low >= -near_)
                halves.front.push_back(piece);
            else if (high <= near_)
                halves.back.push_back(piece);
            else {
                halves.front.push_back(clipped(piece, plane, 1));
                halves.back.push_back(clipped(piece, plane, -1));
            }
        }
        return halves;
    }

    std::int32_t addNode(const CutPlane& plane) {
        BspNodes::Node& node = out_.nodes.emplace_back();
        node.normal = Vec3(plane.normal);
        node.distance = static_cast<float>(plane.distance);
        return static_cast<std::int32_t>(out_.nodes.size() - 1);
    }

    std::int32_t addLeaf(const std::vector<Piece>& pieces) {
        BspNodes::Leaf leaf;
        leaf.begin = static_cast<std::uint32_t>(out_.triangles.size());
        for (const Piece& piece : pieces) out_.triangles.push_back(piece.triangle);
        const auto first = out_.triangles.begin() + leaf.begin;
        leaf.opaqueEnd = static_cast<std::uint32_t>(
            std::stable_partition(first, out_.triangles.end(), [&](std::uint32_t t) { return isOpaque(scene_, t); }) -
            out_.triangles.begin());
        leaf.end = static_cast<std::uint32_t>(out_.triangles.size());
        out_.leaves.push_back(leaf);
        return -static_cast<std::int32_t>(out_.leaves.size());
    }

    std::int32_t byLevel(std::vector<Piece> pieces, std::int32_t child, int depth) {
        const auto n = static_cast<std::size_t>(child);
        if (pieces.empty() || child < 0 || depth >= deepestOfLevel || n >= tree_.nodes.size() ||
            tree_.nodes[n].plane >= tree_.planes.size())
            return byAxes(std::move(pieces), depth);
        const level::Plane& given = tree_.planes[tree_.nodes[n].plane];
        const CutPlane plane{glm::dvec3(given.normal), given.distance};
        const double length = glm::length(plane.normal);
        if (!std::isfinite(plane.distance) || !(std::abs(length - 1.0) < 1e-3)) return byAxes(std::move(pieces), depth);
        Halves halves = halve(pieces, plane);
        pieces = {};
        const std::int32_t node = addNode(plane);
        const std::int32_t front = byLevel(std::move(halves.front), tree_.nodes[n].children[0], depth + 1);
        const std::int32_t back = byLevel(std::move(halves.back), tree_.nodes[n].children[1], depth + 1);
        out_.nodes[static_cast<std::size_t>(node)].children = {front, back};
        return node;
    }

    /// The best of some planes along the axes by the surface area heuristic; distance NaN when none is worth it.
    [[nodiscard]] static CutPlane bestPlane(const std::vector<Piece>& pieces) {
        std::vector<DoubleBox> boxes;
        boxes.reserve(pieces.size());
        DoubleBox all;
        for (const Piece& piece : pieces) {
            boxes.push_back(boxOf(piece));
            all.extend(boxes.back());
        }
        CutPlane best;
        best.distance = std::numeric_limits<double>::quiet_NaN();
        double bestCost = static_cast<double>(pieces.size()) - planeCost;
        for (int axis = 0; axis < 3; ++axis) {
            const double width = all.upper[axis] - all.lower[axis];
            if (!(width > 0)) continue;
            for (int c = 1; c <= candidates; ++c) {
                const double at = all.lower[axis] + width * c / (candidates + 1);
                std::size_t front = 0;
                std::size_t back = 0;
                for (const DoubleBox& box : boxes) {
                    front += box.upper[axis] > at || box.lower[axis] >= at ? 1U : 0U;
                    back += box.lower[axis] < at ? 1U : 0U;
                }
                if (static_cast<double>(front + back) > (1.0 + mostDuplicates) * static_cast<double>(pieces.size()))
                    continue;
                DoubleBox frontBox = all;
                DoubleBox backBox = all;
                frontBox.lower[axis] = at;
                backBox.upper[axis] = at;
                const double whole = all.surface();
                const double cost =
                    (frontBox.surface() * static_cast<double>(front) + backBox.surface() * static_cast<double>(back)) /
                    (whole > 0 ? whole : 1.0);
                if (cost < bestCost) {
                    bestCost = cost;
                    best.normal = glm::dvec3(0.0);
                    best.normal[axis] = 1;
                    // As the ray will see it.
                    best.distance = static_cast<double>(static_cast<float>(at));
                }
            }
        }
        return best;
    }

    std::int32_t byAxes(std::vector<Piece> pieces, int depth) {
        if (pieces.size() <= fullLeaf || depth + 1 >= BspNodes::deepest) return addLeaf(pieces);
        const CutPlane plane = bestPlane(pieces);
        if (std::isnan(plane.distance)) return addLeaf(pieces);
        Halves halves = halve(pieces, plane);
        if (halves.front.size() >= pieces.size() && halves.back.size() >= pieces.size()) return addLeaf(pieces);
        if (halves.front.size() == pieces.size() && halves.back.empty()) return addLeaf(pieces);
        if (halves.back.size() == pieces.size() && halves.front.empty()) return addLeaf(pieces);
        pieces = {};
        const std::int32_t node = addNode(plane);
        const std::int32_t front = byAxes(std::move(halves.front), depth + 1);
        const std::int32_t back = byAxes(std::move(halves.back), depth + 1);
        out_.nodes[static_cast<std::size_t>(node)].children = {front, back};
        return node;
    }

    const scene::Scene& scene_;
    const level::Tree& tree_;
    BspNodes& out_;
    double near_ = 0;
};

} // namespace

BspNodes buildBsp(const scene::Scene& scene, const level::Tree& tree) {
    BspNodes nodes;
    Builder(scene, tree, nodes).run();
    return nodes;
}

} // namespace pie::intersect
