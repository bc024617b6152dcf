#include "pie/engine/statistics.h"

#include <fmt/format.h>

namespace pie::engine {

std::string Statistics::json() const {
    return fmt::format(
        R"({{"frames":{},"frames_traced":{},"photons_emitted":{},"rays_traced":{},"photons_stored":{},"photons_escaped":{},)"
        R"("photons_in_map":{},"map_nodes_visited":{},"map_photons_visited":{},"direct_estimates":{},"direct_rays":{},"estimates_made":{},"estimates_reused":{},"estimates_deferred":{},"gather_rays":{},"unfinished":{},"receivers":{},)"
        R"("drawn_triangles":{},"coarse_triangles":{},"lights":{},"prepare_ms":{:.3f},"trace_ms":{:.3f},"build_ms":{:.3f},)"
        R"("direct_ms":{:.3f},"refine_ms":{:.3f},"estimate_ms":{:.3f},"upload_ms":{:.3f},"frame_ms_median":{:.3f},"frame_ms_p95":{:.3f},"error_percent":{:.3f},"still":{},)"
        R"("scene_bytes":{},"intersector_bytes":{},"map_bytes":{},"receiver_bytes":{},"estimator_bytes":{},"direct_bytes":{}}})",
        frames, framesTraced, photonsEmitted, raysTraced, photonsStored, photonsEscaped, photonsInMap, mapNodesVisited,
        mapPhotonsVisited, directEstimates, directRays, estimatesMade, estimatesReused, estimatesDeferred, gatherRays,
        unfinished, receivers, drawnTriangles, coarseTriangles, lights, prepareMs, traceMs, buildMs, directMs, refineMs,
        estimateMs, uploadMs, frameMsMedian, frameMs95, errorPercent, still, sceneBytes, intersectorBytes, mapBytes,
        receiverBytes, estimatorBytes, directBytes);
}

} // namespace pie::engine
