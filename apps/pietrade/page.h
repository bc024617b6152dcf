#pragma once
// Pieces of the page that know nothing of measurements.

#include <string>
#include <string_view>
#include <vector>

namespace pietrade {

/// The style sheet: light and dark by what the reader's system has.
[[nodiscard]] std::string_view styleSheet();

/// Rows of cells that are HTML already; the first `texts` columns stand left, the others, numbers, right.
[[nodiscard]] std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                                std::size_t texts = 1);

/// "3.9", or "–" where it is not known.
[[nodiscard]] std::string shown(double value, double scale = 1, int digits = 3);

} // namespace pietrade
