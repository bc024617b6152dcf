#pragma once
// The level that the benchmarks of scene, cache and intersectors measure on.

#include "pie/level/level.h"
#include "pie/scene/mesh.h"

namespace pie::bench {

/// $PIE_BENCH_LEVEL (a name as for `view`: a file, or a map of the installed game), else ctf_inyard. Loaded once,
/// without pictures. Exits with one line when there is none.
[[nodiscard]] const level::Level& benchLevel();
/// Its drawn mesh, refined to edges of 48 units. Made once.
[[nodiscard]] const scene::Mesh& benchMesh();

} // namespace pie::bench
