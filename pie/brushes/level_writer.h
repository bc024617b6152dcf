#pragma once
// Parts of a map and the tree between them become the records of a BSP file.

#include "pie/brushes/bsp_writer.h"
#include "pie/brushes/map_parts.h"
#include "pie/brushes/solid_tree.h"

#include <deque>
#include <vector>

namespace pie::brushes {

class LevelWriter {
public:
    LevelWriter(const MapText& map, const std::deque<Part>& parts, PlaneSet& planes, MapShaders& shaders)
        : map_(map), parts_(parts), planes_(planes), shaders_(shaders), writer_(planes, shaders) {}

    /// `structural`: structuralFragments of the world, the first part.
    [[nodiscard]] level::Bsp write(const SolidTree& tree, std::vector<Fragment> structural);

private:
    struct Fog {
        std::size_t brush = 0; ///< of the world
        std::int32_t effect = -1;
    };
    struct Piece {
        Polygon polygon;
        std::int32_t fog = -1;
    };
    const MapText& map_;
    const std::deque<Part>& parts_;
    PlaneSet& planes_;
    MapShaders& shaders_;
    BspWriter writer_;
    std::vector<Fog> fogs_;
    std::vector<std::uint8_t> kept_; ///< shaders whose faces are written
    std::vector<std::vector<std::uint32_t>> leafFaces_, leafBrushes_;

    void beginModel(const Part& part);
    void endModel();
    void writeWorld(const SolidTree& tree, std::vector<Fragment> structural);
    void writeBrushes(const SolidTree& tree);
    void writePart(const Part& part);
    void writeTree(const SolidTree& tree);
    void writeEntities();
    /// Faces are cut where fog begins: each piece is in one volume or in none.
    [[nodiscard]] std::vector<Piece> cutByFog(Polygon polygon, std::uint32_t plane) const;
    /// The fog that holds a point.
    [[nodiscard]] std::int32_t fogAt(const glm::dvec3& point) const;
};

} // namespace pie::brushes
