#include "pie/scene/cells.h"

#include "pie/scene/geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>

namespace pie::scene {
namespace {

/// A tree deeper than this is damaged or useless; what is left is halved instead.
constexpr int deepest = 256;

struct Sample {
    Vec3 centre{0.0F};
    std::uint32_t triangle = 0;
};

/// A cell tree with what is needed to join cells: how many triangles it holds, and where.
struct Part {
    std::vector<std::uint32_t> triangles;
    std::vector<Part> children;
    std::size_t count = 0;
    Box bounds;
};

CellNode toNode(Part&& part) {
    CellNode node;
    node.triangles = std::move(part.triangles);
    node.children.reserve(part.children.size());
    for (Part& child : part.children) node.children.push_back(toNode(std::move(child)));
    return node;
}

double surfaceOf(const Box& box) {
    const glm::dvec3 size(box.size());
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

Box joined(Box a, const Box& b) {
    a.extend(b);
    return a;
}

class CellBuilder {
public:
    CellBuilder(const Mesh& mesh, const level::Tree& tree, std::size_t wanted)
        : mesh_(mesh), tree_(tree), wanted_(std::max<std::size_t>(wanted, 1)) {}

    [[nodiscard]] Part byTree(std::span<Sample> samples, std::int32_t child, int depth) const {
        if (samples.size() <= wanted_ || child < 0 || depth > deepest ||
            static_cast<std::size_t>(child) >= tree_.nodes.size() ||
            tree_.nodes[static_cast<std::size_t>(child)].plane >= tree_.planes.size())
            return byHalves(samples, depth);
        const level::Tree::Node& node = tree_.nodes[static_cast<std::size_t>(child)];
        const level::Plane& plane = tree_.planes[node.plane];
        const auto middle = std::stable_partition(samples.begin(), samples.end(), [&](const Sample& sample) {
            return glm::dot(plane.normal, sample.centre) >= plane.distance;
        });
        const auto inFront = static_cast<std::size_t>(middle - samples.begin());
        if (inFront == 0) return byTree(samples, node.children[1], depth + 1);
        if (inFront == samples.size()) return byTree(samples, node.children[0], depth + 1);
        return join(byTree(samples.first(inFront), node.children[0], depth + 1),
                    byTree(samples.subspan(inFront), node.children[1], depth + 1));
    }

    /// Halves at the median of the longest axis.
    [[nodiscard]] Part byHalves(std::span<Sample> samples, int depth) const {
        // A leaf of the level that is slightly too full is left whole.
        if (samples.size() <= wanted_ + wanted_ / 2 || samples.size() < 2 || depth > 2 * deepest) return leaf(samples);
        Box centres;
        for (const Sample& sample : samples) centres.extend(sample.centre);
        const Vec3 size = centres.size();
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
        const std::size_t half = samples.size() / 2;
        std::nth_element(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(half), samples.end(),
                         [axis](const Sample& a, const Sample& b) {
                             if (a.centre[axis] != b.centre[axis]) return a.centre[axis] < b.centre[axis];
                             return a.triangle < b.triangle;
                         });
        return join(byHalves(samples.first(half), depth + 1), byHalves(samples.subspan(half), depth + 1));
    }

private:
    [[nodiscard]] Part leaf(std::span<const Sample> samples) const {
        Part part;
        part.count = samples.size();
        part.triangles.reserve(samples.size());
        for (const Sample& sample : samples) {
            part.triangles.push_back(sample.triangle);
            for (const std::uint32_t v : mesh_.triangles[sample.triangle].vertices)
                part.bounds.extend(mesh_.vertices[v].position);
        }
        std::sort(part.triangles.begin(), part.triangles.end());
        return part;
    }

    /// A cell that is worth no draw call of its own goes to a neighbour. A level's tree has many such crumbs: rooms
    /// that it cuts off corner by corner.
    [[nodiscard]] Part join(Part a, Part b) const {
        Part& crumb = a.count < b.count ? a : b;
        Part& rest = a.count < b.count ? b : a;
        const std::size_t count = a.count + b.count;
        const bool bothLeaves = a.children.empty() && b.children.empty();
        if ((bothLeaves && count <= wanted_) ||
            (crumb.children.empty() && crumb.count < wanted_ / 4 && absorbs(rest, crumb))) {
            absorb(rest, crumb);
            return std::move(rest);
        }
        Part whole;
        whole.count = count;
        whole.bounds = joined(a.bounds, b.bounds);
        whole.children.reserve(2);
        whole.children.push_back(std::move(a));
        whole.children.push_back(std::move(b));
        return whole;
    }

    /// The child whose box grows least by the crumb.
    static std::size_t nearestChild(const Part& part, const Part& crumb) {
        std::size_t best = 0;
        double leastGrowth = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < part.children.size(); ++i) {
            const Box& bounds = part.children[i].bounds;
            const double growth = surfaceOf(joined(bounds, crumb.bounds)) - surfaceOf(bounds);
            if (growth < leastGrowth) {
                best = i;
                leastGrowth = growth;
            }
        }
        return best;
    }

    [[nodiscard]] bool absorbs(const Part& part, const Part& crumb) const {
        const Part* at = &part;
        while (!at->children.empty()) at = &at->children[nearestChild(*at, crumb)];
        return at->count + crumb.count <= wanted_ + wanted_ / 2;
    }

    static void absorb(Part& part, const Part& crumb) {
        Part* at = &part;
        for (;;) {
            const std::size_t child = at->children.empty() ? 0 : nearestChild(*at, crumb);
            at->count += crumb.count;
            at->bounds.extend(crumb.bounds);
            if (at->children.empty()) break;
            at = &at->children[child];
        }
        const auto middle = static_cast<std::ptrdiff_t>(at->triangles.size());
        at->triangles.insert(at->triangles.end(), crumb.triangles.begin(), crumb.triangles.end());
        std::inplace_merge(at->triangles.begin(), at->triangles.begin() + middle, at->triangles.end());
    }

    const Mesh& mesh_;
    const level::Tree& tree_;
    std::size_t wanted_;
};

/// Just in front of the triangle: its centre lies on a plane of the tree, and the open side is the one to draw from.
Vec3 samplePoint(const Mesh& mesh, const MeshTriangle& triangle) {
    const auto at = [&](std::size_t i) { return mesh.vertices[triangle.vertices[i]].position; };
    const glm::dvec3 centre = (glm::dvec3(at(0)) + glm::dvec3(at(1)) + glm::dvec3(at(2))) / 3.0;
    const glm::dvec3 across = areaVector(at(0), at(1), at(2));
    const double size = glm::length(across);
    if (!(size > 0)) return {centre};
    // A quarter of a unit clears the planes of a level of the usual size, less has to do for smaller triangles.
    return {centre + across / size * std::min(0.25, 0.1 * std::sqrt(size))};
}

} // namespace

CellNode makeCells(const Mesh& mesh, const level::Level& level, std::size_t wanted) {
    std::map<std::uint32_t, std::vector<Sample>> models;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const MeshTriangle& triangle = mesh.triangles[t];
        const std::uint32_t model =
            triangle.surface < level.surfaces.size() ? level.surfaces[triangle.surface].model : 0U;
        models[model].push_back({samplePoint(mesh, triangle), static_cast<std::uint32_t>(t)});
    }
    const CellBuilder builder(mesh, level.tree, wanted);
    std::vector<CellNode> groups;
    groups.reserve(models.size());
    for (auto& [model, samples] : models)
        groups.push_back(toNode(model == 0 && !level.tree.nodes.empty() ? builder.byTree(samples, 0, 0)
                                                                        : builder.byHalves(samples, 0)));
    if (groups.empty()) return {};
    if (groups.size() == 1) return std::move(groups.front());
    CellNode root;
    root.children = std::move(groups);
    return root;
}

} // namespace pie::scene
