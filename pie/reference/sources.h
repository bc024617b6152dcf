#pragma once
// The lights as a flat list in which every direction of a sky is a light of its own, a guess of what each gives at a
// point, and the choice of one of them. Internal to this folder.

#include "pie/core/vec.h"
#include "pie/intersect/intersector.h"
#include "pie/lights/light.h"
#include "pie/scene/scene.h"

#include <cstdint>
#include <span>
#include <vector>

namespace pie::reference {

/// Where light is asked for, and towards which side.
struct Point {
    Vec3 position{0.0F};
    Vec3 normal{0.0F};
};

class Sources {
public:
    Sources(std::span<const lights::Light> lights, const scene::Scene& scene);
    [[nodiscard]] std::size_t size() const { return sources_.size(); }
    /// One sample: its mean over u is the unoccluded irradiance.
    [[nodiscard]] lights::Illumination sample(std::size_t source, const Point& point, const Vec2& u) const;
    /// True where every u gives the same way: one ray tells all.
    [[nodiscard]] bool sharp(std::size_t source) const { return sources_[source].sharp; }
    /// Roughly the channel mean of the unoccluded irradiance, of its absolute value. A guide for choices only.
    [[nodiscard]] double guess(std::size_t source, const Point& point) const;
    /// Where the way to a sample ends, moved off the face of a lamp: the lamp itself is part of the scene.
    [[nodiscard]] Vec3 end(std::size_t source, const Point& point, const lights::Illumination& way, float offset) const;
    /// Chance of each source where nothing is known about the place; all above zero.
    [[nodiscard]] std::span<const double> chances() const { return chances_; }

private:
    struct Source {
        const lights::Light* light = nullptr;
        Vec2 sky{-1.0F, 1.0F}; ///< u.x that stands for the direction of a sky, and one over the number of directions
        Vec3 centre{0.0F};     ///< of an area light
        float extent = 0;      ///< of it, about the centre
        bool sharp = true;
    };
    std::vector<lights::Light> lights_;
    std::vector<Source> sources_;
    std::vector<double> chances_;
};

/// Probabilities of a few sources by name and of the others by Sources::chances(): every source can be chosen.
class Choice {
public:
    struct Drawn {
        std::uint32_t source = 0;
        double chance = 0;
    };
    Choice() = default;
    /// Weights by source number, not negative.
    explicit Choice(std::span<const double> weights);
    /// `cumulativeOfAll`: sums of Sources::chances().
    [[nodiscard]] Drawn draw(std::span<const double> cumulativeOfAll, double u) const;

private:
    std::vector<std::uint32_t> numbers_; ///< ascending
    std::vector<double> cumulative_;     ///< ends with 1
};

/// Which light to ask at a point of the scene: choices by region and direction of the normal, from what sample points
/// on surfaces there see. Pure function of scene, lights and seed.
class ChoiceMap {
public:
    ChoiceMap(const scene::Scene& scene, const Sources& sources, const intersect::Intersector& intersector,
              std::uint64_t seed);
    [[nodiscard]] Choice::Drawn draw(const Point& point, double u) const;
    [[nodiscard]] std::span<const double> cumulative() const { return cumulative_; }

private:
    [[nodiscard]] std::size_t binOf(const Point& point) const;

    Vec3 lower_{0.0F};
    float cell_ = 1;
    glm::ivec3 cells_{1};
    std::vector<double> cumulative_;      ///< of Sources::chances()
    std::vector<std::uint32_t> choiceOf_; ///< by bin
    std::vector<Choice> choices_;
};

} // namespace pie::reference
