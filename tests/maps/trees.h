#pragma once
// Trees with visibility, made by chance or by hand.

#include "pie/level/level.h"

#include <cmath>
#include <cstddef>
#include <random>
#include <utility>

namespace pie::maps::test {

inline void noVisibility(level::Tree& tree, std::size_t clusters) {
    const std::size_t bytes = (clusters + 7) / 8;
    tree.visibility = {clusters, bytes, std::vector<std::uint8_t>(clusters * bytes, 0)};
}

inline void setVisible(level::Tree& tree, std::size_t from, std::size_t to) {
    auto& v = tree.visibility;
    v.bits[from * v.bytesPerCluster + to / 8] |= static_cast<std::uint8_t>(1U << (to % 8));
}

/// Planes in all directions through the box from 0 to `size`; some leaves are solid, some share a cluster. Every
/// cluster sees itself and a third of the others.
inline level::Tree randomTree(std::size_t nodes, float size, std::mt19937& random) {
    const auto unit = [&] { return static_cast<float>(random() >> 8U) * 0x1p-24F; };
    level::Tree tree;
    const auto leaf = [&] {
        level::Tree::Leaf& made = tree.leaves.emplace_back();
        if (random() % 5 != 0) made.cluster = static_cast<std::int32_t>(random() % nodes);
        return -static_cast<std::int32_t>(tree.leaves.size());
    };
    for (std::size_t n = 0; n < nodes; ++n) {
        Vec3 normal(0.0F);
        if (random() % 2 == 0)
            normal[static_cast<int>(random() % 3)] = 1.0F;
        else
            normal = glm::normalize(Vec3(unit() - 0.5F, unit() - 0.5F, unit() - 0.501F));
        const Vec3 point = size * Vec3(unit(), unit(), unit());
        tree.planes.push_back({normal, glm::dot(normal, point)});
        tree.nodes.push_back({static_cast<std::uint32_t>(n), {0, 0}, {}});
    }
    // Node n hangs below some earlier one, whose child has no place yet.
    std::vector<std::pair<std::size_t, std::size_t>> open{{0, 0}, {0, 1}};
    for (std::size_t n = 1; n < nodes; ++n) {
        const std::size_t i = random() % open.size();
        const auto [parent, side] = open[i];
        tree.nodes[parent].children[side] = static_cast<std::int32_t>(n);
        open[i] = {n, 0};
        open.emplace_back(n, 1);
    }
    for (const auto& [parent, side] : open) tree.nodes[parent].children[side] = leaf();
    noVisibility(tree, nodes);
    for (std::size_t from = 0; from < nodes; ++from)
        for (std::size_t to = 0; to < nodes; ++to)
            if (from == to || random() % 3 == 0) setVisible(tree, from, to);
    return tree;
}

/// Rooms side by side along x, one cluster each, with rock between them: room i from x = i · pitch to i · pitch +
/// width. None sees another.
inline level::Tree rooms(std::size_t count, float pitch, float width) {
    level::Tree tree;
    for (std::size_t i = 0; i < count; ++i) {
        const float begin = static_cast<float>(i) * pitch;
        // Two nodes a room: what lies before it is rock, then the room, and so on behind it.
        for (const float x : {begin, begin + width}) {
            const auto n = static_cast<std::int32_t>(tree.nodes.size());
            tree.planes.push_back({Vec3(1.0F, 0.0F, 0.0F), x});
            tree.leaves.emplace_back().cluster = x == begin ? -1 : static_cast<std::int32_t>(i);
            tree.nodes.push_back(
                {static_cast<std::uint32_t>(n), {n + 1, -static_cast<std::int32_t>(tree.leaves.size())}, {}});
        }
    }
    tree.leaves.emplace_back(); // rock
    tree.nodes.back().children[0] = -static_cast<std::int32_t>(tree.leaves.size());
    noVisibility(tree, count);
    for (std::size_t i = 0; i < count; ++i) setVisible(tree, i, i);
    return tree;
}

} // namespace pie::maps::test
