#include "pie/maps/kd_tree.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <utility>

namespace pie::maps {

struct KdTree::Item {
    std::array<float, 3> position;
    std::uint32_t number;
};

/// Cuts a range of items into the nodes below one node. Ranges of one level do not overlap, so they may be cut in
/// parallel; the result is the same, because a half is defined by the total order and leaves are sorted by number.
struct KdTree::Builder {
    KdTree& tree;
    std::vector<Item>& items;
    unsigned depth; ///< of the leaves

    [[nodiscard]] std::size_t begin(std::uint32_t node, unsigned level) const {
        const std::uint64_t place = node - (std::uint32_t{1} << level);
        return static_cast<std::size_t>((items.size() * place) >> level);
    }
    [[nodiscard]] std::size_t end(std::uint32_t node, unsigned level) const { return begin(node + 1, level); }

    void cut(std::uint32_t node, unsigned level) const;
    void fill(std::uint32_t node) const;
    void below(std::uint32_t node, unsigned level) const;
};

namespace {

template <class Iterator> unsigned longestAxis(Iterator first, Iterator last) {
    std::array<float, 3> lower = first->position;
    std::array<float, 3> upper = first->position;
    for (Iterator item = first; item != last; ++item)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], item->position[axis]);
            upper[axis] = std::max(upper[axis], item->position[axis]);
        }
    unsigned longest = 0;
    std::array<float, 3> half{}; // half the extent: the whole may be past the largest float
    for (unsigned axis = 0; axis < 3; ++axis) {
        half[axis] = 0.5F * upper[axis] - 0.5F * lower[axis];
        if (half[axis] > half[longest]) longest = axis;
    }
    return longest;
}

template <unsigned Axis> struct Before {
    template <class Item> bool operator()(const Item& a, const Item& b) const {
        return a.position[Axis] < b.position[Axis] || (a.position[Axis] == b.position[Axis] && a.number < b.number);
    }
};

template <class Iterator> void halve(Iterator first, Iterator middle, Iterator last, unsigned axis) {
    switch (axis) {
    case 0: std::nth_element(first, middle, last, Before<0>{}); break;
    case 1: std::nth_element(first, middle, last, Before<1>{}); break;
    default: std::nth_element(first, middle, last, Before<2>{}); break;
    }
}

} // namespace

void KdTree::Builder::cut(std::uint32_t node, unsigned level) const {
    const auto at = [&](std::size_t index) { return items.begin() + static_cast<std::ptrdiff_t>(index); };
    const std::size_t from = begin(node, level);
    const std::size_t to = end(node, level);
    const std::size_t middle = begin(2 * node + 1, level + 1);
    const unsigned axis = longestAxis(at(from), at(to));
    halve(at(from), at(middle), at(to), axis);
    float low = items[from].position[axis];
    for (std::size_t i = from; i < middle; ++i) low = std::max(low, items[i].position[axis]);
    tree.nodes_[node] = {low, items[middle].position[axis], axis};
}

void KdTree::Builder::fill(std::uint32_t node) const {
    const std::size_t from = begin(node, depth);
    const std::size_t to = end(node, depth);
    std::sort(items.begin() + static_cast<std::ptrdiff_t>(from), items.begin() + static_cast<std::ptrdiff_t>(to),
              [](const Item& a, const Item& b) { return a.number < b.number; });
    Leaf& leaf = tree.leaves_[node - tree.firstLeaf_];
    for (std::size_t slot = 0; slot < stopRecursionSize; ++slot) {
        const bool used = from + slot < to;
        for (std::size_t axis = 0; axis < 3; ++axis)
            leaf.position[axis][slot] =
                used ? items[from + slot].position[axis] : std::numeric_limits<float>::quiet_NaN();
        leaf.number[slot] = used ? items[from + slot].number : 0;
    }
}

void KdTree::Builder::below(std::uint32_t node, unsigned level) const {
    if (level == depth) return fill(node);
    cut(node, level);
    below(2 * node, level + 1);
    below(2 * node + 1, level + 1);
}

void KdTree::build(std::vector<photons::Photon> photons) {
    photons_ = std::move(photons);
    nodes_.clear();
    leaves_.clear();
    bounds_ = {};
    firstLeaf_ = 1;

    std::vector<Item> items;
    items.reserve(photons_.size());
    for (std::size_t i = 0; i < photons_.size(); ++i) {
        const Vec3& p = photons_[i].position;
        if (!isFinite(p)) continue;
        items.push_back({{p.x, p.y, p.z}, static_cast<std::uint32_t>(i)});
        bounds_.extend(p);
    }
    if (items.empty()) return;

    unsigned depth = 0;
    while ((items.size() + (std::size_t{1} << depth) - 1) >> depth > stopRecursionSize) ++depth;
    firstLeaf_ = std::uint32_t{1} << depth;
    nodes_.resize(firstLeaf_);
    leaves_.resize(firstLeaf_);

    // The upper levels one after the other, each in parallel; then the subtrees below them.
    const Builder builder{*this, items, depth};
    const unsigned upperLevels = std::min(depth, 6U);
    for (unsigned level = 0; level < upperLevels; ++level)
        parallelChunks(std::size_t{1} << level, 1, [&](std::size_t from, std::size_t to) {
            for (std::size_t i = from; i < to; ++i)
                builder.cut(static_cast<std::uint32_t>((std::size_t{1} << level) + i), level);
        });
    parallelChunks(std::size_t{1} << upperLevels, 1, [&](std::size_t from, std::size_t to) {
        for (std::size_t i = from; i < to; ++i)
            builder.below(static_cast<std::uint32_t>((std::size_t{1} << upperLevels) + i), upperLevels);
    });
}

std::vector<photons::Photon> KdTree::release() {
    std::vector<photons::Photon> photons = std::exchange(photons_, {});
    nodes_.clear();
    leaves_.clear();
    firstLeaf_ = 1;
    bounds_ = {};
    return photons;
}

std::size_t KdTree::bytes() const {
    return photons_.capacity() * sizeof(photons::Photon) + nodes_.capacity() * sizeof(Node) +
           leaves_.capacity() * sizeof(Leaf);
}

} // namespace pie::maps
