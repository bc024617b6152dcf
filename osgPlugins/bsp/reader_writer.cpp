// osgdb_bsp: Quake 3 levels for osgviewer and every other program that reads through osgDB. Thin: options and
// delegation here, the rest in osgpie.
#include "osgPlugins/bsp/stock_reader.h"
#include "osgPlugins/osgpie/load.h"

#include <fmt/format.h>

#include <osg/Notify>
#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/Registry>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <istream>
#include <iterator>

namespace osgpie_bsp {
namespace {

constexpr const char* prefix = "[bsp] ";

bool startsWithValve(const char* bytes) { return std::memcmp(bytes, "VBSP", 4) == 0; }

bool isValve(const std::string& file) {
    std::array<char, 4> magic{};
    std::ifstream stream(file, std::ios::binary);
    return stream.read(magic.data(), magic.size()) && startsWithValve(magic.data());
}

/// "…/some.pk3/maps/x.bsp" where the archive is there; whether the level is in it, the loader says better.
bool isInArchive(const std::string& name) {
    std::error_code error;
    for (std::filesystem::path path = name; path.has_relative_path(); path = path.parent_path())
        if (osgDB::getLowerCaseFileExtension(path.string()) == "pk3" && std::filesystem::is_regular_file(path, error))
            return true;
    return false;
}

void report(const pie::level::Level& level) {
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

class ReaderWriterQuake3 : public osgDB::ReaderWriter {
public:
    ReaderWriterQuake3() {
        supportsExtension("bsp", "Quake 3 level, lit by photons (other dialects: OpenSceneGraph's own reader)");
        for (const pie::engine::SettingInfo& info : pie::engine::describe()) {
            const std::string unit = info.unit.empty() ? std::string() : fmt::format(" {}", info.unit);
            supportsOption(fmt::format("{}={}", info.key, info.syntax),
                           fmt::format("{} [{}{}]", info.consequence, info.defaultValue, unit));
        }
    }
    [[nodiscard]] const char* libraryName() const override { return "osgpie"; }
    [[nodiscard]] const char* className() const override { return "Quake 3 BSP reader with photon illumination"; }

    ReadResult readObject(const std::string& file, const Options* options) const override {
        return readNode(file, options);
    }
    ReadResult readObject(std::istream& stream, const Options* options) const override {
        return readNode(stream, options);
    }

    ReadResult readNode(const std::string& name, const Options* options) const override {
        if (!acceptsExtension(osgDB::getLowerCaseFileExtension(name))) return ReadResult::FILE_NOT_HANDLED;
        const std::string found = osgDB::findDataFile(name, options);
        // A level inside an archive ("x.pk3/maps/y.bsp") or of a game directory is no file that osgDB could find.
        const std::string file = found.empty() ? name : found;
        if (!found.empty() && isValve(found))
            return delegate([&](osgDB::ReaderWriter& stock) { return stock.readNode(found, options); });
        const auto settings = readSettings(options);
        if (!settings) return failure(settings.error());
        if (found.empty() && settings->game.empty() && !isInArchive(name)) return ReadResult::FILE_NOT_FOUND;
        return finish(osgpie::loadLevelNode(file, *settings));
    }

    ReadResult readNode(std::istream& stream, const Options* options) const override {
        std::vector<char> text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
        if (text.size() >= 4 && startsWithValve(text.data())) {
            stream.clear();
            stream.seekg(0);
            return delegate([&](osgDB::ReaderWriter& stock) { return stock.readNode(stream, options); });
        }
        const auto settings = readSettings(options);
        if (!settings) return failure(settings.error());
        std::vector<std::byte> bytes(text.size());
        if (!text.empty()) std::memcpy(bytes.data(), text.data(), text.size());
        const std::string folder =
            options && !options->getDatabasePathList().empty() ? options->getDatabasePathList().front() : std::string();
        return finish(osgpie::loadLevelNode(bytes, (std::filesystem::path(folder) / "stream.bsp").string(), *settings));
    }

private:
    static pie::Result<pie::engine::Settings> readSettings(const Options* options) {
        pie::engine::Settings settings;
        if (options) {
            const auto set = settings.setOptions(options->getOptionString());
            if (!set) return set.error();
            for (const std::string& path : options->getDatabasePathList())
                if (!path.empty()) settings.textures.push_back(path);
        }
        for (const std::string& warning : settings.warnings()) OSG_WARN << prefix << warning << std::endl;
        return settings;
    }

    static ReadResult failure(const pie::Error& error) { return {fmt::format("{}{}", prefix, error.message())}; }

    static ReadResult finish(pie::Result<osg::ref_ptr<osgpie::LevelNode>> node) {
        if (!node) return failure(node.error());
        report((*node)->engine().level());
        return {(*node).get()};
    }

    template <class Read> static ReadResult delegate(Read read) {
        std::string reason;
        osgDB::ReaderWriter* stock = stockReader(reason);
        return stock ? read(*stock) : ReadResult(fmt::format("{}{}", prefix, reason));
    }
};

REGISTER_OSGPLUGIN(bsp, ReaderWriterQuake3)

} // namespace osgpie_bsp
