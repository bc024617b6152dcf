#pragma once
// Gathers the records of a BSP file: faces with their corners, brushes with the sides the game's collision wants.

#include "pie/brushes/brush.h"
#include "pie/brushes/chained_index.h"
#include "pie/brushes/map_parts.h"
#include "pie/brushes/map_shaders.h"
#include "pie/brushes/visible.h"
#include "pie/level/bsp.h"

#include <vector>

namespace pie::brushes {

class BspWriter {
public:
    BspWriter(PlaneSet& planes, MapShaders& shaders) : planes_(planes), shaders_(shaders) {}

    /// `origin` is where the model will stand: its corners are written relative to it.
    void addPolygon(const Polygon& polygon, const Side& side, const FaceText& text, const glm::dvec3& origin,
                    std::int32_t effect);
    void addPatch(const PatchText& patch, std::uint32_t shader, const glm::dvec3& origin, std::int32_t effect);
    /// In pieces of as many corners as the game can draw at once.
    void addMesh(const Part::Mesh& mesh, const glm::dvec3& origin, std::int32_t effect);
    /// Number of the brush in the file.
    std::int32_t addBrush(const Brush& brush, const glm::dvec3& origin);
    /// Number of a map shader in the file.
    std::int32_t shader(std::uint32_t mapShader);

    level::Bsp bsp;

private:
    PlaneSet& planes_;
    MapShaders& shaders_;
    std::vector<std::int32_t> places_; ///< of map shaders in the file; -1: not used so far
    std::vector<glm::dvec3> corners_;  ///< that were written so far
    ChainedIndex cells_;               ///< of a fine grid

    [[nodiscard]] glm::dvec3 weld(const glm::dvec3& p);
};

} // namespace pie::brushes
