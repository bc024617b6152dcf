#pragma once
// Which settings are measured: not the full product, but
//
//   the default;
//   sweeps    one parameter at a time, the others as in the default;
//   random    a latin hypercube over the parameters that matter together: each is cut into as many spans as there are
//             settings, and every span is met once;
//   near      half as many again: a setting on the front of those, with one parameter moved a step.
//
// Settings are written as what differs from the default, "key=value key=value" in the order of the table of settings;
// equal ones are measured once. What the user set himself stays as he set it. A plan is a pure function of what it is
// made from.

#include "pie/engine/settings.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pietrade {

/// What the choice of values depends on.
struct Ground {
    pie::engine::Settings base;
    double texelEdge = 64; ///< units, what texel_size = 0 means here
    unsigned cores = 1;
    bool quick = false;      ///< fewer values, fewer random settings
    std::size_t random = 24; ///< random settings
    std::uint64_t seed = 0;
    std::size_t mostFrames = 1000; ///< of photons that are measured
};

struct Sweep {
    std::string key;
    std::string with;                  ///< settings that go with all of it; may be empty
    std::vector<std::string> values;   ///< of the key, growing where they are numbers
    std::vector<std::string> settings; ///< beside the default, as long as values
};

[[nodiscard]] std::vector<Sweep> sweeps(const Ground& ground);
[[nodiscard]] std::vector<std::string> randomSettings(const Ground& ground);
/// `best`: settings on the front, not empty; `count` of them at most, none of which stands in `known`.
[[nodiscard]] std::vector<std::string> nearSettings(const Ground& ground, const std::vector<std::string>& best,
                                                    const std::vector<std::string>& known, std::size_t count);

/// The base with `difference` on top.
[[nodiscard]] pie::engine::Settings changed(const pie::engine::Settings& base, std::string_view difference);
/// What of `settings` differs from `base`.
[[nodiscard]] std::string difference(const pie::engine::Settings& base, const pie::engine::Settings& settings);
/// The option string that reproduces it: what differs from the program's own defaults.
[[nodiscard]] std::string optionString(const pie::engine::Settings& settings);

} // namespace pietrade
