#pragma once
// The brushes, patches and models of a map by what moves together: the world first, then one part per brush entity.

#include "pie/brushes/brush.h"
#include "pie/brushes/map_shaders.h"
#include "pie/brushes/model.h"

#include <deque>
#include <string>
#include <vector>

namespace pie::brushes {

struct Part {
    std::size_t entity = 0; ///< MapText::entities
    std::vector<Brush> brushes;
    struct Curve {
        const PatchText* text = nullptr;
        std::uint32_t shader = 0; ///< MapShaders
    };
    std::vector<Curve> patches;
    struct Mesh {
        std::uint32_t shader = 0;          ///< MapShaders
        std::vector<ModelVertex> vertices; ///< in the world
        std::vector<std::uint32_t> indices;
        Bounds bounds;
    };
    std::vector<Mesh> meshes; ///< of models
    glm::dvec3 origin{0};     ///< where the part stands: the middle of its origin brushes, else its "origin"

    /// Of everything in it.
    [[nodiscard]] Bounds bounds() const;
};
[[nodiscard]] Bounds boundsOf(const PatchText& patch);

/// "func_group" holds brushes of the world together for the editor only.
[[nodiscard]] bool isGroup(const level::Entity& entity);

struct MapParts {
    std::deque<Part> parts; ///< empty: the map has no brush and no patch
    std::size_t brushes = 0, patches = 0;
};
/// Brushes without volume are left out, with a line in `warnings`. The map must outlive the parts.
[[nodiscard]] MapParts gatherParts(const MapText& map, const std::string& fileName, PlaneSet& planes,
                                   MapShaders& shaders, std::vector<std::string>& warnings);

} // namespace pie::brushes
