#include "pie/gather/area.h"

#include "pie/core/parallel.h"
#include "pie/gather/area_shape.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace pie::gather {
namespace {

using glm::dvec2;
using glm::dvec3;

/// A triangle clipped by the two planes of the slice has at most five corners.
struct Polygon {
    std::array<dvec3, 8> corners;
    std::size_t count = 0;
};

/// Keeps the part with dot(p, normal) · sign <= limit.
void clip(Polygon& polygon, const dvec3& normal, double sign, double limit) {
    Polygon kept;
    for (std::size_t i = 0; i < polygon.count; ++i) {
        const dvec3& a = polygon.corners[i];
        const dvec3& b = polygon.corners[i + 1 < polygon.count ? i + 1 : 0];
        const double da = limit - sign * glm::dot(a, normal);
        const double db = limit - sign * glm::dot(b, normal);
        if (da >= 0) kept.corners[kept.count++] = a;
        if ((da > 0 && db < 0) || (da < 0 && db > 0)) kept.corners[kept.count++] = a + (b - a) * (da / (da - db));
    }
    polygon = kept;
}

float squaredDistance(const Box& box, const Vec3& point) {
    const Vec3 outside = glm::max(glm::max(box.lower - point, point - box.upper), Vec3(0.0F));
    return glm::dot(outside, outside);
}

/// Numbers of triangles that repeat an earlier one: same corners, same facing.
std::vector<bool> findDuplicates(const scene::Scene& scene) {
    const auto key = [&](std::uint32_t t) {
        std::array<std::uint32_t, 3> v = scene.triangles[t].vertices;
        std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
        return v;
    };
    std::vector<std::uint32_t> order(scene.triangles.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const auto ka = key(a);
        const auto kb = key(b);
        return ka < kb || (ka == kb && a < b);
    });
    std::vector<bool> duplicate(order.size(), false);
    for (std::size_t i = 1; i < order.size(); ++i) duplicate[order[i]] = key(order[i]) == key(order[i - 1]);
    return duplicate;
}

/// A polygon in its own plane, as seen from the receiver.
struct Flat {
    std::array<dvec2, 8> corners;
    std::size_t count = 0;
    double height = 0;    ///< of the plane from the receiver
    double areaScale = 1; ///< square units of the polygon per square unit of `corners`

    [[nodiscard]] std::span<const dvec2> span() const { return {corners.data(), count}; }
};

/// The polygon as it is.
Flat flatten(const Polygon& polygon, const dvec3& normal) {
    Flat flat;
    const Frame frame{Vec3(normal)};
    const dvec3 u = glm::normalize(dvec3(frame.tangent) - normal * glm::dot(normal, dvec3(frame.tangent)));
    const dvec3 v = glm::cross(normal, u);
    flat.count = polygon.count;
    for (std::size_t i = 0; i < polygon.count; ++i)
        flat.corners[i] = {glm::dot(polygon.corners[i], u), glm::dot(polygon.corners[i], v)};
    if (polygon.count > 0) flat.height = glm::dot(polygon.corners[0], normal);
    return flat;
}

/// Its shadow along `up`, of which the polygon is 1/|cosine| times as large: what a cylinder's kernel sees.
Flat project(const Polygon& polygon, const dvec3& normal, const dvec3& up) {
    const double cosine = glm::dot(normal, up);
    if (!(std::abs(cosine) > 1e-6)) return {};
    Flat flat = flatten(polygon, cosine > 0 ? up : -up);
    flat.height = 0;
    flat.areaScale = 1 / std::abs(cosine);
    return flat;
}

/// Stretched along `up`, so that an ellipsoid about the receiver becomes a ball.
Flat stretch(const Polygon& polygon, const dvec3& normal, const dvec3& up, double factor) {
    Polygon stretched = polygon;
    for (std::size_t i = 0; i < polygon.count; ++i)
        stretched.corners[i] += (factor - 1) * glm::dot(polygon.corners[i], up) * up;
    // Areas as vectors: the part along `up` is that of the shadow, which stays; the rest grows.
    const double along = glm::dot(normal, up);
    const dvec3 area = along * up + factor * (normal - along * up);
    const double length = glm::length(area);
    Flat flat = flatten(stretched, area / length);
    flat.areaScale = 1 / length;
    return flat;
}

float usableRadius(const scene::Scene& scene, float wanted) {
    const float diagonal = glm::length(scene.bounds.size());
    if (!(wanted > 0.0F)) return 0.0F;
    return diagonal > 0.0F ? std::min(wanted, diagonal) : wanted;
}

} // namespace

Vec3 litNormal(const scene::Scene& scene, const photons::Photon& photon) {
    const Vec3& normal = scene.normals[photon.triangle];
    if (!scene.material(photon.triangle).twoSided) return normal;
    return glm::dot(photon.direction, normal) > 0.0F ? -normal : normal;
}

/// The sides of triangles that can store photons, by visibility cell.
struct TrueArea::Pieces {
    scene::Scene scene;
    std::vector<std::uint8_t> cells; ///< by triangle

    static std::unique_ptr<const Pieces> make(const scene::Scene& whole, const maps::Partition* partition);
};

std::unique_ptr<const TrueArea::Pieces> TrueArea::Pieces::make(const scene::Scene& whole,
                                                               const maps::Partition* partition) {
    if (partition == nullptr || partition->cells() < 2) return nullptr;
    auto pieces = std::make_unique<Pieces>();
    std::vector<Vec3> corners;
    std::vector<Vec3> normals;
    std::vector<std::uint32_t> materials;
    const auto cut = [&](std::uint32_t t, bool back) {
        for (const auto& piece : partition->cut(t, back))
            for (std::size_t i = 2; i < piece.corners.size(); ++i) {
                corners.insert(corners.end(), {Vec3(piece.corners[0]), Vec3(piece.corners[back ? i : i - 1]),
                                               Vec3(piece.corners[back ? i - 1 : i])});
                normals.push_back(back ? -whole.normals[t] : whole.normals[t]);
                materials.push_back(whole.triangles[t].material);
                pieces->cells.push_back(static_cast<std::uint8_t>(piece.cell));
            }
    };
    for (std::uint32_t t = 0; t < whole.triangles.size(); ++t) {
        if (whole.normals[t] == Vec3(0.0F)) continue;
        cut(t, false);
        if (whole.material(t).twoSided) cut(t, true);
    }
    std::vector<scene::Material> oneSided = whole.materials;
    for (scene::Material& material : oneSided) material.twoSided = false;
    pieces->scene = scene::makeScene(corners, materials, std::move(oneSided));
    // Those of slivers would be rounding; photons are judged by those of the whole.
    pieces->scene.normals = std::move(normals);
    return pieces;
}

TrueArea::TrueArea(const scene::Scene& whole, Kernel kernel, const SliceOptions& slice, float maxRadius,
                   SearchVolume volume, std::shared_ptr<const maps::Partition> partition)
    : partition_(std::move(partition)), pieces_(Pieces::make(whole, partition_.get())),
      scene_(pieces_ ? pieces_->scene : whole), kernel_(kernel), volume_(volume), slice_(slice),
      maxRadius_(usableRadius(whole, maxRadius)) {
    const scene::Scene& scene = scene_;
    if (volume_ == SearchVolume::Sphere) {
        volume_ = SearchVolume::Slice;
        slice_.halfThickness = std::numeric_limits<float>::infinity();
    }
    // Cells about as wide as the ball, but no more of them than a few per triangle.
    const Vec3 size = scene.bounds.size();
    const float widest = std::max({size.x, size.y, size.z});
    const auto triangles = static_cast<float>(std::max<std::size_t>(scene.triangles.size(), 1));
    const float perAxis = std::clamp(std::ceil(2.0F * std::cbrt(triangles)), 1.0F, 256.0F);
    cellSize_ = std::max({maxRadius_ * 0.5F, widest / perAxis, std::numeric_limits<float>::min()});
    for (std::size_t axis = 0; axis < 3; ++axis)
        counts_[axis] =
            static_cast<std::uint32_t>(std::clamp(size[static_cast<int>(axis)] / cellSize_, 0.0F, 255.0F)) + 1;

    outlines_.resize(scene.triangles.size());
    const std::vector<bool> duplicate = findDuplicates(scene);
    std::vector<std::uint32_t> storing;
    for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
        Outline& outline = outlines_[t];
        for (int i = 0; i < 3; ++i) outline.box.extend(scene.corner(t, i));
        outline.normal = scene.normals[t];
        outline.twoSided = scene.material(t).twoSided;
        if (pieces_) outline.cell = pieces_->cells[t];
        const GridCells cells = cellsOf(outline.box);
        for (std::size_t axis = 0; axis < 3; ++axis)
            outline.firstCell[axis] = static_cast<std::uint8_t>(cells.first[axis]);
        if (!duplicate[t] && scene.material(t).interaction != scene::Interaction::Sky && scene.normals[t] != Vec3(0.0F))
            storing.push_back(static_cast<std::uint32_t>(t));
    }

    // Count, then place: cellBegin_[c] is where the list of cell c begins.
    cellBegin_.assign(std::size_t{counts_[0]} * counts_[1] * counts_[2] + 1, 0);
    const auto forEachCell = [&](std::uint32_t triangle, const auto& visit) {
        const GridCells cells = cellsOf(outlines_[triangle].box);
        for (std::uint32_t z = cells.first[2]; z <= cells.last[2]; ++z)
            for (std::uint32_t y = cells.first[1]; y <= cells.last[1]; ++y)
                for (std::uint32_t x = cells.first[0]; x <= cells.last[0]; ++x)
                    visit((std::size_t{z} * counts_[1] + y) * counts_[0] + x);
    };
    for (const std::uint32_t t : storing) forEachCell(t, [&](std::size_t cell) { ++cellBegin_[cell + 1]; });
    std::partial_sum(cellBegin_.begin(), cellBegin_.end(), cellBegin_.begin());
    cellTriangles_.resize(cellBegin_.back());
    std::vector<std::uint32_t> next(cellBegin_.begin(), cellBegin_.end() - 1);
    for (const std::uint32_t t : storing) forEachCell(t, [&](std::size_t cell) { cellTriangles_[next[cell]++] = t; });
}

TrueArea::GridCells TrueArea::cellsOf(const Box& box) const {
    GridCells cells;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<int>(axis);
        const auto last = static_cast<float>(counts_[axis] - 1);
        const auto at = [&](float x) {
            return static_cast<std::uint32_t>(std::clamp((x - scene_.bounds.lower[i]) / cellSize_, 0.0F, last));
        };
        cells.first[axis] = at(box.lower[i]);
        cells.last[axis] = at(box.upper[i]);
    }
    return cells;
}

/// The same test as SurfaceTest: of a two-sided surface, whichever side faces along the normal.
bool TrueArea::faces(std::uint32_t triangle, const Vec3& normal) const {
    const Outline& outline = outlines_[triangle];
    const float cosine = glm::dot(outline.normal, normal);
    return (outline.twoSided ? std::abs(cosine) : cosine) > slice_.minCosine;
}

/// Each triangle that faces along the normal and whose cells meet those of the box, once: in the first cell that both
/// share.
template <class Visit> void TrueArea::forEachFacing(const Box& box, const Vec3& normal, const Visit& visit) const {
    const GridCells cells = cellsOf(box);
    for (std::uint32_t z = cells.first[2]; z <= cells.last[2]; ++z)
        for (std::uint32_t y = cells.first[1]; y <= cells.last[1]; ++y)
            for (std::uint32_t x = cells.first[0]; x <= cells.last[0]; ++x) {
                const std::size_t cell = (std::size_t{z} * counts_[1] + y) * counts_[0] + x;
                for (std::uint32_t i = cellBegin_[cell]; i < cellBegin_[cell + 1]; ++i) {
                    const std::uint32_t triangle = cellTriangles_[i];
                    const auto& first = outlines_[triangle].firstCell;
                    if (faces(triangle, normal) && x == std::max<std::uint32_t>(cells.first[0], first[0]) &&
                        y == std::max<std::uint32_t>(cells.first[1], first[1]) &&
                        z == std::max<std::uint32_t>(cells.first[2], first[2]))
                        visit(triangle);
                }
            }
}

TrueArea::~TrueArea() = default;

TrueArea::Cells TrueArea::cellsSeenFrom(const scene::Receiver& at) const {
    return pieces_ ? partition_->cellsSeenFrom(at) : allCells;
}

void TrueArea::integrals(const Vec3& point, const Vec3& normal, std::span<const float> radii,
                         std::span<double> integrals, Cells cells) const {
    std::fill(integrals.begin(), integrals.end(), 0.0);
    float largest = 0;
    for (const float radius : radii) largest = std::max(largest, radius);
    if (cellTriangles_.empty() || !(largest > 0.0F) || !(glm::dot(point, point) >= 0.0F)) return;

    const auto thickness = static_cast<double>(slice_.halfThickness);
    const dvec3 centre(point);
    const dvec3 up(normal);
    const float extent = extentSquared(largest);
    const Vec3 reach(std::sqrt(extent));
    forEachFacing({point - reach, point + reach}, normal, [&](std::uint32_t t) {
        if ((cells >> outlines_[t].cell & 1U) == 0 || squaredDistance(outlines_[t].box, point) >= extent) return;

        Polygon polygon;
        double lowest = std::numeric_limits<double>::max();
        double highest = std::numeric_limits<double>::lowest();
        for (int i = 0; i < 3; ++i) {
            const dvec3 corner = dvec3(scene_.corner(t, i)) - centre;
            polygon.corners[polygon.count++] = corner;
            lowest = std::min(lowest, glm::dot(corner, up));
            highest = std::max(highest, glm::dot(corner, up));
        }
        if (lowest > thickness || highest < -thickness) return;

        const dvec3 facing =
            glm::cross(polygon.corners[1] - polygon.corners[0], polygon.corners[2] - polygon.corners[0]);
        const double twiceArea = glm::length(facing);
        if (!(twiceArea > 0)) return;
        const dvec3 n = facing / twiceArea;
        if (highest > thickness) clip(polygon, up, 1, thickness);
        if (lowest < -thickness) clip(polygon, up, -1, thickness);

        const auto add = [&](const Flat& flat, const FlatPolygon& shape, std::size_t i) {
            const PlaneKernel kernel{kernel_, flat.height, static_cast<double>(radii[i])};
            integrals[i] += flat.areaScale * std::max(0.0, shape.integral(kernel));
        };
        if (volume_ == SearchVolume::Ellipsoid) {
            for (std::size_t i = 0; i < radii.size(); ++i) {
                const auto radius = static_cast<double>(radii[i]);
                const Flat flat = stretch(polygon, n, up, radius / std::clamp(thickness, 1e-3 * radius, radius));
                add(flat, FlatPolygon(flat.span()), i);
            }
            return;
        }
        const Flat flat = volume_ == SearchVolume::Cylinder ? project(polygon, n, up) : flatten(polygon, n);
        const FlatPolygon shape(flat.span());
        for (std::size_t i = 0; i < radii.size(); ++i) add(flat, shape, i);
    });
}

float TrueArea::extentSquared(float radius) const {
    const float thick = volume_ == SearchVolume::Cylinder ? slice_.halfThickness : 0.0F;
    return radius * radius + thick * thick;
}

double TrueArea::integral(const Vec3& point, const Vec3& normal, float radius, Cells cells) const {
    double result = 0;
    integrals(point, normal, {&radius, 1}, {&result, 1}, cells);
    return result;
}

std::size_t TrueArea::bytes() const {
    return cellBegin_.capacity() * sizeof(std::uint32_t) + cellTriangles_.capacity() * sizeof(std::uint32_t) +
           outlines_.capacity() * sizeof(Outline) +
           (pieces_ ? scene_.triangles.size() * (sizeof(scene::Triangle) + sizeof(Vec3) + 1) +
                          scene_.positions.size() * sizeof(Vec3)
                    : 0);
}

} // namespace pie::gather
