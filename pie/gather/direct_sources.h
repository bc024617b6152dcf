#pragma once
// What DirectLight knows about lights beyond lights::illuminate: a flat list of sources (every direction of a sky is
// one), a quick upper bound of each one's irradiance at a receiver, its unoccluded irradiance, and its sample rays.

#include "pie/core/vec.h"
#include "pie/gather/direct.h"
#include "pie/lights/light.h"

#include <cstdint>
#include <span>
#include <vector>

namespace pie::gather {

/// One light, or one direction of a sky.
struct Source {
    const lights::Light* light = nullptr;
    std::uint32_t number = 0;    ///< of the light
    std::uint32_t direction = 0; ///< SkyLight::towards
    unsigned samples = 1;        ///< rays it deserves at most
};

/// What bounds a source's irradiance, mean over channels, of absolute values. In arrays of its own for a quick loop.
struct SourceBound {
    Vec3 centre{0.0F};      ///< or, of parallel light, the direction towards it
    float spread = 0;       ///< radius about the centre that holds the source
    Vec3 facing{0.0F};      ///< normal of a one-sided polygon
    float intensity = 0;    ///< watts per steradian; of parallel light: irradiance face on
    float largest = 0;      ///< no receiver gets more
    float minDistance = 0;  ///< softened distance: max(this, sqrt(d² + extraSquared))
    float extraSquared = 0; ///< square units
    float cosineFactor = 1; ///< irradiance goes with min(1, factor · cosine); 0: no cosine at all
    float fade = 0;         ///< linear falloff: intensity − fade · d instead of the inverse square
    enum class Kind : std::uint8_t { Near, Polygon, TwoSidedPolygon, Parallel, Linear, None } kind = Kind::Near;
};

/// Where light is asked for.
struct Place {
    Vec3 position{0.0F};
    Vec3 inset{0.0F}; ///< stands in for the position where that lies in the very plane of a polygon light: a vertex at
                      ///< the border of a lamp is lit by it or is part of it, which only a point beside it can tell
    Vec3 normal{0.0F};
    bool twoSided = false;
    float shift = 0; ///< distance between the two
};

class Sources {
public:
    /// Points nearer than `onPlane` to the plane of a polygon are on it and get nothing from it.
    Sources(std::span<const lights::Light> lights, float softness, float onPlane);
    [[nodiscard]] std::size_t size() const { return sources_.size(); }
    [[nodiscard]] const Source& operator[](std::size_t i) const { return sources_[i]; }

    /// At least the mean channel of what the source gives unoccluded; 0 when it gives nothing.
    [[nodiscard]] float bound(std::size_t source, const Place& place) const;
    /// What it gives unoccluded, per channel.
    [[nodiscard]] Rgb unoccluded(std::size_t source, const Place& place) const;
    /// One way from the source to the receiver, as seen from `place.position` or, see Place, `place.inset`. `u` chooses
    /// the point of a soft source.
    [[nodiscard]] lights::Illumination sample(std::size_t source, const Place& place, const Vec2& u) const;
    /// Place of the source in an order in which neighbours stay close (Morton's curve). Draws that are even in this
    /// order are spread over space, and what blocks one light blocks its neighbours.
    [[nodiscard]] std::uint32_t rank(std::size_t source) const { return ranks_[source]; }
    /// Where `sample` and `unoccluded` look from.
    [[nodiscard]] Vec3 pointFor(std::size_t source, const Place& place) const;
    /// The sources of this light give nothing from now on.
    void mute(std::uint32_t light);
    [[nodiscard]] std::size_t bytes() const;

private:
    void makeRanks();
    void add(const lights::Light& light, std::uint32_t number, float softness);

    float onPlane_;
    std::vector<Source> sources_;
    std::vector<SourceBound> bounds_;
    std::vector<std::uint32_t> ranks_;
};

struct DirectLight::Context {
    const scene::Scene& scene;
    const intersect::Intersector& intersector;
    DirectOptions options;
    Sources sources;
    float offset = 1;
};

} // namespace pie::gather
