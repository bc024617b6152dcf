#include "pie/maps/kd_index.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace pie::maps {

namespace {

/// Halvings that are done level by level before subtrees are shared out.
constexpr unsigned mostUpperLevels = 6;
/// Below this many, items are simply sorted.
constexpr std::ptrdiff_t fewItems = 12;

/// The order in which halves are cut: total, so that a half is one set of photons.
template <unsigned Axis, class Item> bool before(const Item& a, const Item& b) {
    // Without branches: which way a comparison goes is as good as random here.
    return static_cast<bool>(
        static_cast<unsigned>(a.position[Axis] < b.position[Axis]) |
        (static_cast<unsigned>(a.position[Axis] == b.position[Axis]) & static_cast<unsigned>(a.number < b.number)));
}

/// Moves those before `pivot` to the front and returns the place behind them. No branch depends on the items.
template <unsigned Axis, class Item> Item* partition(Item* first, Item* last, const Item& pivot) {
    Item* border = first;
    for (Item* item = first; item != last; ++item) {
        const Item here = *item;
        const bool front = before<Axis>(here, pivot);
        *item = *border;
        *border = here;
        border += front ? 1 : 0;
    }
    return border;
}

/// Like std::nth_element: quickselect with the median of three for a pivot; std::nth_element itself when the pivots are
/// bad, so that no arrangement of photons takes more than n log n steps.
template <unsigned Axis, class Item> void select(Item* first, Item* middle, Item* last) {
    const auto order = [](const Item& a, const Item& b) { return before<Axis>(a, b); };
    for (int round = 0; last - first > fewItems; ++round) {
        if (round > 40) {
            std::nth_element(first, middle, last, order);
            return;
        }
        Item* const centre = first + (last - first) / 2;
        Item* const end = last - 1;
        if (order(*centre, *first)) std::swap(*centre, *first);
        if (order(*end, *centre)) std::swap(*end, *centre);
        if (order(*centre, *first)) std::swap(*centre, *first);
        // The pivot waits at the end, so that it can be put between the parts.
        std::swap(*centre, *end);
        const Item pivot = *end;
        Item* const border = partition<Axis>(first, end, pivot);
        std::swap(*border, *end);
        if (border == middle) return;
        if (border < middle)
            first = border + 1;
        else
            last = border;
    }
    std::sort(first, last, order);
}

template <class Item> void halve(Item* first, Item* middle, Item* last, unsigned axis) {
    switch (axis) {
    case 0: select<0>(first, middle, last); break;
    case 1: select<1>(first, middle, last); break;
    default: select<2>(first, middle, last); break;
    }
}

template <class Item> Box boxOf(const Item* first, const Item* last) {
    Box box;
#if defined(__SSE2__)
    // The fourth lane is the number: min and max of whatever it looks like as a float, ignored.
    __m128 lower = _mm_loadu_ps(first->position.data());
    __m128 upper = lower;
    for (const Item* item = first; item != last; ++item) {
        const __m128 p = _mm_loadu_ps(item->position.data());
        lower = _mm_min_ps(lower, p);
        upper = _mm_max_ps(upper, p);
    }
    alignas(16) std::array<float, 4> low{};
    alignas(16) std::array<float, 4> high{};
    _mm_store_ps(low.data(), lower);
    _mm_store_ps(high.data(), upper);
    box.lower = {low[0], low[1], low[2]};
    box.upper = {high[0], high[1], high[2]};
#else
    for (const Item* item = first; item != last; ++item)
        box.extend(Vec3(item->position[0], item->position[1], item->position[2]));
#endif
    return box;
}

unsigned longestAxis(const Box& box) {
    const Vec3 half = 0.5F * box.upper - 0.5F * box.lower; // the whole may be past the largest float
    unsigned longest = 0;
    for (unsigned axis = 1; axis < 3; ++axis)
        if (half[static_cast<int>(axis)] > half[static_cast<int>(longest)]) longest = axis;
    return longest;
}

} // namespace

/// Cuts ranges of items into the tree. Place `i` of level `l` of the halvings holds the items [n i / 2^l, n (i + 1) /
/// 2^l). Places of one level do not overlap, so they may be cut in parallel; every cut sees the same items in the same
/// order however the work is shared.
struct KdIndex::Builder {
    KdIndex& tree;
    std::span<Item> items;
    unsigned depth; ///< of the leaves, in halvings

    [[nodiscard]] Item* begin(std::size_t place, unsigned level) const {
        return items.data() + ((items.size() * place) >> level);
    }
    /// Levels with nodes are the root, then every second one: the root makes up for an odd depth with two children.
    [[nodiscard]] unsigned below(unsigned level) const { return level == 0 && depth % 2 == 1 ? 1 : level + 2; }
    /// The number of the first node of a level.
    [[nodiscard]] std::size_t firstNode(unsigned level) const {
        std::size_t first = 0;
        for (unsigned l = 0; l < level; l = below(l)) first += std::size_t{1} << l;
        return first;
    }

    void cut(std::size_t place, unsigned level) const {
        Item* const first = begin(place, level);
        Item* const last = begin(place + 1, level);
        halve(first, begin(2 * place + 1, level + 1), last, longestAxis(boxOf(first, last)));
    }
    Box cutBelow(std::size_t place, unsigned level) const;
    void fill(std::size_t place) const;
    void setChildren(std::size_t place, unsigned level, std::span<const Box> boxes) const;
    void join(std::vector<Box> boxes, unsigned level) const;
};

void KdIndex::Builder::fill(std::size_t place) const {
    const Item* const first = begin(place, depth);
    const auto count = static_cast<std::size_t>(begin(place + 1, depth) - first);
    Leaf& leaf = tree.leaves_[place];
    for (std::size_t slot = 0; slot < stopRecursionSize; ++slot) {
        const bool used = slot < count;
        for (std::size_t axis = 0; axis < 3; ++axis)
            leaf.position[axis][slot] = used ? first[slot].position[axis] : std::numeric_limits<float>::quiet_NaN();
        leaf.number[slot] = used ? first[slot].number : 0;
    }
}

void KdIndex::Builder::setChildren(std::size_t place, unsigned level, std::span<const Box> boxes) const {
    Node& node = tree.nodes_[firstNode(level) + place];
    const unsigned next = below(level);
    node.firstChild = static_cast<std::uint32_t>(firstNode(next) + place * boxes.size());
    for (std::size_t child = 0; child < width; ++child)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<int>(axis);
            const bool there = child < boxes.size();
            const float nan = std::numeric_limits<float>::quiet_NaN();
            node.boxes.lower[axis][child] = there ? boxes[child].lower[i] : nan;
            node.boxes.upper[axis][child] = there ? boxes[child].upper[i] : nan;
        }
}

/// Everything below a place that has a node or is a leaf; returns its box.
Box KdIndex::Builder::cutBelow(std::size_t place, unsigned level) const {
    if (level == depth) {
        fill(place);
        return boxOf(begin(place, depth), begin(place + 1, depth));
    }
    const unsigned next = below(level);
    const std::size_t children = std::size_t{1} << (next - level);
    cut(place, level);
    if (children == 4)
        for (std::size_t half = 0; half < 2; ++half) cut(2 * place + half, level + 1);
    std::array<Box, width> boxes;
    Box whole;
    for (std::size_t child = 0; child < children; ++child) {
        boxes[child] = cutBelow(children * place + child, next);
        whole.extend(boxes[child]);
    }
    setChildren(place, level, std::span(boxes).first(children));
    return whole;
}

/// The nodes above `level`, given the boxes of the places of that level.
void KdIndex::Builder::join(std::vector<Box> boxes, unsigned level) const {
    while (level > 0) {
        unsigned above = 0;
        while (below(above) != level) above = below(above);
        const std::size_t children = std::size_t{1} << (level - above);
        std::vector<Box> joined(std::size_t{1} << above);
        for (std::size_t place = 0; place < joined.size(); ++place) {
            const auto own = std::span(boxes).subspan(children * place, children);
            setChildren(place, above, own);
            for (const Box& box : own) joined[place].extend(box);
        }
        boxes = std::move(joined);
        level = above;
    }
}

void KdIndex::clear() {
    nodes_.clear();
    leaves_.clear();
    bounds_ = {};
}

void KdIndex::build(std::span<Item> items) {
    clear();
    if (items.empty()) return;
    bounds_ = boxOf(items.data(), items.data() + items.size());

    unsigned depth = 0;
    while ((items.size() + (std::size_t{1} << depth) - 1) >> depth > stopRecursionSize) ++depth;
    const Builder builder{*this, items, depth};
    nodes_.resize(builder.firstNode(depth));
    leaves_.resize(std::size_t{1} << depth);

    // The upper levels one after the other, each in parallel; then the subtrees below them; then the upper nodes, whose
    // boxes are made of those below.
    unsigned upper = 0;
    while (upper < depth && builder.below(upper) <= mostUpperLevels) upper = builder.below(upper);
    for (unsigned level = 0; level < upper; ++level)
        parallelChunks(std::size_t{1} << level, 1, [&](std::size_t from, std::size_t to) {
            for (std::size_t place = from; place < to; ++place) builder.cut(place, level);
        });
    std::vector<Box> boxes(std::size_t{1} << upper);
    parallelChunks(boxes.size(), 1, [&](std::size_t from, std::size_t to) {
        for (std::size_t place = from; place < to; ++place) boxes[place] = builder.cutBelow(place, upper);
    });
    builder.join(std::move(boxes), upper);
}

std::size_t KdIndex::bytes() const { return nodes_.capacity() * sizeof(Node) + leaves_.capacity() * sizeof(Leaf); }

} // namespace pie::maps
