#pragma once
// misc_model entities: models of files, placed as the level compiler does. Keys: model, origin, angle or angles (pitch
// yaw roll, degrees), modelscale or modelscale_vec, frame or _frame, skin or _skin, _remap… "from;to" ("*" is every
// shader), and target: the brush entity that the model belongs to instead of the world.

#include "pie/brushes/map_parts.h"
#include "pie/brushes/model.h"
#include "pie/level/vfs.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pie::brushes {

class ModelPlacer {
public:
    ModelPlacer(const level::Vfs& files, const std::string& fileName, MapShaders& shaders,
                std::vector<std::string>& warnings)
        : files_(files), fileName_(fileName), shaders_(shaders), warnings_(warnings) {}

    /// Adds the map's models to the parts they belong to; how many. What is missing or damaged is one warning a file.
    std::size_t place(const MapText& map, std::deque<Part>& parts);

private:
    const level::Vfs& files_;
    const std::string& fileName_;
    MapShaders& shaders_;
    std::vector<std::string>& warnings_;
    std::map<std::string, std::optional<Model>> known_; ///< by file and frame; nothing: reported

    [[nodiscard]] const Model* find(const std::string& name, int frame, int line);
    [[nodiscard]] std::map<std::string, std::string> skinOf(const std::string& model, int skin) const;
    void add(const level::Entity& entity, const Model& model, const std::string& name, Part& part);
};

} // namespace pie::brushes
