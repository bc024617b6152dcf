#pragma once
// piebench frame: what a frame costs and how true it is, alone or against others that take their turns in the same run.
//
// A full frame traces every photon anew; a steady one a tenth of them, the others being those of the nine frames
// before. Both estimate at every vertex. Errors are those of the first full frame and of the tenth steady one, which
// have the same photons. Throws Stop.

#include "apps/piebench/frames.h"
#include "apps/piebench/reference.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace piebench {

using Json = nlohmann::ordered_json;

enum class Contender : std::uint8_t { Gather, Nearest, TrueArea, Nanoflann, Embree };

struct FrameOptions {
    std::string level;
    std::uint64_t photons = 25'600; ///< stored in a full frame
    std::size_t triangles = 0;      ///< 0: as a picture has them
    Contender measured = Contender::Gather;
    std::vector<Contender> against;
    int repeats = 11;
    bool scaling = false; ///< also one thread against all
    bool judged = true;   ///< against the path tracer
    ReferenceOptions reference;
};

[[nodiscard]] Json measureFrame(const FrameOptions& options, const pie::engine::Settings& settings);
/// The same for reading.
[[nodiscard]] std::string frameText(const Json& report);

// What the reports of all commands begin with, and how they say a time.
[[nodiscard]] Json machineJson();
/// Rounded to so many significant digits: nothing measured has more.
[[nodiscard]] double rounded(double value, int digits = 4);
[[nodiscard]] double number(const Json& value); ///< 0 where it is none

} // namespace piebench
