#pragma once
// The report: report.json for programs, report.html for people. Both are pure functions of what was found.

#include "apps/pietrade/analysis.h"

#include <string>

namespace pietrade {

/// One JSON object: what was measured and how, every measurement, sweeps, fronts, advice.
[[nodiscard]] std::string reportJson(const Findings& found, const Analysis& analysis);
/// A page of its own: no scripts, no files beside it.
[[nodiscard]] std::string reportHtml(const Findings& found, const Analysis& analysis);

} // namespace pietrade
