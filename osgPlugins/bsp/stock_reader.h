#pragma once
// OSG's own reader for .bsp, for what is not ours (Valve's VBSP). It has the same library name as this plug-in, so the
// registry never loads it by itself; it is loaded by absolute path.

#include <osgDB/ReaderWriter>

namespace osgpie_bsp {

/// The stock plug-in's reader, or null where OSG has none. `reason` then says why.
[[nodiscard]] osgDB::ReaderWriter* stockReader(std::string& reason);

} // namespace osgpie_bsp
