// osgdb_map: the .map text that level editors write, lit as it stands, without a compile.
#include "osgPlugins/osgpie/level_reader.h"

#include <osgDB/Registry>

namespace osgpie_map {

class ReaderWriterMap : public osgpie::LevelReader {
public:
    ReaderWriterMap() : LevelReader("map", "Quake 3 map text of a level editor, lit by photons") {}
};

REGISTER_OSGPLUGIN(map, ReaderWriterMap)

} // namespace osgpie_map
