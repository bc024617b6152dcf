#include "pie/brushes/tree_builder.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

namespace pie::brushes {
namespace {

using Face = TreeBuilder::Face;

constexpr double block = 1024;          // units, side of a block
constexpr std::size_t candidates = 24;  // planes tried for a cut
constexpr std::size_t mostJudges = 384; // faces that a plane is tried on
constexpr int deepest = 4000;

Plane axial(int axis, double at) {
    Plane plane;
    plane.normal[axis] = 1;
    plane.distance = at;
    return plane;
}

/// The axis that the plane is across; -1 if it is none.
int axisOf(const Plane& plane) {
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(plane.normal[axis]) == 1) return axis;
    return -1;
}

/// The same as placeOf a face's polygon: its bounds know on which side of an axial plane it is.
Place placeOf(const Face& face, const Plane& plane, int axis) {
    if (axis < 0) return placeOf(face.polygon, plane);
    const double at = plane.distance * plane.normal[axis];
    double highest = face.bounds.upper[axis] - at;
    double lowest = face.bounds.lower[axis] - at;
    if (plane.normal[axis] < 0) {
        std::swap(highest, lowest);
        highest = -highest;
        lowest = -lowest;
    }
    if (lowest >= -onPlane) return highest > onPlane ? Place::Front : Place::On;
    return highest > onPlane ? Place::Both : Place::Back;
}

/// Cells on both sides of the plane: its front, then its back.
std::array<Bounds, 2> halvesOf(const Bounds& bounds, const Plane& plane) {
    std::array<Bounds, 2> halves{bounds, bounds};
    const int axis = axisOf(plane);
    if (axis < 0) return halves;
    const double at = std::clamp(plane.distance * plane.normal[axis], bounds.lower[axis], bounds.upper[axis]);
    const std::size_t front = plane.normal[axis] > 0 ? 0 : 1;
    halves.at(front).lower[axis] = at;
    halves.at(1 - front).upper[axis] = at;
    return halves;
}

void setBounds(Face& face) {
    face.bounds = Bounds();
    face.bounds.extend(face.polygon);
}

} // namespace

void TreeBuilder::build(std::vector<Face> faces, const Bounds& world) {
    faces_ = std::move(faces);
    Numbers all(faces_.size());
    std::iota(all.begin(), all.end(), 0U);
    for (Face& face : faces_) setBounds(face);
    cutIntoBlocks(all, world, -1, 0);
    faces_ = {};
    parallelChunks(blocks_.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Block& mine = blocks_[i];
            Numbers numbers(mine.faces.size());
            std::iota(numbers.begin(), numbers.end(), 0U);
            static_cast<void>(cutBlock(mine, numbers, mine.bounds, 0));
            mine.faces = {};
        }
    });
    // Numbers of a block's cells continue those of the blocks before it.
    for (Block& mine : blocks_) {
        const auto firstNode = static_cast<std::int32_t>(nodes.size());
        const auto firstLeaf = static_cast<std::int32_t>(leafCount);
        if (mine.parent >= 0)
            nodes[static_cast<std::size_t>(mine.parent)].children.at(mine.side) =
                mine.nodes.empty() ? -firstLeaf - 1 : firstNode;
        for (SolidTree::Node& node : mine.nodes) {
            for (std::int32_t& child : node.children) child += child >= 0 ? firstNode : -firstLeaf;
            nodes.push_back(node);
        }
        leafCount += static_cast<std::size_t>(mine.leaves);
    }
    blocks_.clear();
}

void TreeBuilder::cutIntoBlocks(const Numbers& mine, const Bounds& bounds, std::int32_t parent, std::size_t side) {
    std::optional<std::uint32_t> plane;
    for (int axis = 0; axis < 3 && !plane && !mine.empty(); ++axis) {
        const double middle = block * std::floor((0.5 * (bounds.lower[axis] + bounds.upper[axis])) / block + 0.5);
        if (middle > bounds.lower[axis] + 1 && middle < bounds.upper[axis] - 1 &&
            bounds.upper[axis] - bounds.lower[axis] > block)
            plane = planes_.find(axial(axis, middle));
    }
    if (!plane) {
        Block& added = blocks_.emplace_back();
        added.faces.reserve(mine.size() + mine.size() / 2);
        for (const std::uint32_t number : mine) added.faces.push_back(std::move(faces_[number]));
        added.bounds = bounds;
        added.parent = parent;
        added.side = side;
        return;
    }
    const std::array<Numbers, 2> parts = divide(faces_, mine, *plane);
    const auto number = static_cast<std::int32_t>(nodes.size());
    nodes.push_back({*plane, {}, bounds});
    if (parent >= 0) nodes[static_cast<std::size_t>(parent)].children.at(side) = number;
    const std::array<Bounds, 2> halves = halvesOf(bounds, planes_[*plane]);
    for (std::size_t half = 0; half < 2; ++half) cutIntoBlocks(parts.at(half), halves.at(half), number, half);
}

/// Number of the new cell in the block.
std::int32_t TreeBuilder::cutBlock(Block& mine, const Numbers& faces, const Bounds& bounds, int depth) const {
    if (faces.empty() || depth > deepest) return -++mine.leaves;
    const std::uint32_t plane = choose(mine, faces, depth);
    const std::array<Numbers, 2> parts = divide(mine.faces, faces, plane);
    const auto number = static_cast<std::int32_t>(mine.nodes.size());
    mine.nodes.push_back({plane, {}, bounds});
    const std::array<Bounds, 2> halves = halvesOf(bounds, planes_[plane]);
    for (std::size_t half = 0; half < 2; ++half) {
        const std::int32_t child = cutBlock(mine, parts.at(half), halves.at(half), depth + 1);
        mine.nodes[static_cast<std::size_t>(number)].children.at(half) = child;
    }
    return number;
}

/// Faces in front of the plane and behind it; those in it have done their work. One that is cut keeps its front part,
/// its back part is added.
std::array<TreeBuilder::Numbers, 2> TreeBuilder::divide(std::vector<Face>& faces, const Numbers& mine,
                                                        std::uint32_t plane) const {
    // The pair's even plane may face either way; the tree's front is that plane's.
    const Plane& cut = planes_[plane];
    const int axis = axisOf(cut);
    std::array<Numbers, 2> parts;
    for (Numbers& part : parts) part.reserve(mine.size());
    for (const std::uint32_t number : mine) {
        Face& face = faces[number];
        if ((face.plane & ~1U) == (plane & ~1U)) continue;
        switch (placeOf(face, cut, axis)) {
        case Place::On: break;
        case Place::Front: parts[0].push_back(number); break;
        case Place::Back: parts[1].push_back(number); break;
        case Place::Both: {
            Face front{face.plane, {}, {}};
            Face back{face.plane, {}, {}};
            split(face.polygon, cut, front.polygon, back.polygon);
            setBounds(front);
            setBounds(back);
            face = std::move(front);
            parts[0].push_back(number);
            parts[1].push_back(static_cast<std::uint32_t>(faces.size()));
            faces.push_back(std::move(back));
        }
        }
    }
    return parts;
}

std::uint32_t TreeBuilder::choose(const Block& mine, const Numbers& faces, int depth) const {
    std::uint32_t best = mine.faces[faces.front()].plane;
    double bestValue = -std::numeric_limits<double>::max();
    const std::size_t step = std::max<std::size_t>(1, faces.size() / candidates);
    const std::size_t stride = (faces.size() + mostJudges - 1) / mostJudges;
    for (std::size_t c = depth % 2 == 0 ? 0 : step / 2; c < faces.size(); c += step) {
        const std::uint32_t number = mine.faces[faces[c]].plane;
        const Plane& plane = planes_[number];
        const int axis = axisOf(plane);
        double cuts = 0;
        double balance = 0;
        double facing = 0;
        for (std::size_t f = 0; f < faces.size(); f += stride) {
            const Face& face = mine.faces[faces[f]];
            if (face.plane == number) {
                ++facing;
                continue;
            }
            const Place place = placeOf(face, plane, axis);
            if (place == Place::Both)
                ++cuts;
            else
                balance += place == Place::Front ? 1 : -1;
        }
        const double value = 5 * facing - 5 * cuts - std::abs(balance) + (axis >= 0 ? 5 : 0);
        if (value > bestValue) {
            bestValue = value;
            best = number;
        }
    }
    return best;
}

} // namespace pie::brushes
