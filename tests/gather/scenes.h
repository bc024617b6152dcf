#pragma once
// Small scenes made by hand, and points on them.

#include "pie/gather/gather.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <span>
#include <vector>

namespace pie::gather::test {

/// Triangles with materials, collected and then made into a Scene.
class SceneBuilder {
public:
    /// Numbers of materials for `quad` and `triangle`.
    std::uint32_t material(const scene::Material& material) {
        materials_.push_back(material);
        return static_cast<std::uint32_t>(materials_.size() - 1);
    }
    std::uint32_t grey(float reflectance) {
        scene::Material grey;
        grey.reflectance = Rgb(reflectance);
        return material(grey);
    }
    void triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::uint32_t material = 0) {
        corners_.insert(corners_.end(), {a, b, c});
        materialOf_.push_back(material);
    }
    /// Counter-clockwise from the front: normal along cross(u, v).
    void quad(const Vec3& origin, const Vec3& u, const Vec3& v, std::uint32_t material = 0) {
        triangle(origin, origin + u, origin + u + v, material);
        triangle(origin, origin + u + v, origin + v, material);
    }
    /// The inside of a box.
    void room(const Vec3& lower, const Vec3& upper, std::uint32_t material = 0) {
        const Vec3 s = upper - lower;
        const Vec3 x(s.x, 0.0F, 0.0F);
        const Vec3 y(0.0F, s.y, 0.0F);
        const Vec3 z(0.0F, 0.0F, s.z);
        quad(lower, x, y, material);     // floor, faces up
        quad(lower + z, y, x, material); // ceiling
        quad(lower, y, z, material);     // at low x, faces +x
        quad(lower + x, z, y, material); // at high x
        quad(lower, z, x, material);     // at low y, faces +y
        quad(lower + y, x, z, material); // at high y
    }
    [[nodiscard]] std::shared_ptr<const scene::Scene> make() const {
        std::vector<scene::Material> materials = materials_;
        if (materials.empty()) materials.emplace_back();
        return std::make_shared<const scene::Scene>(scene::makeScene(corners_, materialOf_, materials));
    }

private:
    std::vector<Vec3> corners_;
    std::vector<std::uint32_t> materialOf_;
    std::vector<scene::Material> materials_;
};

inline scene::Receiver receiverAt(const Vec3& position, const Vec3& normal, bool twoSided = false) {
    return {position, normal, position, twoSided};
}

inline scene::Receivers receiversAt(std::vector<scene::Receiver> points) {
    scene::Receivers receivers;
    receivers.points = std::move(points);
    return receivers;
}

inline std::vector<std::uint32_t> all(const scene::Receivers& receivers) {
    std::vector<std::uint32_t> which(receivers.points.size());
    for (std::uint32_t i = 0; i < which.size(); ++i) which[i] = i;
    return which;
}

inline float unit(std::mt19937& random) { return static_cast<float>(random() >> 8U) * 0x1p-24F; }
inline Vec3 unit3(std::mt19937& random) {
    const float x = unit(random);
    const float y = unit(random);
    return {x, y, unit(random)};
}
inline Vec3 direction(std::mt19937& random) {
    for (;;) {
        const Vec3 v = 2.0F * unit3(random) - 1.0F;
        const float length = glm::length(v);
        if (length > 0.1F && length <= 1.0F) return v / length;
    }
}

/// Uniform on all triangles of the scene; returns the triangle as well.
class SurfaceSampler {
public:
    explicit SurfaceSampler(const scene::Scene& scene) : scene_(scene) {
        for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
            total_ += 0.5 * static_cast<double>(glm::length(glm::cross(scene.corner(t, 1) - scene.corner(t, 0),
                                                                       scene.corner(t, 2) - scene.corner(t, 0))));
            cumulative_.push_back(total_);
        }
    }
    [[nodiscard]] double area() const { return total_; }
    std::pair<Vec3, std::uint32_t> operator()(std::mt19937& random) const {
        const double target = total_ * static_cast<double>(random()) * 0x1p-32;
        const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), target);
        const auto t = static_cast<std::size_t>(
            std::min<std::ptrdiff_t>(found - cumulative_.begin(), static_cast<std::ptrdiff_t>(cumulative_.size()) - 1));
        float u = unit(random);
        float v = unit(random);
        if (u + v > 1.0F) {
            u = 1.0F - u;
            v = 1.0F - v;
        }
        return {scene_.corner(t, 0) + u * (scene_.corner(t, 1) - scene_.corner(t, 0)) +
                    v * (scene_.corner(t, 2) - scene_.corner(t, 0)),
                static_cast<std::uint32_t>(t)};
    }

private:
    const scene::Scene& scene_;
    double total_ = 0;
    std::vector<double> cumulative_;
};

/// Of estimates whose mean channel is off by no more than their standard error.
inline double shareWithin(std::span<const Estimate> estimates, std::span<const Rgb> truth) {
    std::size_t within = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
        if (std::abs(meanChannel(estimates[i].irradiance) - meanChannel(truth[i])) <= estimates[i].standardError)
            ++within;
    return static_cast<double>(within) / static_cast<double>(truth.size());
}

/// Root mean square of the difference over that of `b`, mean over channels.
inline double relativeRms(const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
    double sum = 0;
    double whole = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const auto d = static_cast<double>(meanChannel(a[i]) - meanChannel(b[i]));
        sum += d * d;
        whole += static_cast<double>(meanChannel(b[i]) * meanChannel(b[i]));
    }
    return std::sqrt(sum / whole);
}

} // namespace pie::gather::test
