#pragma once
// One batch of paths from a receiver, and the direct light that it gets from lights without extent. Internal to this
// folder.

#include "pie/reference/path_tracer.h"
#include "pie/reference/sources.h"
#include "pie/reference/visibility.h"
#include "pie/sampling/halton.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>

namespace pie::reference {

inline constexpr std::size_t pathsPerBatch = 128;

/// What all receivers share.
struct Shared {
    std::shared_ptr<const scene::Scene> scene;
    const intersect::Intersector& intersector;
    Options options;
    std::unique_ptr<const Sources> sources;
    std::unique_ptr<const ChoiceMap> map;
    sampling::Halton halton;
    float lift = 1; ///< how far off the surface receivers look from
};

/// A receiver (one side of it) before its paths: what it needs for choosing lights, and its sharp ones' light.
struct Start {
    Point point;
    Choice soft; ///< among the lights with extent
    bool anySoft = false;
    glm::dvec3 sharp{0.0}; ///< watts per square unit
    std::uint64_t address = 0;
};
[[nodiscard]] Start makeStart(const Shared& shared, const Vec3& position, const Vec3& normal, std::uint64_t address);

/// Mean over one batch, of soft direct and all indirect light.
[[nodiscard]] glm::dvec3 traceBatch(const Shared& shared, const Start& start, std::uint64_t batch);

/// Hash of anything.
[[nodiscard]] std::uint64_t mix(std::uint64_t a, std::uint64_t b);

} // namespace pie::reference
