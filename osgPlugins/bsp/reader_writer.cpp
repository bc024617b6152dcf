// osgdb_bsp: Quake 3 levels for osgviewer and every other program that reads through osgDB. What is Valve's goes to
// OSG's own reader.
#include "osgPlugins/bsp/stock_reader.h"
#include "osgPlugins/osgpie/level_reader.h"

#include <osgDB/Registry>

#include <array>
#include <cstring>
#include <fstream>
#include <istream>

namespace osgpie_bsp {
namespace {

bool startsWithValve(std::span<const char> bytes) {
    return bytes.size() >= 4 && std::memcmp(bytes.data(), "VBSP", 4) == 0;
}

} // namespace

class ReaderWriterQuake3 : public osgpie::LevelReader {
public:
    ReaderWriterQuake3()
        : LevelReader("bsp", "Quake 3 level, lit by photons (other dialects: OpenSceneGraph's own reader)") {}

protected:
    [[nodiscard]] std::optional<ReadResult> readForeign(const std::string& file,
                                                        const Options* options) const override {
        std::array<char, 4> magic{};
        std::ifstream stream(file, std::ios::binary);
        if (!stream.read(magic.data(), magic.size()) || !startsWithValve(magic)) return std::nullopt;
        return delegate([&](osgDB::ReaderWriter& stock) { return stock.readNode(file, options); });
    }
    [[nodiscard]] std::optional<ReadResult> readForeign(std::istream& stream, std::span<const char> bytes,
                                                        const Options* options) const override {
        if (!startsWithValve(bytes)) return std::nullopt;
        stream.clear();
        stream.seekg(0);
        return delegate([&](osgDB::ReaderWriter& stock) { return stock.readNode(stream, options); });
    }

private:
    template <class Read> ReadResult delegate(Read read) const {
        std::string reason;
        osgDB::ReaderWriter* stock = stockReader(reason);
        return stock ? read(*stock) : ReadResult(prefix() + reason);
    }
};

REGISTER_OSGPLUGIN(bsp, ReaderWriterQuake3)

} // namespace osgpie_bsp
