#include "pie/brushes/tree_portals.h"

#include "pie/core/parallel.h"

#include <glm/geometric.hpp>

#include <cmath>
#include <iterator>
#include <utility>

namespace pie::brushes {
namespace {

/// The plane's part in a box.
Polygon partInBox(const Plane& plane, const Bounds& box) {
    Polygon polygon = wholePlane(plane);
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            // Beside a plane across the axis nothing is to be cut.
            if (std::abs(plane.normal[axis]) == 1) continue;
            Plane side;
            side.normal[axis] = sign;
            side.distance = sign > 0 ? box.upper[axis] : -box.lower[axis];
            keepBehind(polygon, side);
        }
    return polygon;
}

/// What the level compiler lets through: slits narrower than a fifth of a unit, as editors' rounding leaves them
/// between brushes, are closed.
bool isOpen(const Polygon& polygon) {
    constexpr double narrow = 0.2;
    std::size_t sides = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i)
        if (glm::length(polygon[(i + 1) % polygon.size()] - polygon[i]) >= narrow) ++sides;
    return sides >= 3 && hasArea(polygon);
}

class Maker {
public:
    Maker(std::span<const SolidTree::Node> nodes, const PlaneSet& planes, std::span<const std::int32_t> parents)
        : nodes_(nodes), planes_(planes), parents_(parents) {}

    /// Openings in a node's plane.
    void ofNode(std::size_t number, std::vector<Portal>& portals) {
        const SolidTree::Node& node = nodes_[number];
        Polygon polygon = partInBox(planes_[node.plane], node.bounds);
        // The box knows of axial cuts above.
        auto child = static_cast<std::int32_t>(number);
        for (std::int32_t above = parents_[number]; above >= 0 && !polygon.empty();
             child = above, above = parents_[static_cast<std::size_t>(above)]) {
            const SolidTree::Node& parent = nodes_[static_cast<std::size_t>(above)];
            Plane plane = planes_[parent.plane];
            if (plane.axial()) continue;
            if (parent.children[0] == child) plane = {-plane.normal, -plane.distance};
            keepBehind(polygon, plane);
        }
        if (!isOpen(polygon)) return;
        between(std::move(polygon), node.children, portals);
    }
    /// Openings from the root to a polygon on the world's border.
    void ofBorder(Polygon polygon, std::vector<Portal>& portals) {
        between(std::move(polygon), {Portal::worldEnd, nodes_.empty() ? -1 : 0}, portals);
    }

private:
    std::span<const SolidTree::Node> nodes_;
    const PlaneSet& planes_;
    std::span<const std::int32_t> parents_;

    struct Open {
        Polygon polygon;
        std::array<std::int32_t, 2> cells{};
    };
    std::vector<Open> open_;

    /// Cuts on until there are leaves on both sides.
    void between(Polygon polygon, const std::array<std::int32_t, 2>& cells, std::vector<Portal>& portals) {
        open_.push_back({std::move(polygon), cells});
        Polygon front;
        Polygon back;
        while (!open_.empty()) {
            Open& last = open_.back();
            if (last.cells[0] < 0 && last.cells[1] < 0) {
                close(last, portals);
                open_.pop_back();
                continue;
            }
            const std::size_t side = last.cells[0] >= 0 ? 0 : 1;
            const SolidTree::Node& node = nodes_[static_cast<std::size_t>(last.cells.at(side))];
            switch (split(last.polygon, planes_[node.plane], front, back)) {
            case Place::Front: last.cells.at(side) = node.children[0]; break;
            case Place::Back: last.cells.at(side) = node.children[1]; break;
            case Place::On: {
                // Within rounding in the plane: whichever side is thicker than that is a neighbour.
                Open other = last;
                last.cells.at(side) = node.children[0];
                other.cells.at(side) = node.children[1];
                open_.push_back(std::move(other));
                break;
            }
            case Place::Both: {
                Open other{std::move(back), last.cells};
                other.cells.at(side) = node.children[1];
                const bool wide = isOpen(other.polygon);
                if (isOpen(front)) {
                    last.cells.at(side) = node.children[0];
                    last.polygon = std::move(front);
                    if (wide) open_.push_back(std::move(other));
                } else if (wide) {
                    last = std::move(other);
                } else {
                    open_.pop_back();
                }
            }
            }
        }
    }

    static void close(const Open& open, std::vector<Portal>& portals) {
        Portal portal{open.cells, glm::dvec3(0), static_cast<std::uint32_t>(open.polygon.size()), {}};
        for (const glm::dvec3& p : open.polygon) portal.middle += p;
        portal.middle /= static_cast<double>(portal.corners);
        portal.bounds.extend(open.polygon);
        portals.push_back(portal);
    }
};

} // namespace

std::vector<Portal> makePortals(std::span<const SolidTree::Node> nodes, const PlaneSet& planes, const Bounds& world) {
    std::vector<std::int32_t> parents(nodes.size(), -1);
    for (std::size_t i = 0; i < nodes.size(); ++i)
        for (const std::int32_t child : nodes[i].children)
            if (child >= 0) parents[static_cast<std::size_t>(child)] = static_cast<std::int32_t>(i);
    constexpr std::size_t grain = 128;
    std::vector<std::vector<Portal>> chunks((nodes.size() + grain - 1) / grain + 1);
    parallelChunks(nodes.size(), grain, [&](std::size_t begin, std::size_t end) {
        Maker maker(nodes, planes, parents);
        for (std::size_t i = begin; i < end; ++i) maker.ofNode(i, chunks[begin / grain]);
    });
    Maker maker(nodes, planes, parents);
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            Plane border;
            border.normal[axis] = sign;
            border.distance = sign > 0 ? world.upper[axis] : -world.lower[axis];
            maker.ofBorder(partInBox(border, world), chunks.back());
        }
    std::size_t count = 0;
    for (const auto& chunk : chunks) count += chunk.size();
    std::vector<Portal> all;
    all.reserve(count);
    for (const auto& chunk : chunks) all.insert(all.end(), chunk.begin(), chunk.end());
    return all;
}

} // namespace pie::brushes
