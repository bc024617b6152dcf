#pragma once
// One receiver's direct light as a small state machine, so that the rays of many receivers are traced together: each
// round every job adds the rays it needs, all are traced, and every job takes its answers.

#include "pie/gather/direct_sources.h"
#include "pie/scene/receivers.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace pie::gather {

/// Rays of one round with their answers.
struct RayBatch {
    std::vector<intersect::Ray> rays;
    std::vector<std::uint8_t> needsSky;
    std::vector<Rgb> through;
};

class DirectJob {
public:
    DirectJob(const DirectLight::Context& context, const scene::Receiver& receiver);
    /// Adds the rays of this round; false: none, the job is done.
    bool request(RayBatch& batch);
    /// Takes the answers to its rays.
    void absorb(const RayBatch& batch);
    [[nodiscard]] Rgb irradiance() const;
    /// Of the channel mean of irradiance(), from the samples that were drawn; see direct_variance.cpp.
    [[nodiscard]] double variance() const;

private:
    enum class Stage : std::uint8_t { Head, Soft, Tail, Done };
    /// A source under test, and what its rays have shown.
    struct Tested {
        std::uint32_t source = 0;
        unsigned samples = 0; ///< taken so far
        Rgb unoccluded{0.0F};
        double weight = 1;        ///< of the tail: 1 / expected number of draws
        glm::dvec3 through{0};    ///< Σ c V
        double contributions = 0; ///< Σ c
        unsigned draws = 0;       ///< of the tail that chose it; 0: tested for certain
        [[nodiscard]] glm::dvec3 seen() const {
            return contributions > 0 ? weight * glm::dvec3(unoccluded) * through / contributions : glm::dvec3(0);
        }
    };
    struct Asked {
        std::uint32_t tested = 0; ///< tested_
        std::uint32_t ray = 0;
        float contribution = 0;
    };
    /// What one ray to a soft source, or to one of the tail, has shown.
    struct Drawn {
        std::uint32_t tested = 0;
        double contribution = 0;
        double through = 0; ///< channel mean of the light that arrives if all of the source is seen through this ray
    };
    struct Bounded {
        float bound = 0;
        std::uint32_t source = 0;
        friend bool operator<(const Bounded& a, const Bounded& b) {
            return a.bound < b.bound || (a.bound == b.bound && a.source > b.source);
        }
    };

    void bound();
    void takeHead(RayBatch& batch);
    void refineSoft(RayBatch& batch);
    void drawTail(RayBatch& batch);
    void test(std::uint32_t source, double weight, unsigned samples, RayBatch& batch);
    void ask(std::uint32_t tested, unsigned samples, RayBatch& batch);
    [[nodiscard]] double tailAllowed(double seen) const;
    [[nodiscard]] static double varianceWithin(std::span<const Drawn> drawn);
    [[nodiscard]] double varianceOfSingles(std::vector<Drawn> singles) const;
    [[nodiscard]] double varianceOfTail() const;
    [[nodiscard]] double seen() const;
    [[nodiscard]] float hash(std::uint64_t dimension) const;

    const DirectLight::Context& context_;
    Place place_;
    std::uint64_t
        address_; ///< hash of position and normal: randomness depends on where the receiver is, not its number
    Stage stage_ = Stage::Head;
    std::vector<Bounded> waiting_; ///< a heap, largest bound on top
    double tail_ = 0;              ///< sum of the bounds that wait
    std::vector<Tested> tested_;
    std::vector<Asked> asked_;
    std::vector<Drawn> drawn_;
};

} // namespace pie::gather
