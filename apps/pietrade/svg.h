#pragma once
// Plots as inline SVG: marks and lines over two axes, either of them in the logarithm, or over names. Colours are
// classes that the page's style sheet gives ("axis", "grid", "label", and "s0", "s1" … of the series), so that one
// drawing reads in light and dark. No scripts: what a mark is shows as its title when it is pointed at.

#include <string>
#include <string_view>
#include <vector>

namespace pietrade {

struct Mark {
    double x = 0, y = 0;
    double spread = 0; ///< of y, to both sides; 0: none
    std::string title; ///< shown when pointed at
    std::string label; ///< written beside it
};
struct Series {
    std::string name; ///< in the legend; empty: not there
    int look = 0;     ///< number of its class
    bool line = false;
    std::vector<Mark> marks;
};
struct PlotAxis {
    std::string label;
    bool logarithmic = false;
    std::vector<std::string> names; ///< of 0, 1, 2 …, in place of numbers
};
struct Plot {
    PlotAxis x, y;
    std::vector<Series> series;
    int width = 640, height = 400;
};

[[nodiscard]] std::string escaped(std::string_view text);
/// Marks that are not finite, or not above zero on a logarithmic axis, are left out; a plot without any says so.
[[nodiscard]] std::string svg(const Plot& plot);
/// Round numbers between two, both included: what an axis is labelled with. 0 < low where logarithmic.
[[nodiscard]] std::vector<double> ticks(double low, double high, bool logarithmic);

} // namespace pietrade
