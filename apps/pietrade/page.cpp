#include "apps/pietrade/page.h"

#include <fmt/format.h>

#include <cmath>

namespace pietrade {

std::string_view styleSheet() {
    return R"(
:root { color-scheme: light dark; --page: #ffffff; --text: #1d2329; --soft: #5b6670; --rule: #dfe3e7; --card: #f5f7f8;
  --s0: #9aa5af; --s1: #0072b2; --s2: #d55e00; --s3: #009e73; }
@media (prefers-color-scheme: dark) { :root { --page: #14181c; --text: #e4e8eb; --soft: #9aa5af; --rule: #2c343b; --card: #1c2227;
  --s0: #6d7882; --s1: #56b4e9; --s2: #f0894d; --s3: #3ecf9d; } }
body { background: var(--page); color: var(--text); font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 64rem; padding: 0 1.25rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin-bottom: .2rem; } h2 { font-size: 1.25rem; margin-top: 2.4rem; } h3 { font-size: 1rem; margin: 1.8rem 0 .3rem; }
p.lead, .soft, caption { color: var(--soft); } p { max-width: 46rem; }
.card { background: var(--card); border-radius: 8px; padding: .3rem 1.2rem; margin: 1rem 0; } .card li { margin: .45rem 0; }
.warn { border-left: 4px solid var(--s2); }
code { font: .85em/1.4 ui-monospace, monospace; background: var(--card); padding: .05em .3em; border-radius: 3px; overflow-wrap: anywhere; }
.card code { background: none; padding: 0; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: .86rem; font-variant-numeric: tabular-nums; width: 100%; }
th, td { text-align: right; white-space: nowrap; padding: .3rem .5rem; border-bottom: 1px solid var(--rule); vertical-align: top; } th { color: var(--soft); font-weight: 600; white-space: normal; }
td.text code { display: inline-block; min-width: 17rem; overflow-wrap: normal; }
.text { text-align: left; white-space: normal; }
.row { display: flex; flex-wrap: wrap; gap: .6rem; } svg { max-width: 100%; height: auto; }
svg text { font: 11px system-ui, sans-serif; fill: var(--soft); } svg .label { font-size: 12px; fill: var(--text); }
.grid { stroke: var(--rule); } .axis { stroke: var(--soft); }
.mark { stroke: var(--page); stroke-width: 1; } .line { fill: none; stroke-width: 2; } .spread { stroke-width: 1.5; opacity: .55; }
.mark.s0 { fill: var(--s0); } .mark.s1 { fill: var(--s1); } .mark.s2 { fill: var(--s2); } .mark.s3 { fill: var(--s3); }
.line.s0, .spread.s0 { stroke: var(--s0); } .line.s1, .spread.s1 { stroke: var(--s1); }
.line.s2, .spread.s2 { stroke: var(--s2); } .line.s3, .spread.s3 { stroke: var(--s3); }
details summary { cursor: pointer; color: var(--soft); margin: .8rem 0; }
)";
}

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                  std::size_t texts) {
    std::string html = "<div class=\"wide\"><table>\n";
    const auto line = [&](const std::vector<std::string>& cells, const char* tag) {
        html += "<tr>";
        for (std::size_t i = 0; i < cells.size(); ++i)
            html += fmt::format("<{}{}>{}</{}>", tag, i < texts ? " class=\"text\"" : "", cells[i], tag);
        html += "</tr>\n";
    };
    line(head, "th");
    for (const auto& row : rows) line(row, "td");
    return html + "</table></div>\n";
}

std::string shown(double value, double scale, int digits) {
    if (!std::isfinite(value)) return "–";
    const double v = scale * value;
    // Whole numbers keep all their digits.
    return std::abs(v) >= std::pow(10.0, digits) ? fmt::format("{:.0f}", v) : fmt::format("{:.{}g}", v, digits);
}

} // namespace pietrade
