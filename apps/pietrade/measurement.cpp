#include "apps/pietrade/measurement.h"

namespace pietrade {

std::span<const Column> columns() {
    static constexpr std::array all{Column{"error", &Measurement::error},
                                    Column{"error_stderr", &Measurement::errorDeviation},
                                    Column{"median", &Measurement::median},
                                    Column{"median_stderr", &Measurement::medianDeviation},
                                    Column{"vertex_error", &Measurement::vertexError},
                                    Column{"vertex_error_stderr", &Measurement::vertexErrorDeviation},
                                    Column{"vertex_median", &Measurement::vertexMedian},
                                    Column{"vertex_median_stderr", &Measurement::vertexMedianDeviation},
                                    Column{"frame_ms", &Measurement::frameMs},
                                    Column{"trace_ms", &Measurement::traceMs},
                                    Column{"build_ms", &Measurement::buildMs},
                                    Column{"estimate_ms", &Measurement::estimateMs},
                                    Column{"ready_ms", &Measurement::readyMs},
                                    Column{"refine_ms", &Measurement::refineMs},
                                    Column{"within_20_ms", &Measurement::within20Ms},
                                    Column{"within_10_ms", &Measurement::within10Ms},
                                    Column{"within_5_ms", &Measurement::within5Ms},
                                    Column{"frames", &Measurement::frames},
                                    Column{"receivers", &Measurement::receivers},
                                    Column{"triangles", &Measurement::triangles},
                                    Column{"photons", &Measurement::photons},
                                    Column{"bytes", &Measurement::bytes},
                                    Column{"busy", &Measurement::busy}};
    return all;
}

} // namespace pietrade
