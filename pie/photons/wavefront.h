#pragma once
// One chunk of the tracer: the paths of consecutive photon indices advance together, one intersector call per step.
// Internal to this folder.

#include "pie/photons/tracer.h"

#include <array>
#include <bit>

namespace pie::photons {

/// What the tracer asks about a hit, packed: a hit costs one cache line of faces, and all materials stay in the cache.
struct Surroundings {
    struct Face {
        Vec3 normal{0.0F};
        std::uint32_t material = 0;
    };
    struct Matter {
        Rgb reflectance{0.0F}; ///< 0 to 1
        scene::Interaction interaction = scene::Interaction::Opaque;
        bool twoSided = false;
    };
    explicit Surroundings(const scene::Scene& scene);

    std::vector<Face> faces;
    std::vector<Matter> matter;
    float reach = 0; ///< largest coordinate of the scene
};

struct WavefrontResult {
    std::vector<Photon> photons;       ///< in the order of tracing: step by step
    std::vector<std::uint32_t> owner;  ///< index of each, from the chunk's first
    std::vector<std::uint32_t> places; ///< memory of writeTo
    std::size_t indices = 0;
    TraceCounts counts;

    /// Writes the photons in index order, those of an index in the order of their bounces, and numbers them.
    void writeTo(Photon* out, std::uint32_t firstId);
};

/// Children of a hit that splits in full.
[[nodiscard]] std::uint32_t splitChildren(const TracerOptions& options);

class Wavefront {
public:
    /// `total`: photons of the whole frame, by which flux is divided.
    Wavefront(const scene::Scene& scene, const lights::LightSet& lights, const intersect::Intersector& intersector,
              const TracerOptions& options, const sampling::Sequence& emission, const sampling::Sequence& reflection,
              const Surroundings& surroundings, std::uint64_t total);
    void run(std::uint64_t first, std::size_t count, WavefrontResult& result) const;
    /// Paths an index can branch into.
    [[nodiscard]] std::size_t widest() const { return splits_ == 0 ? 1 : branches_[splits_ - 1].paths; }

private:
    struct Path {
        Rgb flux{0.0F};
        std::uint32_t owner = 0;                    ///< index, from the chunk's first
        std::uint32_t branch = 0;                   ///< number among the paths of its index at this bounce
        std::uint32_t bounce = 0;                   ///< reflections so far
        std::uint32_t crossings = 0;                ///< hits passed since the last reflection
        std::uint32_t from = intersect::noTriangle; ///< triangle that the ray left
    };
    struct Step;
    /// Splitting: children of a hit at this depth, and paths of one index after it.
    struct Branching {
        std::uint32_t children = 1, paths = 1;
    };

    void emit(Step& step, std::uint64_t first, std::size_t count) const;
    [[nodiscard]] float offsetAt(const Vec3& origin) const;
    /// `Numbers`: what `reflection_` holds.
    template <class Numbers> void advance(Step& step, const Numbers& numbers) const;
    template <class Numbers>
    void meet(Step& step, Path& path, const intersect::Ray& ray, const intersect::Hit& hit,
              const Numbers& numbers) const;
    [[nodiscard]] bool passes(Step& step, Path& path, const intersect::Hit& hit) const;
    /// The same ray again, from behind `t` by this share of it.
    void goOn(Step& step, Path path, const intersect::Ray& ray, float t, float share) const;
    template <class Numbers>
    void reflect(Step& step, const Path& path, const Vec3& normal, const Vec3& origin, const Rgb& reflectance,
                 const Numbers& numbers) const;
    /// Rays that were reflected in a square's numbers get their directions, many at a time.
    static void turn(Step& step);
    /// `direction`: about +z, turned to the normal here.
    static void send(Step& step, const Path& path, const Frame& surface, const Vec3& origin, const Vec3& direction);

    const scene::Scene& scene_;
    const lights::LightSet& lights_;
    const intersect::Intersector& intersector_;
    const TracerOptions& options_;
    const sampling::Sequence& emission_;
    const sampling::Sequence& reflection_;
    const Surroundings& surroundings_;
    float perPhoton_;                                                   ///< one over the photons of the frame
    std::array<Branching, std::bit_width(maxPathsPerPhoton)> branches_; ///< each at least doubles the paths
    std::size_t splits_ = 0;                                            ///< of `branches_`
};

} // namespace pie::photons
