#include "apps/pietrade/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace pietrade {
namespace {

constexpr double left = 58;
constexpr double right = 14;
constexpr double top = 12;
constexpr double bottom = 44;
constexpr double legendLine = 18;

bool drawn(const Mark& m, const Plot& plot) {
    return std::isfinite(m.x) && std::isfinite(m.y) && (!plot.x.logarithmic || m.x > 0) &&
           (!plot.y.logarithmic || m.y > 0);
}

/// From numbers to places.
struct Scale {
    double low = 0, high = 1, from = 0, to = 1;
    bool logarithmic = false;
    std::vector<double> ticks;

    [[nodiscard]] double operator()(double value) const {
        const double share = logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
        return from + std::clamp(share, -0.1, 1.1) * (to - from);
    }
};

Scale scaleFor(const PlotAxis& axis, double low, double high, double from, double to) {
    Scale s;
    s.from = from;
    s.to = to;
    s.logarithmic = axis.logarithmic;
    if (!axis.names.empty()) {
        s.low = -0.5;
        s.high = static_cast<double>(axis.names.size()) - 0.5;
        for (std::size_t i = 0; i < axis.names.size(); ++i) s.ticks.push_back(static_cast<double>(i));
        return s;
    }
    if (axis.logarithmic) {
        s.low = low / 1.15;
        s.high = high * 1.15;
    } else {
        s.low = std::min(0.0, low);
        s.high = high > s.low ? high + 0.06 * (high - s.low) : s.low + 1;
    }
    s.ticks = ticks(s.low, s.high, axis.logarithmic);
    std::erase_if(s.ticks, [&](double t) { return t < s.low || t > s.high; });
    return s;
}

std::string tickText(const PlotAxis& axis, double value) {
    if (!axis.names.empty()) return axis.names[static_cast<std::size_t>(value)];
    if (value >= 1e6) return fmt::format("{:g}M", value / 1e6);
    return fmt::format("{:g}", value);
}

class Drawing {
public:
    explicit Drawing(const Plot& plot) : p_(plot) {
        for (const Series& series : p_.series)
            if (!series.name.empty()) legend_ += legendLine;
    }

    std::string text() {
        double lowX = std::numeric_limits<double>::infinity();
        double lowY = lowX;
        double highX = -lowX;
        double highY = -lowX;
        for (const Series& series : p_.series)
            for (const Mark& m : series.marks) {
                if (!drawn(m, p_)) continue;
                lowX = std::min(lowX, m.x);
                highX = std::max(highX, m.x);
                lowY = std::min(lowY, m.y);
                highY = std::max(highY, m.y + (p_.y.logarithmic ? 0 : m.spread));
            }
        const double high = p_.height + legend_;
        add("<svg viewBox=\"0 0 {} {:g}\" width=\"{}\" height=\"{:g}\" role=\"img\" aria-label=\"{}\">\n", p_.width,
            high, p_.width, high, escaped(p_.y.label + " over " + p_.x.label));
        if (lowX > highX) {
            add("<text class=\"label\" x=\"{}\" y=\"{}\">nothing measured yet</text>\n</svg>\n", left, p_.height / 2);
            return out_;
        }
        x_ = scaleFor(p_.x, lowX, highX, left, p_.width - right);
        y_ = scaleFor(p_.y, lowY, highY, p_.height - bottom + legend_, top + legend_);
        axes();
        legend();
        for (const Series& series : p_.series) draw(series);
        out_ += "</svg>\n";
        return out_;
    }

private:
    template <class... T> void add(fmt::format_string<T...> format, T&&... values) {
        fmt::format_to(std::back_inserter(out_), format, std::forward<T>(values)...);
    }

    void axes() {
        const double low = y_.from;
        for (const double t : y_.ticks) {
            add("<line class=\"grid\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>\n", x_.from, x_.to,
                y_(t), y_(t));
            add("<text class=\"tick\" text-anchor=\"end\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x_.from - 6,
                y_(t) + 3.5, escaped(tickText(p_.y, t)));
        }
        for (const double t : x_.ticks) {
            if (p_.x.names.empty())
                add("<line class=\"grid\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>\n", x_(t), x_(t),
                    low, y_.to);
            add("<text class=\"tick\" text-anchor=\"middle\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x_(t), low + 15,
                escaped(tickText(p_.x, t)));
        }
        add("<line class=\"axis\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>\n", x_.from, x_.to, low,
            low);
        add("<text class=\"label\" text-anchor=\"middle\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n",
            0.5 * (x_.from + x_.to), low + 34, escaped(p_.x.label));
        add("<text class=\"label\" text-anchor=\"middle\" transform=\"translate(13 {:.1f}) rotate(-90)\">{}</text>\n",
            0.5 * (low + y_.to), escaped(p_.y.label));
    }

    void legend() {
        double y = top;
        for (const Series& series : p_.series) {
            if (series.name.empty()) continue;
            add("<circle class=\"mark s{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\"/>\n", series.look, left + 6, y);
            add("<text class=\"label\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", left + 16, y + 4, escaped(series.name));
            y += legendLine;
        }
    }

    void draw(const Series& series) {
        std::string line;
        for (const Mark& m : series.marks)
            if (drawn(m, p_)) line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", x_(m.x), y_(m.y));
        if (series.line) add("<path class=\"line s{}\" d=\"{}\"/>\n", series.look, line);
        for (const Mark& m : series.marks) {
            if (!drawn(m, p_)) continue;
            const double x = x_(m.x);
            if (m.spread > 0) {
                const double least = p_.y.logarithmic ? y_.low : -std::numeric_limits<double>::infinity();
                add("<line class=\"spread s{}\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>\n",
                    series.look, x, x, y_(std::max(m.y - m.spread, least)), y_(m.y + m.spread));
            }
            add("<circle class=\"mark s{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"><title>{}</title></circle>\n",
                series.look, x, y_(m.y), series.line ? 4 : 3, escaped(m.title));
            if (!m.label.empty())
                add("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x + 7, y_(m.y) - 6, escaped(m.label));
        }
    }

    const Plot& p_;
    std::string out_;
    Scale x_, y_;
    double legend_ = 0;
};

} // namespace

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
        case '&': result += "&amp;"; break;
        case '<': result += "&lt;"; break;
        case '>': result += "&gt;"; break;
        case '"': result += "&quot;"; break;
        default: result += c;
        }
    }
    return result;
}

std::vector<double> ticks(double low, double high, bool logarithmic) {
    std::vector<double> result;
    if (logarithmic) {
        // 1, 2, 5; where that is crowded, powers of ten.
        const double decades = std::log10(high / low);
        for (double power = std::pow(10.0, std::floor(std::log10(low))); power <= high; power *= 10)
            for (const double digit : {1.0, 2.0, 5.0})
                if (digit * power >= low && digit * power <= high && (digit == 1.0 || decades < 3.5))
                    result.push_back(digit * power);
        return result;
    }
    const double rough = (high - low) / 5;
    double step = std::pow(10.0, std::floor(std::log10(rough)));
    for (const double factor : {5.0, 2.0})
        if (step * factor <= rough) {
            step *= factor;
            break;
        }
    for (double t = std::ceil(low / step) * step; t <= high + 1e-9 * step; t += step) result.push_back(t);
    return result;
}

std::string svg(const Plot& plot) { return Drawing(plot).text(); }

} // namespace pietrade
