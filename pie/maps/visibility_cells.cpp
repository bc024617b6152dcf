#include "pie/maps/visibility_cells.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <queue>
#include <utility>

namespace pie::maps {
namespace {

using glm::dvec3;
using level::Tree;

/// Leaves with a cluster below each node; empty when the tree is not one.
std::vector<std::size_t> weigh(const Tree& tree) {
    std::vector<std::size_t> weights(tree.nodes.size(), 0);
    std::vector<bool> reached(tree.nodes.size(), false);
    std::vector<std::int32_t> order{0};
    for (std::size_t i = 0; i < order.size(); ++i) {
        const auto n = static_cast<std::size_t>(order[i]);
        if (n >= tree.nodes.size() || reached[n] || tree.nodes[n].plane >= tree.planes.size()) return {};
        reached[n] = true;
        for (const std::int32_t child : tree.nodes[n].children) {
            if (child >= 0)
                order.push_back(child);
            else if (static_cast<std::size_t>(-(child + 1)) >= tree.leaves.size())
                return {};
        }
    }
    // Children stand behind their parents.
    for (std::size_t i = order.size(); i-- > 0;) {
        std::size_t& weight = weights[static_cast<std::size_t>(order[i])];
        for (const std::int32_t child : tree.nodes[static_cast<std::size_t>(order[i])].children)
            weight += child >= 0 ? weights[static_cast<std::size_t>(child)]
                                 : (tree.leaves[static_cast<std::size_t>(-(child + 1))].cluster >= 0 ? 1U : 0U);
    }
    return weights;
}

/// The part with dot(plane.normal, p + offset) >= plane.distance, or with `sign` -1 the rest.
std::vector<dvec3> half(const std::vector<dvec3>& corners, const level::Plane& plane, const dvec3& offset,
                        double sign) {
    const dvec3 normal(plane.normal);
    const double distance = static_cast<double>(plane.distance) - glm::dot(normal, offset);
    std::vector<dvec3> kept;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const dvec3& a = corners[i];
        const dvec3& b = corners[(i + 1) % corners.size()];
        const double da = sign * (glm::dot(normal, a) - distance);
        const double db = sign * (glm::dot(normal, b) - distance);
        if (da >= 0) kept.push_back(a);
        if ((da > 0 && db < 0) || (da < 0 && db > 0)) kept.push_back(a + (b - a) * (da / (da - db)));
    }
    return kept;
}

} // namespace

VisibilityCells::VisibilityCells(const Tree& tree, std::size_t wanted) : tree_(tree) {
    const Tree::Visibility& visibility = tree.visibility;
    const bool complete = visibility.bits.size() >= visibility.clusters * visibility.bytesPerCluster &&
                          visibility.bytesPerCluster >= (visibility.clusters + 7) / 8;
    if (visibility.clusters > 1 && complete && !tree.nodes.empty())
        makeCells(std::clamp<std::size_t>(wanted, 1, most - 1));
}

void VisibilityCells::makeCells(std::size_t wanted) {
    const std::vector<std::size_t> weights = weigh(tree_);
    if (weights.empty() || weights[0] < 2) return;
    const auto weightOf = [&](std::int32_t child) {
        if (child >= 0) return weights[static_cast<std::size_t>(child)];
        return tree_.leaves[static_cast<std::size_t>(-(child + 1))].cluster >= 0 ? std::size_t{1} : std::size_t{0};
    };

    // The heaviest on top; of equals the lower node.
    std::vector<bool> halved(tree_.nodes.size(), false);
    std::priority_queue<std::pair<std::size_t, std::int32_t>> parts;
    parts.emplace(weights[0], 0);
    for (std::size_t count = 1; count < wanted && !parts.empty();) {
        const std::int32_t node = -parts.top().second;
        parts.pop();
        halved[static_cast<std::size_t>(node)] = true;
        const auto& children = tree_.nodes[static_cast<std::size_t>(node)].children;
        for (const std::int32_t child : children)
            if (child >= 0 && weightOf(child) > 1) parts.emplace(weightOf(child), -child);
        if (weightOf(children[0]) > 0 && weightOf(children[1]) > 0) ++count;
    }

    // What is halved becomes nodes, what is not becomes cells.
    std::vector<Set> cellsOfCluster(tree_.visibility.clusters, 0);
    const auto claim = [&](std::int32_t child, std::size_t cell) {
        std::vector<std::int32_t> below{child};
        while (!below.empty()) {
            const std::int32_t at = below.back();
            below.pop_back();
            if (at >= 0) {
                const auto& children = tree_.nodes[static_cast<std::size_t>(at)].children;
                below.insert(below.end(), children.begin(), children.end());
                continue;
            }
            const std::int32_t cluster = tree_.leaves[static_cast<std::size_t>(-(at + 1))].cluster;
            if (cluster >= 0 && static_cast<std::size_t>(cluster) < cellsOfCluster.size())
                cellsOfCluster[static_cast<std::size_t>(cluster)] |= Set{1} << cell;
        }
    };
    std::vector<std::size_t> order{0};
    const auto convert = [&](std::int32_t child) -> std::int32_t {
        if (weightOf(child) == 0) return -1;
        if (child >= 0 && halved[static_cast<std::size_t>(child)]) {
            order.push_back(static_cast<std::size_t>(child));
            return static_cast<std::int32_t>(order.size() - 1);
        }
        claim(child, size_);
        return -static_cast<std::int32_t>(++size_);
    };
    if (!halved[0]) return;                            // one cell wanted
    for (std::size_t next = 0; next < order.size();) { // which grows
        const Tree::Node& node = tree_.nodes[order[next++]];
        const std::int32_t front = convert(node.children[0]);
        nodes_.push_back({tree_.planes[node.plane], {front, convert(node.children[1])}});
    }
    lookAround(cellsOfCluster);
}

void VisibilityCells::lookAround(const std::vector<Set>& cellsOfCluster) {
    const Tree::Visibility& visibility = tree_.visibility;
    seen_.resize(visibility.clusters);
    for (std::size_t from = 0; from < seen_.size(); ++from) {
        seen_[from] = Set{1} | cellsOfCluster[from];
        for (std::size_t to = 0; to < seen_.size(); ++to)
            if (visibility.sees(from, to)) seen_[from] |= cellsOfCluster[to];
    }
}

std::uint32_t VisibilityCells::cellAt(const Vec3& point) const {
    if (nodes_.empty()) return 0;
    std::int32_t at = 0;
    while (at >= 0) {
        const Node& node = nodes_[static_cast<std::size_t>(at)];
        at = node.children[glm::dot(node.plane.normal, point) >= node.plane.distance ? 0 : 1];
    }
    return static_cast<std::uint32_t>(-(at + 1));
}

VisibilityCells::Set VisibilityCells::seenFrom(const Vec3& point) const {
    if (nodes_.empty()) return ~Set{0};
    const std::int32_t cluster = tree_.leaves[tree_.leafAt(point)].cluster;
    const bool known = cluster >= 0 && static_cast<std::size_t>(cluster) < seen_.size();
    return known ? seen_[static_cast<std::size_t>(cluster)] : ~Set{0};
}

std::vector<VisibilityCells::Piece> VisibilityCells::cut(std::vector<dvec3> corners, const dvec3& offset) const {
    std::vector<Piece> pieces;
    std::vector<std::pair<std::int32_t, std::vector<dvec3>>> waiting;
    waiting.emplace_back(nodes_.empty() ? -1 : 0, std::move(corners));
    while (!waiting.empty()) {
        auto [at, polygon] = std::move(waiting.back());
        waiting.pop_back();
        if (polygon.size() < 3) continue;
        if (at < 0) {
            pieces.push_back({static_cast<std::uint32_t>(-(at + 1)), std::move(polygon)});
            continue;
        }
        const Node& node = nodes_[static_cast<std::size_t>(at)];
        waiting.emplace_back(node.children[1], half(polygon, node.plane, offset, -1));
        waiting.emplace_back(node.children[0], half(polygon, node.plane, offset, 1));
    }
    return pieces;
}

std::size_t VisibilityCells::bytes() const { return nodes_.capacity() * sizeof(Node) + seen_.capacity() * sizeof(Set); }

} // namespace pie::maps
