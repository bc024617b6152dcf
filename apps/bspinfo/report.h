#pragma once
// What bspinfo says about a level: gathered once, shown as text or as JSON.

#include "pie/level/level.h"
#include "pie/lights/import.h"

#include <map>
#include <string>
#include <vector>

namespace bspinfo {

struct Report {
    pie::level::Level level;
    pie::lights::ImportedLights lights;
    std::map<std::string, pie::Rgb, std::less<>> powerOfKind; ///< watts that enter the level, by kind of light
    std::vector<pie::level::StageTime> times;                 ///< milliseconds, in order
};

/// Loads the level as the viewer does and looks for its lights.
[[nodiscard]] pie::Result<Report> inspect(const std::string& level, const std::filesystem::path& game,
                                          const std::vector<std::filesystem::path>& textures);
[[nodiscard]] std::string text(const Report& report);
/// One object; names, units and meaning: bspinfo --help.
[[nodiscard]] std::string json(const Report& report);

} // namespace bspinfo
