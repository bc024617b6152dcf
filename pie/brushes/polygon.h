#pragma once
// Convex polygons in a plane, cut by planes: the one operation that brushes, hidden faces and the tree are made of.

#include "pie/brushes/plane_set.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

namespace pie::brushes {

/// Corners of a convex polygon, counter-clockwise seen from where its plane faces. Eight corners have their place in
/// the polygon itself, as nearly all polygons of a level have no more: millions are cut, and none of them asks for
/// memory.
class Polygon {
public:
    using value_type = glm::dvec3;

    Polygon() = default;
    Polygon(std::initializer_list<glm::dvec3> corners) {
        for (const glm::dvec3& p : corners) add(p);
    }
    Polygon(const Polygon& other) : size_(other.size_), far_(other.far_) { copyNear(other); }
    Polygon(Polygon&& other) noexcept : size_(other.size_), far_(std::move(other.far_)) {
        copyNear(other);
        other.clear();
    }
    Polygon& operator=(const Polygon& other) {
        if (&other == this) return *this;
        size_ = other.size_;
        far_ = other.far_;
        copyNear(other);
        return *this;
    }
    Polygon& operator=(Polygon&& other) noexcept {
        if (&other == this) return *this;
        size_ = other.size_;
        far_ = std::move(other.far_);
        copyNear(other);
        other.clear();
        return *this;
    }
    ~Polygon() = default;

    void add(const glm::dvec3& corner) {
        if (size_ < near_.corners.size()) {
            near_.corners[size_++] = corner;
            return;
        }
        if (far_.empty()) far_.assign(near_.corners.begin(), near_.corners.end());
        far_.push_back(corner);
        ++size_;
    }
    void clear() {
        size_ = 0;
        far_.clear();
    }
    /// Keeps the first ones.
    void shorten(std::size_t size) {
        if (!far_.empty()) {
            far_.resize(size);
            if (size <= near_.corners.size()) {
                std::copy(far_.begin(), far_.end(), near_.corners.begin());
                far_.clear();
            }
        }
        size_ = size;
    }
    [[nodiscard]] bool empty() const { return size_ == 0; }
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] const glm::dvec3* begin() const { return far_.empty() ? near_.corners.data() : far_.data(); }
    [[nodiscard]] const glm::dvec3* end() const { return begin() + size_; }
    [[nodiscard]] glm::dvec3* begin() { return far_.empty() ? near_.corners.data() : far_.data(); }
    [[nodiscard]] glm::dvec3* end() { return begin() + size_; }
    [[nodiscard]] const glm::dvec3& operator[](std::size_t i) const { return begin()[i]; }
    [[nodiscard]] glm::dvec3& operator[](std::size_t i) { return begin()[i]; }
    [[nodiscard]] const glm::dvec3& front() const { return *begin(); }
    [[nodiscard]] const glm::dvec3& back() const { return begin()[size_ - 1]; }

private:
    void copyNear(const Polygon& other) {
        if (far_.empty()) std::copy_n(other.near_.corners.begin(), size_, near_.corners.begin());
    }

    /// Left as it is when a polygon is made: only what was added is read.
    union Near {
        Near() {} // NOLINT(modernize-use-equals-default): that would be deleted, or clear them
        std::array<glm::dvec3, 8> corners;
    };
    std::size_t size_ = 0;
    Near near_;
    std::vector<glm::dvec3> far_; ///< all corners, if there are more
};

/// Half the side of the square that stands for a whole plane; no brush may reach farther.
inline constexpr double worldHalf = 131072;
/// A point this near to a plane lies on it, units.
inline constexpr double onPlane = 1e-3;

/// A square of the plane that covers the world.
[[nodiscard]] Polygon wholePlane(const Plane& plane);
/// Where a polygon is, seen from a plane: less than `epsilon` beyond it counts as on it.
enum class Place : std::uint8_t { On, Front, Back, Both };
[[nodiscard]] Place placeOf(const Polygon& polygon, const Plane& plane, double epsilon = onPlane);
/// Cuts a polygon that is on both sides; elsewhere `front` and `back` stay as they are. They must be other objects than
/// `polygon`.
Place split(const Polygon& polygon, const Plane& plane, Polygon& front, Polygon& back, double epsilon = onPlane);
/// Keeps what lies behind the plane.
void keepBehind(Polygon& polygon, const Plane& plane, double epsilon = onPlane);
[[nodiscard]] double area(const Polygon& polygon);
/// Whether the polygon is worth keeping: it has an area and no side, however long, of no width.
[[nodiscard]] bool hasArea(const Polygon& polygon);
/// Joins polygons of one plane along common edges while the result stays convex.
void joinConvex(std::vector<Polygon>& polygons, const glm::dvec3& normal);

struct Bounds {
    glm::dvec3 lower{1e30}, upper{-1e30};
    void extend(const glm::dvec3& p);
    void extend(std::span<const glm::dvec3> points) {
        for (const glm::dvec3& p : points) extend(p);
    }
    [[nodiscard]] bool empty() const { return lower.x > upper.x; }
    /// Whether they have more in common than a border.
    [[nodiscard]] bool overlaps(const Bounds& other, double margin) const;
};

} // namespace pie::brushes
