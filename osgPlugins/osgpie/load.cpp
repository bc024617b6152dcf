#include "osgPlugins/osgpie/load.h"

#include "osgPlugins/osgpie/initial_view.h"
#include "osgPlugins/osgpie/settle.h"
#include "pie/brushes/load.h"
#include "pie/core/parallel.h"

namespace osgpie {
namespace {

pie::level::LoadOptions loadOptions(const pie::engine::Settings& settings) {
    pie::level::LoadOptions options;
    options.deluxe = settings.deluxe;
    options.patchTolerance = settings.patchTolerance;
    return options;
}

pie::Result<pie::level::Location> find(const std::string& level, const pie::engine::Settings& settings) {
    const std::vector<std::filesystem::path> folders(settings.textures.begin(), settings.textures.end());
    return pie::level::locate(level, settings.game, folders);
}

osg::ref_ptr<LevelNode> makeNode(pie::level::Level&& level, const pie::engine::Settings& settings) {
    pie::setThreads(static_cast<unsigned>(settings.threads));
    const auto shared = std::make_shared<const pie::level::Level>(std::move(level));
    osg::ref_ptr<LevelNode> node =
        makeLevelNode(std::make_shared<pie::engine::Engine>(shared, settings, pie::engine::Refinement::Later));
    addInitialView(*node);
    if (settings.settle) settle(*node);
    return node;
}

} // namespace

pie::Result<osg::ref_ptr<LevelNode>> loadLevelNode(const std::string& level, const pie::engine::Settings& settings) {
    auto location = find(level, settings);
    if (!location) return location.error();
    auto loaded = pie::brushes::loadLevel(std::move(*location), loadOptions(settings));
    if (!loaded) return loaded.error();
    return makeNode(std::move(*loaded), settings);
}

pie::Result<osg::ref_ptr<LevelNode>> loadLevelNode(const std::vector<std::byte>& bytes, const std::string& level,
                                                   const pie::engine::Settings& settings) {
    pie::level::Location location;
    if (auto found = find(level, settings))
        location = std::move(*found);
    else
        location.name = level;
    auto loaded = pie::brushes::loadLevel(bytes, std::move(location), loadOptions(settings));
    if (!loaded) return loaded.error();
    return makeNode(std::move(*loaded), settings);
}

} // namespace osgpie
