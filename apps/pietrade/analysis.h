#pragma once
// What measurements say to somebody who has to choose.

#include "apps/pietrade/session.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pietrade {

/// The best there is within a limit.
struct Advice {
    double limit = 0;                  ///< ms, or share
    std::optional<std::size_t> choice; ///< Findings::measurements; none: nothing keeps the limit
};

struct Analysis {
    std::vector<std::size_t> compared; ///< Findings::measurements of as many threads as the default
    std::vector<std::size_t> frames;   ///< front of error and ms a frame, by growing time
    std::vector<std::size_t> pictures; ///< front of error and ms to the first picture that is near enough
    double near = 0.1;                 ///< what is near enough: 0.1, or 0.2 where hardly anything reaches that
    std::vector<Advice> byFrame;       ///< the most accurate by ms a frame
    std::vector<Advice> byError;       ///< the fastest by error
    std::vector<Advice> byPicture;     ///< one: what is first near enough
};
[[nodiscard]] Analysis analyse(const Findings& found);

/// Ms to a picture within the analysis' `near`.
[[nodiscard]] double pictureMs(const Measurement& m, double near);
/// The option string for OSG programs that reproduces a measurement; may be empty.
[[nodiscard]] std::string options(const Findings& found, const Measurement& m);
/// The command that shows it.
[[nodiscard]] std::string command(const Findings& found, const Measurement& m);
/// "For 8 ms a frame take …", a line each.
[[nodiscard]] std::vector<std::string> advice(const Findings& found, const Analysis& analysis);

} // namespace pietrade
