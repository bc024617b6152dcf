#include "pie/brushes/solid_tree.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace pie::brushes {
namespace {

constexpr double block = 1024;         // units; the world is first cut into cubes of these, so that cuts stay local
constexpr std::size_t candidates = 24; // planes tried for a cut
constexpr int deepest = 4000;

Plane axial(int axis, double at) {
    Plane plane;
    plane.normal[axis] = 1;
    plane.distance = at;
    return plane;
}

glm::dvec3 middle(const Polygon& polygon) {
    glm::dvec3 sum(0);
    for (const glm::dvec3& p : polygon) sum += p;
    return sum / static_cast<double>(polygon.size());
}

/// Which side of the plane a box is on: 1 in front, -1 behind, 0 both.
int sideOf(const Bounds& bounds, const Plane& plane) {
    const glm::dvec3 centre = 0.5 * (bounds.lower + bounds.upper);
    const glm::dvec3 half = 0.5 * (bounds.upper - bounds.lower);
    const double reach =
        std::abs(plane.normal.x) * half.x + std::abs(plane.normal.y) * half.y + std::abs(plane.normal.z) * half.z;
    const double middle = plane.above(centre);
    return middle > reach ? 1 : middle < -reach ? -1 : 0;
}

/// Openings of the tree's cells, made by cutting the world's box down the tree.
class Portals {
public:
    using Portal = SolidTree::Portal;
    static constexpr std::int32_t worldEnd = std::numeric_limits<std::int32_t>::min();

    Portals(const std::vector<SolidTree::Node>& nodes, std::size_t leaves, const PlaneSet& planes)
        : nodes_(nodes), planes_(planes), ofNode_(nodes.size()), ofLeaf_(leaves) {}

    void make(const Bounds& world) {
        const std::int32_t root = nodes_.empty() ? -1 : 0;
        std::array<Plane, 6> box;
        for (int axis = 0; axis < 3; ++axis) {
            // Facing out of the world.
            box.at(2 * static_cast<std::size_t>(axis)) = axial(axis, world.upper[axis]);
            Plane lower = axial(axis, -world.lower[axis]);
            lower.normal = -lower.normal;
            box.at(2 * static_cast<std::size_t>(axis) + 1) = lower;
        }
        for (const Plane& plane : box) {
            Polygon polygon = wholePlane(plane);
            for (const Plane& other : box)
                if (&other != &plane) keepBehind(polygon, other);
            add({std::move(polygon), plane, {worldEnd, root}});
        }
        std::vector<std::int32_t> open;
        if (root >= 0) open.push_back(root);
        while (!open.empty()) {
            const std::int32_t node = open.back();
            open.pop_back();
            cut(node);
            for (const std::int32_t child : nodes_[static_cast<std::size_t>(node)].children)
                if (child >= 0) open.push_back(child);
        }
    }

    void take(std::vector<SolidTree::Leaf>& leaves, std::vector<Portal>& portals) {
        std::vector<std::uint32_t> place(all_.size(), 0);
        for (std::size_t i = 0; i < all_.size(); ++i) {
            if (all_[i].polygon.empty()) continue;
            place[i] = static_cast<std::uint32_t>(portals.size());
            portals.push_back({std::move(all_[i].polygon), all_[i].cells});
            for (const std::int32_t cell : all_[i].cells)
                if (cell != worldEnd) leaves[static_cast<std::size_t>(-cell - 1)].portals.push_back(place[i]);
        }
    }

private:
    struct Opening {
        Polygon polygon; ///< empty: gone
        Plane plane;     ///< cells[0] lies in front of it
        std::array<std::int32_t, 2> cells{};
    };
    const std::vector<SolidTree::Node>& nodes_;
    const PlaneSet& planes_;
    std::vector<Opening> all_;
    std::vector<std::vector<std::uint32_t>> ofNode_, ofLeaf_;

    std::vector<std::uint32_t>& of(std::int32_t cell) {
        return cell >= 0 ? ofNode_[static_cast<std::size_t>(cell)] : ofLeaf_[static_cast<std::size_t>(-cell - 1)];
    }
    void add(Opening opening) {
        const auto number = static_cast<std::uint32_t>(all_.size());
        for (const std::int32_t cell : opening.cells)
            if (cell != worldEnd) of(cell).push_back(number);
        all_.push_back(std::move(opening));
    }

    /// Hands the openings of a node to its children and adds the one between them.
    void cut(std::int32_t number) {
        const SolidTree::Node& node = nodes_[static_cast<std::size_t>(number)];
        const Plane& plane = planes_[node.plane];
        std::vector<std::uint32_t> mine;
        mine.swap(of(number));

        Polygon between = wholePlane(plane);
        for (const std::uint32_t i : mine) {
            const Opening& opening = all_[i];
            if (opening.polygon.empty()) continue;
            Split parts = split(between, opening.plane);
            between = std::move(opening.cells[0] == number ? parts.front : parts.back);
            if (between.empty()) break;
        }
        if (hasArea(between)) add({std::move(between), plane, node.children});

        for (const std::uint32_t i : mine) {
            if (all_[i].polygon.empty()) continue;
            const std::size_t side = all_[i].cells[0] == number ? 0 : 1;
            const std::int32_t other = all_[i].cells.at(1 - side);
            Split parts = split(all_[i].polygon, plane);
            const std::array<Polygon*, 2> pieces{&parts.front, &parts.back};
            bool used = false;
            const Plane own = all_[i].plane;
            for (std::size_t c = 0; c < 2; ++c) {
                if (!hasArea(*pieces.at(c))) continue;
                if (!used) {
                    used = true;
                    all_[i].polygon = std::move(*pieces.at(c));
                    all_[i].cells.at(side) = node.children.at(c);
                    of(node.children.at(c)).push_back(i);
                } else {
                    Opening piece{std::move(*pieces.at(c)), own, {}};
                    piece.cells.at(side) = node.children.at(c);
                    piece.cells.at(1 - side) = other;
                    add(std::move(piece));
                }
            }
            if (!used) all_[i].polygon.clear();
        }
    }
};

} // namespace

SolidTree::SolidTree(std::span<const Fragment> surfaces, std::span<const Brush> brushes, const BrushGrid& grid,
                     PlaneSet& planes, const Bounds& world)
    : planes_(planes) {
    std::vector<Face> faces;
    faces.reserve(surfaces.size());
    for (const Fragment& fragment : surfaces)
        // Both directions of a plane cut alike: the even one of the pair.
        faces.push_back({brushes[fragment.brush].sides[fragment.side].plane & ~1U, fragment.polygon});
    build(std::move(faces), world, 0);
    makePortals(world);
    for (Leaf& leaf : leaves_) {
        glm::dvec3 sum(0);
        double count = 0;
        for (const std::uint32_t portal : leaf.portals)
            for (const glm::dvec3& p : portals_[portal].polygon) {
                sum += p;
                leaf.bounds.extend(p);
                ++count;
            }
        leaf.solid = count == 0 || grid.solidAt(sum / count, planes);
    }
}

std::uint32_t SolidTree::choose(const std::vector<Face>& faces, int depth) const {
    std::uint32_t best = faces.front().plane;
    double bestValue = -std::numeric_limits<double>::max();
    const std::size_t step = std::max<std::size_t>(1, faces.size() / candidates);
    for (std::size_t c = depth % 2 == 0 ? 0 : step / 2; c < faces.size(); c += step) {
        const Plane& plane = planes_[faces[c].plane];
        double cuts = 0;
        double balance = 0;
        double facing = 0;
        for (const Face& face : faces) {
            if (face.plane == faces[c].plane) {
                ++facing;
                continue;
            }
            double highest = 0;
            double lowest = 0;
            for (const glm::dvec3& p : face.polygon) {
                const double above = plane.above(p);
                highest = std::max(highest, above);
                lowest = std::min(lowest, above);
            }
            if (highest > onPlane && lowest < -onPlane)
                ++cuts;
            else
                balance += highest > onPlane ? 1 : -1;
        }
        const double value = 5 * facing - 5 * cuts - std::abs(balance) + (plane.axial() ? 5 : 0);
        if (value > bestValue) {
            bestValue = value;
            best = faces[c].plane;
        }
    }
    return best;
}

std::int32_t SolidTree::build(std::vector<Face> faces, const Bounds& bounds, int depth) {
    if (faces.empty() || depth > deepest) {
        leaves_.emplace_back();
        return -static_cast<std::int32_t>(leaves_.size());
    }
    std::optional<std::uint32_t> plane;
    for (int axis = 0; axis < 3 && !plane; ++axis) {
        const double middle = block * std::floor((0.5 * (bounds.lower[axis] + bounds.upper[axis])) / block + 0.5);
        if (middle > bounds.lower[axis] + 1 && middle < bounds.upper[axis] - 1 &&
            bounds.upper[axis] - bounds.lower[axis] > block)
            plane = planes_.find(axial(axis, middle));
    }
    if (!plane) plane = choose(faces, depth);
    // The pair's even plane may face either way; the tree's front is that plane's.
    const Plane cut = planes_[*plane];
    std::array<std::vector<Face>, 2> parts;
    for (Face& face : faces) {
        if ((face.plane & ~1U) == (*plane & ~1U)) continue;
        Split pieces = split(face.polygon, cut);
        if (!pieces.front.empty()) parts[0].push_back({face.plane, std::move(pieces.front)});
        if (!pieces.back.empty()) parts[1].push_back({face.plane, std::move(pieces.back)});
    }
    faces.clear();
    faces.shrink_to_fit();
    const auto number = static_cast<std::int32_t>(nodes_.size());
    nodes_.push_back({*plane, {}, bounds});
    std::array<Bounds, 2> halves{bounds, bounds};
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(cut.normal[axis]) == 1) {
            const double at = cut.distance * cut.normal[axis];
            const std::size_t front = cut.normal[axis] > 0 ? 0 : 1;
            halves.at(front).lower[axis] = std::clamp(at, bounds.lower[axis], bounds.upper[axis]);
            halves.at(1 - front).upper[axis] = std::clamp(at, bounds.lower[axis], bounds.upper[axis]);
        }
    for (std::size_t side = 0; side < 2; ++side) {
        const std::int32_t child = build(std::move(parts.at(side)), halves.at(side), depth + 1);
        nodes_[static_cast<std::size_t>(number)].children.at(side) = child;
    }
    return number;
}

void SolidTree::makePortals(const Bounds& world) {
    Portals portals(nodes_, leaves_.size(), planes_);
    portals.make(world);
    portals.take(leaves_, portals_);
}

std::size_t SolidTree::leafAt(const glm::dvec3& point) const {
    std::int32_t cell = nodes_.empty() ? -1 : 0;
    while (cell >= 0) {
        const Node& node = nodes_[static_cast<std::size_t>(cell)];
        cell = node.children.at(planes_[node.plane].above(point) >= 0 ? 0 : 1);
    }
    return static_cast<std::size_t>(-cell - 1);
}

std::optional<Leak> SolidTree::flood(std::span<const glm::dvec3> points) {
    std::optional<Leak> leak;
    bool any = false;
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> cameBy(leaves_.size(), none); // opening through which a leaf was entered
    std::vector<std::size_t> open;
    const auto across = [&](std::uint32_t portal, std::size_t leaf) {
        const std::array<std::int32_t, 2>& cells = portals_[portal].cells;
        return cells[0] == -static_cast<std::int32_t>(leaf) - 1 ? cells[1] : cells[0];
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::size_t start = leafAt(points[i]);
        if (leaves_[start].solid) continue;
        any = true;
        if (leaves_[start].reached) continue;
        leaves_[start].reached = true;
        open.assign(1, start);
        // Breadth first: a leak's path is a short one.
        for (std::size_t next = 0; next < open.size(); ++next)
            for (const std::uint32_t portal : leaves_[open[next]].portals) {
                const std::int32_t cell = across(portal, open[next]);
                if (cell == Portals::worldEnd) {
                    if (leak) continue;
                    leak = Leak{i, {}};
                    for (std::size_t leaf = open[next]; cameBy[leaf] != none;) {
                        leak->path.push_back(middle(portals_[cameBy[leaf]].polygon));
                        leaf = static_cast<std::size_t>(-across(cameBy[leaf], leaf) - 1);
                    }
                    leak->path.push_back(points[i]);
                    std::reverse(leak->path.begin(), leak->path.end());
                    leak->path.push_back(middle(portals_[portal].polygon));
                    continue;
                }
                const auto other = static_cast<std::size_t>(-cell - 1);
                if (leaves_[other].solid || leaves_[other].reached) continue;
                leaves_[other].reached = true;
                cameBy[other] = portal;
                open.push_back(other);
            }
    }
    if (!any || leak)
        for (Leaf& leaf : leaves_) leaf.reached = !leaf.solid;
    return leak;
}

void SolidTree::leavesInFront(const Polygon& polygon, std::uint32_t plane, std::vector<std::uint32_t>& leaves) const {
    const std::size_t before = leaves.size();
    std::vector<std::pair<std::int32_t, Polygon>> open;
    open.emplace_back(nodes_.empty() ? -1 : 0, polygon);
    while (!open.empty()) {
        auto [cell, piece] = std::move(open.back());
        open.pop_back();
        if (cell < 0) {
            leaves.push_back(static_cast<std::uint32_t>(-cell - 1));
            continue;
        }
        const Node& node = nodes_[static_cast<std::size_t>(cell)];
        if ((node.plane & ~1U) == (plane & ~1U)) {
            open.emplace_back(node.children.at(node.plane == plane ? 0 : 1), std::move(piece));
            continue;
        }
        Split parts = split(piece, planes_[node.plane]);
        if (parts.front.empty() && parts.back.empty()) {
            // Within rounding in this plane, though not of it: both sides may be in front.
            open.emplace_back(node.children[0], piece);
            open.emplace_back(node.children[1], std::move(piece));
            continue;
        }
        if (!parts.front.empty()) open.emplace_back(node.children[0], std::move(parts.front));
        if (!parts.back.empty()) open.emplace_back(node.children[1], std::move(parts.back));
    }
    const auto first = leaves.begin() + static_cast<std::ptrdiff_t>(before);
    std::sort(first, leaves.end());
    leaves.erase(std::unique(first, leaves.end()), leaves.end());
}

void SolidTree::leavesNear(const Bounds& bounds, std::vector<std::uint32_t>& leaves) const {
    std::vector<std::int32_t> open{nodes_.empty() ? -1 : 0};
    while (!open.empty()) {
        const std::int32_t cell = open.back();
        open.pop_back();
        if (cell < 0) {
            leaves.push_back(static_cast<std::uint32_t>(-cell - 1));
            continue;
        }
        const Node& node = nodes_[static_cast<std::size_t>(cell)];
        const int side = sideOf(bounds, planes_[node.plane]);
        if (side >= 0) open.push_back(node.children[0]);
        if (side <= 0) open.push_back(node.children[1]);
    }
    std::sort(leaves.begin(), leaves.end());
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
}

} // namespace pie::brushes
