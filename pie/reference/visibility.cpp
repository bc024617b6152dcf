#include "pie/reference/visibility.h"

#include "pie/lights/light.h"

#include <cmath>
#include <limits>

namespace pie::reference {
namespace {

using intersect::Hit;
using intersect::Ray;

constexpr int mostFilters = 256;

/// The product of the filters up to the front of a sky; 0 where anything else comes first.
class ToSky {
public:
    ToSky(const intersect::Intersector& intersector, const scene::Scene& scene, ShadowRays& shadows)
        : intersector_(intersector), scene_(scene), shadows_(shadows) {
        for (std::uint32_t i = 0; i < shadows.rays.size(); ++i)
            if (shadows.toSky[i] != 0) {
                shadows.through[i] = Rgb(1.0F);
                travelling_.push_back({i, shadows.rays[i]});
            }
        for (int layer = 0; layer < mostFilters && !travelling_.empty(); ++layer) step();
        for (const Traveller& left : travelling_) shadows.through[left.number] = Rgb(0.0F);
    }

private:
    struct Traveller {
        std::uint32_t number = 0;
        Ray ray;
        std::uint32_t last = intersect::noTriangle;
    };

    void step() {
        rays_.clear();
        for (const Traveller& traveller : travelling_) rays_.push_back(traveller.ray);
        hits_.assign(rays_.size(), Hit{});
        intersector_.closest(rays_, hits_);
        std::vector<Traveller> next;
        for (std::size_t i = 0; i < rays_.size(); ++i) meet(travelling_[i], hits_[i], next);
        travelling_.swap(next);
    }

    void meet(Traveller traveller, const Hit& hit, std::vector<Traveller>& next) {
        Rgb& through = shadows_.through[traveller.number];
        const scene::Interaction kind =
            hit.found() ? scene_.material(hit.triangle).interaction : scene::Interaction::Opaque;
        if (kind == scene::Interaction::Opaque) {
            through = Rgb(0.0F);
        } else if (kind == scene::Interaction::Sky) {
            if (glm::dot(scene_.normals[hit.triangle], traveller.ray.direction) >= 0.0F) through = Rgb(0.0F);
        } else {
            const bool again = hit.triangle == traveller.last;
            if (!again) through *= scene_.transmittance(hit.triangle, hit.u, hit.v);
            traveller.last = hit.triangle;
            traveller.ray.tMin = behind(hit.t, again);
            if (maxChannel(through) > 0.0F) next.push_back(traveller);
        }
    }

    const intersect::Intersector& intersector_;
    const scene::Scene& scene_;
    ShadowRays& shadows_;
    std::vector<Traveller> travelling_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
};

} // namespace

void trace(const intersect::Intersector& intersector, const scene::Scene& scene, ShadowRays& shadows) {
    shadows.through.assign(shadows.rays.size(), Rgb(0.0F));
    std::vector<Ray> finite;
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < shadows.rays.size(); ++i)
        if (shadows.toSky[i] == 0) {
            finite.push_back(shadows.rays[i]);
            numbers.push_back(i);
        }
    if (!finite.empty()) {
        std::vector<Rgb> through(finite.size());
        intersect::transmittance(intersector, scene, finite, through);
        for (std::size_t i = 0; i < finite.size(); ++i) shadows.through[numbers[i]] = through[i];
    }
    if (finite.size() < shadows.rays.size()) ToSky(intersector, scene, shadows);
}

float offsetAt(const scene::Scene& scene, const Vec3& point) {
    return lights::surfaceOffset(lights::largestCoordinate(scene.bounds, point));
}

float behind(float t, bool again) {
    return std::nextafter(t + (again ? 1e-4F : 1e-6F) * t, std::numeric_limits<float>::infinity());
}

} // namespace pie::reference
