#include "osgPlugins/osgpie/level_reader.h"

#include "osgPlugins/osgpie/load.h"

#include <fmt/format.h>

#include <osg/Notify>
#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/Registry>

#include <cstring>
#include <filesystem>
#include <istream>
#include <iterator>

namespace osgpie {
namespace {

/// "…/some.pk3/maps/x.bsp" where the archive is there; whether the level is in it, the loader says better.
bool isInArchive(const std::string& name) {
    std::error_code error;
    for (std::filesystem::path path = name; path.has_relative_path(); path = path.parent_path())
        if (osgDB::getLowerCaseFileExtension(path.string()) == "pk3" && std::filesystem::is_regular_file(path, error))
            return true;
    return false;
}

void report(const pie::level::Level& level, const std::string& prefix) {
    const auto& statistics = level.statistics;
    for (const std::string& warning : statistics.warnings)
        OSG_INFO << prefix << level.file << ": " << warning << std::endl;
    for (const std::string& missing : statistics.missingTextures)
        OSG_INFO << prefix << level.file << ": texture not found: " << missing << std::endl;
    OSG_INFO << prefix << level.file << ": " << statistics.drawnTriangles << " triangles";
    for (const auto& [stage, milliseconds] : statistics.times)
        OSG_INFO << ", " << stage << " " << milliseconds << " ms";
    OSG_INFO << std::endl;
}

} // namespace

LevelReader::LevelReader(const std::string& extension, const std::string& description)
    : extension_(extension), prefix_(fmt::format("[{}] ", extension)),
      className_(fmt::format("Quake 3 {} reader with photon illumination", extension)) {
    supportsExtension(extension, description);
    for (const pie::engine::SettingInfo& info : pie::engine::describe()) {
        const std::string unit = info.unit.empty() ? std::string() : fmt::format(" {}", info.unit);
        supportsOption(fmt::format("{}={}", info.key, info.syntax),
                       fmt::format("{} [{}{}]", info.consequence, info.defaultValue, unit));
    }
}

LevelReader::ReadResult LevelReader::readObject(const std::string& file, const Options* options) const {
    return readNode(file, options);
}

LevelReader::ReadResult LevelReader::readObject(std::istream& stream, const Options* options) const {
    return readNode(stream, options);
}

LevelReader::ReadResult LevelReader::readNode(const std::string& name, const Options* options) const {
    if (!acceptsExtension(osgDB::getLowerCaseFileExtension(name))) return ReadResult::FILE_NOT_HANDLED;
    const std::string found = osgDB::findDataFile(name, options);
    // A level inside an archive ("x.pk3/maps/y.bsp") or of a game directory is no file that osgDB could find.
    const std::string file = found.empty() ? name : found;
    if (!found.empty())
        if (const std::optional<ReadResult> foreign = readForeign(found, options)) return *foreign;
    const auto settings = readSettings(options);
    if (!settings) return failure(settings.error());
    if (found.empty() && settings->game.empty() && !isInArchive(name)) return ReadResult::FILE_NOT_FOUND;
    return finish(loadLevelNode(file, *settings));
}

LevelReader::ReadResult LevelReader::readNode(std::istream& stream, const Options* options) const {
    const std::vector<char> text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    if (const std::optional<ReadResult> foreign = readForeign(stream, text, options)) return *foreign;
    const auto settings = readSettings(options);
    if (!settings) return failure(settings.error());
    std::vector<std::byte> bytes(text.size());
    if (!text.empty()) std::memcpy(bytes.data(), text.data(), text.size());
    const std::string folder =
        options && !options->getDatabasePathList().empty() ? options->getDatabasePathList().front() : std::string();
    return finish(loadLevelNode(bytes, (std::filesystem::path(folder) / ("stream." + extension_)).string(), *settings));
}

std::optional<LevelReader::ReadResult> LevelReader::readForeign(const std::string& /*file*/,
                                                                const Options* /*options*/) const {
    return std::nullopt;
}

std::optional<LevelReader::ReadResult>
LevelReader::readForeign(std::istream& /*stream*/, std::span<const char> /*bytes*/, const Options* /*options*/) const {
    return std::nullopt;
}

pie::Result<pie::engine::Settings> LevelReader::readSettings(const Options* options) const {
    pie::engine::Settings settings;
    if (options) {
        const auto set = settings.setOptions(options->getOptionString());
        if (!set) return set.error();
        for (const std::string& path : options->getDatabasePathList())
            if (!path.empty()) settings.textures.push_back(path);
    }
    for (const std::string& warning : settings.warnings()) OSG_WARN << prefix_ << warning << std::endl;
    return settings;
}

LevelReader::ReadResult LevelReader::failure(const pie::Error& error) const {
    return {fmt::format("{}{}", prefix_, error.message())};
}

LevelReader::ReadResult LevelReader::finish(pie::Result<osg::ref_ptr<LevelNode>> node) const {
    if (!node) return failure(node.error());
    report((*node)->level(), prefix_);
    return {(*node).get()};
}

} // namespace osgpie
