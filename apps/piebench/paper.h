#pragma once
// What the pi-engine's paper measured and said, again: tables 6.1 and 6.2, and the statements about its parameters.
//
// The paper's path is the estimator Nearest, all light from photons, and photons of several frames; our gather stands
// beside it. Frames are steady ones, `accumulation_frames` of them kept, and their rates are those of light alone: the
// paper's include drawing. Times are of the processor with one thread, else wall clock; medians. All throw Stop.

#include "apps/piebench/frame.h"

#include <cstddef>
#include <string>
#include <vector>

namespace piebench {

struct PaperOptions {
    std::string level;              ///< empty: the paper's, of our own making
    std::size_t most = 25'600;      ///< table 6.1: leaves out cells of more photons or triangles
    std::size_t triangles = 0;      ///< table 6.2; 0: not refined
    std::uint64_t photons = 10'000; ///< table 6.2: in all
    double seconds = 0.3;           ///< of each measurement, at least; and at least five frames
};

/// Frame rate by photons and triangles, with the exponent that frame time grows with as photons + receivers.
[[nodiscard]] Json table61(const PaperOptions& options, const pie::engine::Settings& settings);
[[nodiscard]] std::string table61Text(const Json& report);
/// Frame rate and the time in which all photons are renewed, by accumulation frames.
[[nodiscard]] Json table62(const PaperOptions& options, const pie::engine::Settings& settings);
[[nodiscard]] std::string table62Text(const Json& report);
/// What the text says, each with its measured counterpart.
[[nodiscard]] Json statements(const PaperOptions& options, const pie::engine::Settings& settings);
[[nodiscard]] std::string statementsText(const Json& report);

/// Settings of the paper's path where nothing was set: its estimate, no direct light but that of photons, T-junctions
/// as they are.
[[nodiscard]] pie::engine::Settings paperSettings(const pie::engine::Settings& settings);
/// Frames that keep about `photons` stored photons over `accumulation` of them.
[[nodiscard]] std::unique_ptr<Frames> pacedFrames(Estimator estimator, const Subject& subject,
                                                  const pie::engine::Settings& settings, std::uint64_t photons,
                                                  std::size_t accumulation);
/// Medians over frames after the first `accumulation`, for at least `seconds`.
[[nodiscard]] Stages paced(Frames& frames, std::size_t accumulation, double seconds);
/// Of these, the time that counts: see above.
[[nodiscard]] double frameMs(const Stages& stages);

} // namespace piebench
