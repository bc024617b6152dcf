#pragma once
// What a report folder keeps for the next call: measurements.csv and reference.csv. Each begins with lines
// "# name: value" that say what it was made of; a file that says anything else than this call would is foreign, and is
// an error, as is a line that is damaged. Nothing is guessed and nothing repaired.

#include "apps/pietrade/accuracy.h"
#include "apps/pietrade/measurement.h"
#include "pie/core/result.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace pietrade {

/// What measurements depend on, by name, in order. Neither may hold a line end.
using Identity = std::vector<std::pair<std::string, std::string>>;

[[nodiscard]] std::string measurementsText(const Identity& identity, const std::vector<Measurement>& all);
/// Nothing where there is no such file.
[[nodiscard]] pie::Result<std::vector<Measurement>> readMeasurements(const std::filesystem::path& file,
                                                                     const Identity& identity);

[[nodiscard]] std::string truthText(const Identity& identity, const std::vector<Truth>& all);
/// Nothing where there is no such file; else what was traced before it ended, `most` at most.
[[nodiscard]] pie::Result<std::vector<Truth>> readTruth(const std::filesystem::path& file, const Identity& identity,
                                                        std::size_t most);

} // namespace pietrade
