#pragma once
// Lines of comma-separated cells.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pietrade {

/// A cell as it stands in a line: quoted where it holds a comma or a quote.
[[nodiscard]] std::string csvCell(std::string_view text);
/// The cells of a line without its end; none when a quote is not closed.
[[nodiscard]] std::optional<std::vector<std::string>> csvCells(std::string_view line);
/// A number with all its digits; empty for NaN.
[[nodiscard]] std::string csvNumber(double value);
/// What csvNumber wrote; none when it is something else. Infinite numbers are refused.
[[nodiscard]] std::optional<double> readNumber(std::string_view text);

} // namespace pietrade
