#pragma once
// A scene with lights and an intersector that live as long as their tracer.

#include "pie/photons/tracer.h"
#include "tests/lights/rooms.h"

namespace pie::test {

class Traced {
public:
    Traced(std::shared_ptr<const scene::Scene> scene, std::vector<lights::Light> lights,
           const photons::TracerOptions& options = {}, intersect::Kind kind = intersect::Kind::Embree)
        : scene_(std::move(scene)), lights_(std::move(lights), scene_),
          intersector_(intersect::makeIntersector(kind, *scene_, {})),
          tracer_(*scene_, lights_, *intersector_, options) {}

    [[nodiscard]] std::vector<photons::Photon> trace(std::uint64_t first, std::uint64_t count) {
        std::vector<photons::Photon> out;
        counts = tracer_.trace(first, count, out);
        return out;
    }
    [[nodiscard]] const photons::PhotonTracer& tracer() const { return tracer_; }
    [[nodiscard]] const scene::Scene& scene() const { return *scene_; }
    [[nodiscard]] const lights::LightSet& lights() const { return lights_; }

    photons::TraceCounts counts; ///< of the last trace()

private:
    std::shared_ptr<const scene::Scene> scene_;
    lights::LightSet lights_;
    std::unique_ptr<intersect::Intersector> intersector_;
    photons::PhotonTracer tracer_;
};

inline std::shared_ptr<const scene::Scene> furnace(const Rgb& reflectance, float side = 100.0F,
                                                   const Vec3& at = Vec3(0.0F)) {
    RoomBuilder room;
    const auto wall = room.material(opaque(reflectance));
    room.inside(at, at + Vec3(side), {wall, wall, wall, wall, wall, wall});
    return room.build();
}

inline photons::TracerOptions roulette(bool direct, unsigned depth) {
    photons::TracerOptions options;
    options.storeDirectLight = direct;
    options.recursionDepth = depth;
    return options;
}
inline photons::TracerOptions splitting(unsigned children, bool direct, unsigned depth) {
    photons::TracerOptions options = roulette(direct, depth);
    options.scattering = photons::TracerOptions::Scattering::Splitting;
    options.diffuseReflections = children;
    return options;
}

} // namespace pie::test
