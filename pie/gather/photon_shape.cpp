#include "pie/gather/photon_shape.h"

#include "pie/gather/numbers.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace pie::gather {
namespace {

using glm::dvec2;

/// Mean and covariance.
struct Moments {
    dvec2 mean{0.0};
    double xx = 0, xy = 0, yy = 0;

    explicit Moments(std::span<const dvec2> points) {
        for (const dvec2& p : points) mean += p;
        mean /= static_cast<double>(points.size());
        for (const dvec2& p : points) {
            const dvec2 d = p - mean;
            xx += d.x * d.x;
            xy += d.x * d.y;
            yy += d.y * d.y;
        }
        const double scale = 1 / static_cast<double>(points.size() - 1);
        xx *= scale;
        xy *= scale;
        yy *= scale;
    }
    /// Unit vector along the larger principal component.
    [[nodiscard]] dvec2 axis() const {
        const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
        return {std::cos(angle), std::sin(angle)};
    }
    /// Variances along `axis` and across it.
    [[nodiscard]] dvec2 variances() const {
        const double middle = 0.5 * (xx + yy);
        const double half = std::hypot(0.5 * (xx - yy), xy);
        return {middle + half, std::max(0.0, middle - half)};
    }
};

} // namespace

bool PhotonShape::fit(AreaEstimate kind, std::span<const Vec3> offsets, const Frame& frame) {
    corners_.clear();
    onBorder_.assign(offsets.size(), 0);
    if (offsets.size() < fewestPoints) return false;
    points_.clear();
    if (kind == AreaEstimate::Box) {
        Box bounds;
        for (const Vec3& offset : offsets) bounds.extend(offset);
        const Vec3 size = bounds.size();
        int shortest = 2;
        for (const int axis : {1, 0})
            if (size[axis] < size[shortest]) shortest = axis;
        const int a = shortest == 0 ? 1 : 0;
        const int b = shortest == 2 ? 1 : 2;
        for (const Vec3& offset : offsets) points_.emplace_back(offset[a], offset[b]);
    } else {
        for (const Vec3& offset : offsets)
            points_.emplace_back(glm::dot(offset, frame.tangent), glm::dot(offset, frame.bitangent));
    }
    switch (kind) {
    case AreaEstimate::Box: rectangle({1.0, 0.0}); break;
    case AreaEstimate::OrientedBox: rectangle(Moments(points_).axis()); break;
    case AreaEstimate::Ellipse: ellipse(); break;
    case AreaEstimate::Hull: hull(); break;
    case AreaEstimate::Disc:
    case AreaEstimate::True: return false;
    }
    return area() > 0 && std::isfinite(area());
}

/// Around the points, with sides along the unit vector `u` and across it.
void PhotonShape::rectangle(const dvec2& u) {
    const dvec2 v(-u.y, u.x);
    dvec2 lower(std::numeric_limits<double>::max());
    dvec2 upper(std::numeric_limits<double>::lowest());
    for (const dvec2& p : points_) {
        const dvec2 at(glm::dot(p, u), glm::dot(p, v));
        lower = glm::min(lower, at);
        upper = glm::max(upper, at);
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const dvec2 at(glm::dot(points_[i], u), glm::dot(points_[i], v));
        if (at.x == lower.x || at.x == upper.x || at.y == lower.y || at.y == upper.y) onBorder_[i] = 1;
    }
    for (const dvec2& corner : {lower, dvec2(upper.x, lower.y), upper, dvec2(lower.x, upper.y)})
        corners_.push_back(corner.x * u + corner.y * v);
}

/// Uniform on an ellipse of semi-axis a, the variance along it is a²/4. A polygon of the same area stands for it.
void PhotonShape::ellipse() {
    constexpr int sides = 24;
    static const double outwards = std::sqrt(std::numbers::pi / (0.5 * sides * std::sin(2 * std::numbers::pi / sides)));
    const Moments moments(points_);
    const dvec2 variances = moments.variances();
    const dvec2 u = moments.axis() * (2 * outwards * std::sqrt(variances.x));
    const dvec2 v = dvec2(-moments.axis().y, moments.axis().x) * (2 * outwards * std::sqrt(variances.y));
    for (int i = 0; i < sides; ++i) {
        const double angle = 2 * std::numbers::pi * i / sides;
        corners_.push_back(moments.mean + std::cos(angle) * u + std::sin(angle) * v);
    }
}

/// Andrew's monotone chains.
void PhotonShape::hull() {
    order_.resize(points_.size());
    std::iota(order_.begin(), order_.end(), 0U);
    std::sort(order_.begin(), order_.end(), [&](std::uint32_t i, std::uint32_t j) {
        const dvec2& a = points_[i];
        const dvec2& b = points_[j];
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : i < j;
    });
    chain_.clear();
    const auto extend = [&](std::uint32_t next, std::size_t start) {
        while (chain_.size() >= start + 2) {
            const dvec2& last = points_[chain_.back()];
            const dvec2& before = points_[chain_[chain_.size() - 2]];
            if (cross(last - before, points_[next] - before) > 0) break;
            chain_.pop_back();
        }
        chain_.push_back(next);
    };
    for (const std::uint32_t i : order_) extend(i, 0);
    const std::size_t start = chain_.size() - 1;
    for (std::size_t i = order_.size() - 1; i-- > 0;) extend(order_[i], start);
    chain_.pop_back(); // the first again
    for (const std::uint32_t i : chain_) {
        corners_.push_back(points_[i]);
        onBorder_[i] = 1;
    }
}

double PhotonShape::area() const {
    double twice = 0;
    for (std::size_t i = 0; i < corners_.size(); ++i)
        twice += cross(corners_[i], corners_[i + 1 < corners_.size() ? i + 1 : 0]);
    return 0.5 * twice;
}

} // namespace pie::gather
