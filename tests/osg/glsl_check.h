#pragma once
// What can be wrong with a GLSL 1.20 source without a compiler: unbalanced brackets, decrements that come from joining
// a minus with a negative number, numbers that are none, and names that nothing declares. The image tests hand every
// source to a real compiler as well.

#include <set>
#include <string>
#include <vector>

namespace pie::test {

/// One line per fault; empty for a source that may be right.
[[nodiscard]] std::vector<std::string> glslFaults(const std::string& source);
/// Names declared with this qualifier ("varying", "uniform").
[[nodiscard]] std::set<std::string> glslDeclared(const std::string& source, const std::string& qualifier);

} // namespace pie::test
