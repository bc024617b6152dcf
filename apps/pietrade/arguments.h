#pragma once
// The command line.

#include "apps/pietrade/view.h"
#include "pie/engine/settings.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pietrade {

enum Exit : int { Done = 0, Failed = 1, Misused = 2, Incomplete = 3 };

/// Why the program ends early.
struct Stop {
    std::string message;
    Exit status = Failed;
};

struct Arguments {
    std::string level;
    std::filesystem::path out = "report";
    pie::engine::Settings settings; ///< of the default: what the user set
    std::optional<Camera> camera;   ///< none: everything (with `everything`), else the first player start
    bool everything = false, noSweeps = false, quick = false, quiet = false, processorTime = false;
    std::size_t points = 300, random = 24;
    double target = 0.02;
    std::uint64_t mostPaths = 65536;
    std::optional<double> minutes;
    std::vector<std::string> tried; ///< settings to measure besides, "key=value key=value"
    std::size_t mostFrames = 1000;
};

/// Throws Stop when it is wrong, and when help was asked for, with status Done and nothing to say.
[[nodiscard]] Arguments parseArguments(int argc, const char* const* argv);

} // namespace pietrade
