#pragma once
// Direct light at receivers by shadow rays, from every kind of light.
//
// Each light is first taken unoccluded: exactly where there is a formula (points, spots, suns, sky directions, and
// polygons by their form factor), as the mean of many samples elsewhere. Rays then only measure which share gets
// through: E = unoccluded · Σ c V / Σ c over the samples' contributions c. A light in full view costs no noise; the
// ratio's bias is of the order of 1/samples inside penumbras.
//
// Levels have thousands of lights, of which a receiver sees few. Per receiver: a cheap bound per light; lights are
// shadow tested in falling order of their bounds until the bounds of the rest, the tail, are small against the light
// already seen; of the tail `tailSamples` are drawn in proportion to their bounds, so its expectation is right and its
// noise below `tolerance`. Soft lights get further rays in proportion to what they could give.
//
// Rays start at Receiver::inset, a small offset off the surface towards the light, and end as much short of the light:
// vertices lie exactly on neighbouring planes, emissive faces are part of the scene. Light is taken at
// Receiver::position (at the inset point for lamps in whose plane the position lies). A sky ray counts where the first
// thing that is not a filter is sky.
//
// What is noise in an answer comes with it, see `estimate` with variances: parts of soft lights that were not sampled,
// and lights of the tail that were not drawn. Everything else is exact.
//
// A receiver is computed once, when it is first asked for; every result depends on the scene, the lights and that
// receiver's position and normal only. When lights change: change() where they are few and change every frame, mute()
// where one of many goes out.

#include "pie/gather/gather.h"
#include "pie/intersect/intersector.h"
#include "pie/lights/light_set.h"
#include "pie/scene/receivers.h"
#include "pie/scene/scene.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace pie::gather {

/// With the defaults, a level of 1,122 area lights and a sun (kaos2) takes 250 rays per receiver and is 3.6 % off in
/// the root mean square, 1.4 % in the median and 0.0 % in the mean, where there is more than 1 U; all lights at 256
/// samples each would take 165,000.
struct DirectOptions {
    /// Standard error the tail may have at most, relative to the receiver's direct light. Smaller: more rays.
    float tolerance = 0.02F;
    /// Standard error that is always allowed, watts per square unit (U, of the 255 a lightmap byte holds): spares dark
    /// receivers the test of every light of the level.
    float absoluteTolerance = 0.25F;
    unsigned tailSamples = 64; ///< more: fewer lights have to be tested one by one
    /// A soft light that gives all the light gets this many rays, one that could give a tenth a tenth of them …
    unsigned softSamples = 64;
    float softness = 4; ///< … but no more than lights::sampleCount times this
    /// Every light with its full number of samples: the reference the rest is measured against.
    bool exhaustive = false;
    std::uint64_t seed = 0;
};

/// How far rays start off a surface and end before a light, units: 1, less in small scenes, more where floats are
/// coarser.
[[nodiscard]] float rayOffsetFor(const scene::Scene& scene);

class DirectLight final : public Estimator {
public:
    /// All references must outlive it.
    DirectLight(const scene::Scene& scene, const lights::LightSet& lights, const intersect::Intersector& intersector,
                const scene::Receivers& receivers, const DirectOptions& options = {});
    ~DirectLight() override;
    DirectLight(const DirectLight&) = delete;
    DirectLight& operator=(const DirectLight&) = delete;

    void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance) const override;
    /// The same, and, unless the span is empty, the variance of each answer's channel mean (of (r + g + b) / 3), (watts
    /// per square unit)². Costs
    /// no rays: it is estimated from those that were traced, and so is itself uncertain where they were few. On the
    /// safe side: soft sources count as sampled at random, which they are not (doc/algorithms/irradiance.md has how
    /// far).
    void estimate(std::span<const std::uint32_t> which, std::span<Rgb> irradiance, std::span<float> variance) const;
    /// Other lights from now on, which must outlive it as well; all answers are forgotten. Not while others ask.
    void change(const lights::LightSet& lights);
    /// This light gives nothing any more. Its part is taken out of the answers there are: exact but for rounding where
    /// it casts sharp shadows and was tested for certain, else as noisy as it was; such answers are rough() until
    /// refine(). `alone`: for the same receivers, of this light alone. Not while others ask.
    void mute(std::uint32_t light, const DirectLight& alone);
    [[nodiscard]] bool known(std::uint32_t receiver) const { return state_[receiver].load() >= Ready; }
    [[nodiscard]] bool rough(std::uint32_t receiver) const { return state_[receiver].load() == Rough; }
    /// Computes those of `which` that are rough as if they had been asked for first now. Not while others ask.
    void refine(std::span<const std::uint32_t> which);
    [[nodiscard]] std::string_view name() const override { return "direct"; }

    [[nodiscard]] std::uint64_t raysTraced() const { return rays_; }
    [[nodiscard]] std::uint64_t receiversComputed() const { return computed_; }
    [[nodiscard]] std::size_t bytes() const override;

    [[nodiscard]] float rayOffset() const; ///< rayOffsetFor(scene)
    [[nodiscard]] const DirectOptions& options() const;

    struct Context; ///< what all receivers share, see direct_sources.h

private:
    enum State : std::uint8_t { Unknown, BeingWritten, Ready, Rough };
    void compute(std::span<const std::uint32_t> which, std::span<Rgb> irradiance, std::span<float> variance) const;

    const scene::Receivers& receivers_;
    std::unique_ptr<Context> context_;
    /// Per receiver, a State.
    std::unique_ptr<std::atomic<std::uint8_t>[]> state_;
    std::unique_ptr<Rgb[]> irradiance_;
    std::unique_ptr<float[]> variance_;
    mutable std::atomic<std::uint64_t> rays_{0}, computed_{0};
};

} // namespace pie::gather
