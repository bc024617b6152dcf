#include "pie/brushes/solid_tree.h"

#include "pie/brushes/tree_builder.h"
#include "pie/brushes/tree_portals.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pie::brushes {
namespace {

/// Which side of the plane a box is on: 1 in front, -1 behind, 0 both.
int sideOf(const Bounds& bounds, const Plane& plane) {
    const glm::dvec3 centre = 0.5 * (bounds.lower + bounds.upper);
    const glm::dvec3 half = 0.5 * (bounds.upper - bounds.lower);
    const double reach =
        std::abs(plane.normal.x) * half.x + std::abs(plane.normal.y) * half.y + std::abs(plane.normal.z) * half.z;
    const double middle = plane.above(centre);
    return middle > reach ? 1 : middle < -reach ? -1 : 0;
}

} // namespace

SolidTree::SolidTree(std::span<const Fragment> surfaces, std::span<const Brush> brushes, PlaneSet& planes,
                     const Bounds& world)
    : planes_(planes) {
    std::vector<TreeBuilder::Face> faces;
    faces.reserve(surfaces.size());
    for (const Fragment& fragment : surfaces)
        faces.push_back({brushes[fragment.brush].sides[fragment.side].plane & ~1U, fragment.polygon, {}});
    TreeBuilder builder(planes);
    builder.build(std::move(faces), world);
    nodes_ = std::move(builder.nodes);
    leaves_.resize(builder.leafCount);
    openDoors(planes, BrushGrid(brushes, [](const Brush& brush) { return brush.structural; }), world);
}

void SolidTree::openDoors(const PlaneSet& planes, const BrushGrid& structural, const Bounds& world) {
    const std::vector<Portal> portals = makePortals(nodes_, planes, world);
    const auto eachDoor = [&](const auto& visit) {
        for (const Portal& portal : portals)
            for (std::size_t side = 0; side < 2; ++side)
                if (const std::int32_t cell = portal.cells.at(side); cell != Portal::worldEnd)
                    visit(portal, leaves_[static_cast<std::size_t>(-cell - 1)], portal.cells.at(1 - side));
    };
    eachDoor([](const Portal&, Leaf& leaf, std::int32_t) { ++leaf.doorCount; });
    std::uint32_t count = 0;
    for (Leaf& leaf : leaves_) {
        leaf.firstDoor = count;
        count += leaf.doorCount;
        leaf.doorCount = 0;
    }
    doors_.resize(count);
    eachDoor([&](const Portal& portal, Leaf& leaf, std::int32_t to) {
        doors_[leaf.firstDoor + leaf.doorCount++] = {to, portal.middle};
        leaf.bounds.extend(portal.bounds.lower);
        leaf.bounds.extend(portal.bounds.upper);
    });
    for (Leaf& leaf : leaves_) {
        // A leaf is convex: the mean of its openings' middles lies in it.
        glm::dvec3 sum(0);
        for (std::uint32_t i = 0; i < leaf.doorCount; ++i) sum += doors_[leaf.firstDoor + i].middle;
        leaf.solid = leaf.doorCount == 0 || structural.solidAt(sum / static_cast<double>(leaf.doorCount), planes);
    }
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
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    struct Entry {
        std::uint32_t from = none, door = none;
    };
    std::optional<Leak> leak;
    bool any = false;
    std::vector<Entry> enteredBy(leaves_.size());
    std::vector<std::uint32_t> open;
    const auto wayOut = [&](std::size_t point, std::uint32_t leaf, std::uint32_t door) {
        Leak found{point, {doors_[door].middle}};
        for (; enteredBy[leaf].from != none; leaf = enteredBy[leaf].from)
            found.path.push_back(doors_[enteredBy[leaf].door].middle);
        found.path.push_back(points[point]);
        std::reverse(found.path.begin(), found.path.end());
        return found;
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto start = static_cast<std::uint32_t>(leafAt(points[i]));
        if (leaves_[start].solid) continue;
        any = true;
        if (leaves_[start].reached) continue;
        leaves_[start].reached = true;
        open.assign(1, start);
        // Breadth first: a leak's path is a short one.
        for (std::size_t next = 0; next < open.size(); ++next) {
            const std::uint32_t leaf = open[next];
            for (std::uint32_t d = leaves_[leaf].firstDoor; d < leaves_[leaf].firstDoor + leaves_[leaf].doorCount;
                 ++d) {
                if (doors_[d].to == Portal::worldEnd) {
                    if (!leak) leak = wayOut(i, leaf, d);
                    continue;
                }
                const auto other = static_cast<std::uint32_t>(-doors_[d].to - 1);
                if (leaves_[other].solid || leaves_[other].reached) continue;
                leaves_[other].reached = true;
                enteredBy[other] = {leaf, d};
                open.push_back(other);
            }
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
    Polygon front;
    Polygon back;
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
        switch (split(piece, planes_[node.plane], front, back)) {
        case Place::Front: open.emplace_back(node.children[0], std::move(piece)); break;
        case Place::Back: open.emplace_back(node.children[1], std::move(piece)); break;
        case Place::On:
            // Within rounding in this plane, though not of it: both sides may be in front.
            open.emplace_back(node.children[0], piece);
            open.emplace_back(node.children[1], std::move(piece));
            break;
        case Place::Both:
            open.emplace_back(node.children[0], std::move(front));
            open.emplace_back(node.children[1], std::move(back));
        }
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
