#pragma once
// What was found about one set of settings: a row of measurements.csv and an entry of report.json. Numbers that are not
// known are NaN and stand as empty cells.

#include <array>
#include <limits>
#include <span>
#include <string>
#include <string_view>

namespace pietrade {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct Measurement {
    std::string settings; ///< "key=value key=value" beside those common to all; empty: those alone
    std::string stage;    ///< why it was measured first: default, tried, sweep, random or near

    double error = unknown, errorDeviation = unknown; ///< of the picture, see accuracy.h; with its standard error
    double median = unknown, medianDeviation = unknown;
    double vertexError = unknown, vertexErrorDeviation = unknown; ///< at vertices, of the mesh of the default
    double vertexMedian = unknown, vertexMedianDeviation = unknown;
    double frameMs = unknown, traceMs = unknown, buildMs = unknown, estimateMs = unknown; ///< of a frame; the sum first
    double readyMs = unknown;  ///< from the level in memory to the first call of a frame
    double refineMs = unknown; ///< once: shadow rays and gather rays of all that is in view
    /// From the file on disk to a picture whose error stays below 20, 10 and 5 %; NaN: that never came.
    double within20Ms = unknown, within10Ms = unknown, within5Ms = unknown;
    double frames = unknown;                         ///< until all photons are there
    double receivers = unknown, triangles = unknown; ///< in view; drawn in the level
    double photons = unknown;                        ///< stored of a frame
    double bytes = unknown; ///< of scene, intersector, photons, texels, rows and receivers, at the end
    double busy =
        unknown; ///< wall clock over processor time of a frame: above 1 with one thread, the machine was shared
};

struct Column {
    std::string_view name;
    double Measurement::*value;
};
/// Of the CSV, behind settings and stage.
[[nodiscard]] std::span<const Column> columns();

} // namespace pietrade
