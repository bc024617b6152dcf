#include "apps/pietrade/page.h"
#include "apps/pietrade/report.h"
#include "apps/pietrade/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pietrade {
namespace {

constexpr double percent = 100;
constexpr double perMegabyte = 1e-6;

std::string code(const std::string& text) { return "<code>" + escaped(text) + "</code>"; }
std::string shortName(const Measurement& m) { return m.settings.empty() ? "default" : m.settings; }

std::string plusMinus(double value, double deviation) {
    return std::isfinite(value) ? fmt::format("{} ± {}", shown(value, percent), shown(deviation, percent, 2)) : "–";
}

std::string title(const Measurement& m) {
    return fmt::format("{}: error {} %, {} ms a frame, within 10 % after {} ms", shortName(m), shown(m.error, percent),
                       shown(m.frameMs), shown(m.within10Ms));
}

class Page {
public:
    Page(const Findings& found, const Analysis& analysis) : f_(found), a_(analysis) {}

    std::string html() {
        out_ = "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
               "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
        add("<title>Speed and accuracy: {}</title>\n<style>{}</style>\n</head>\n<body>\n", escaped(f_.level),
            styleSheet());
        summary();
        fronts();
        sweeps();
        everything();
        method();
        return out_ + "</body>\n</html>\n";
    }

private:
    template <class... T> void add(fmt::format_string<T...> format, T&&... values) {
        out_ += fmt::format(format, std::forward<T>(values)...);
    }

    void summary();
    void fronts();
    void sweeps();
    void everything();
    void method();
    [[nodiscard]] std::string frontPlot(const std::vector<std::size_t>& front, const PlotAxis& x,
                                        double (*time)(const Measurement&, double)) const;
    [[nodiscard]] std::string frontTable(const std::vector<std::size_t>& front) const;
    [[nodiscard]] const Measurement* find(const std::string& settings) const;

    const Findings& f_;
    const Analysis& a_;
    std::string out_;
};

void Page::summary() {
    add("<h1>Speed and accuracy of {}</h1>\n<p class=\"lead\">{} settings measured against a path-traced reference. "
        "Light of the "
        "level: {}.</p>\n",
        escaped(f_.level), f_.measurements.size(), escaped(f_.lights));
    if (!f_.complete)
        add("<div class=\"card warn\"><p><strong>Not complete:</strong> {}; {} of {} measured. The same command goes "
            "on where it "
            "stopped.</p></div>\n",
            escaped(f_.why), f_.measurements.size(), f_.planned);
    add("<div class=\"card\"><ul>\n");
    for (const std::string& line : advice(f_, a_)) add("<li>{}</li>\n", escaped(line));
    if (const Measurement* const m = find(""))
        add("<li>The default: {} % error (median {} %), {} ms a frame; {} ms before the first frame and {} ms of "
            "refinement once; "
            "{} MB.</li>\n",
            plusMinus(m->error, m->errorDeviation), shown(m->median, percent), shown(m->frameMs), shown(m->readyMs),
            shown(m->refineMs), shown(m->bytes, perMegabyte));
    add("</ul></div>\n");
}

std::string Page::frontPlot(const std::vector<std::size_t>& front, const PlotAxis& x,
                            double (*time)(const Measurement&, double)) const {
    Plot plot;
    plot.x = x;
    plot.y = {"error of the picture, %", true, {}};
    plot.width = 760;
    plot.height = 440;
    Series gather{"gather", 0, false, {}};
    Series map{"photon map (true_area, nearest)", 2, false, {}};
    Series best{"the front: nothing is faster and as accurate", 1, true, {}};
    for (const std::size_t i : a_.compared) {
        const Measurement& m = f_.measurements[i];
        const bool gathers = changed(f_.base, m.settings).estimator == pie::engine::EstimatorKind::Gather;
        (gathers ? gather : map).marks.push_back({time(m, a_.near), percent * m.error, 0, title(m), ""});
    }
    for (std::size_t n = 0; n < front.size(); ++n) {
        const Measurement& m = f_.measurements[front[n]];
        best.marks.push_back(
            {time(m, a_.near), percent * m.error, percent * m.errorDeviation, title(m), std::to_string(n + 1)});
    }
    plot.series = {gather, map, best};
    return svg(plot);
}

std::string Page::frontTable(const std::vector<std::size_t>& front) const {
    std::vector<std::vector<std::string>> rows;
    for (std::size_t n = 0; n < front.size(); ++n) {
        const Measurement& m = f_.measurements[front[n]];
        rows.push_back({std::to_string(n + 1), code(command(f_, m)), plusMinus(m.error, m.errorDeviation),
                        shown(m.median, percent), shown(m.frameMs), shown(m.refineMs), shown(m.within20Ms),
                        shown(m.within10Ms), shown(m.within5Ms), shown(m.bytes, perMegabyte)});
    }
    return table({"", "command that reproduces it", "error, %", "median, %", "ms a frame", "refine once, ms",
                  "20 % after, ms", "10 % after, ms", "5 % after, ms", "MB"},
                 rows, 2);
}

void Page::fronts() {
    add("<h2>Error and time of a frame</h2>\n<p>A frame traces its photons anew, sums them up and estimates everything "
        "in view. "
        "Down and left is better. Lines through points are one standard error.</p>\n{}{}",
        frontPlot(a_.frames, {"milliseconds a frame", true, {}},
                  [](const Measurement& m, double /*near*/) { return m.frameMs; }),
        frontTable(a_.frames));
    const std::string near = fmt::format("milliseconds until within {:g} % of the truth", percent * a_.near);
    add("<h2>Error and time to an acceptable picture</h2>\n<p>From the file on disk to the first frame from which on "
        "the error stays "
        "below {:g} %; the error is the one at the end. Settings that never come so near are not here.</p>\n{}{}",
        percent * a_.near, frontPlot(a_.pictures, {near, true, {}}, pictureMs), frontTable(a_.pictures));
}

const Measurement* Page::find(const std::string& settings) const {
    for (const Measurement& m : f_.measurements)
        if (m.settings == settings) return &m;
    return nullptr;
}

void Page::sweeps() {
    if (f_.sweeps.empty()) return;
    add("<h2>One parameter at a time</h2>\n<p>The others as in the default. “Once” is what happens before the picture "
        "stands: scene, "
        "mesh and texels, and the refinement of all that is in view.</p>\n");
    for (const Sweep& sweep : f_.sweeps) {
        const bool atVertices = sweep.key != "max_edge";
        Plot error{{sweep.key, false, sweep.values}, {"error, %", false, {}}, {}, 310, 210};
        Plot frame{{sweep.key, false, sweep.values}, {"ms a frame", false, {}}, {}, 310, 210};
        Plot once{{sweep.key, false, sweep.values}, {"ms once", false, {}}, {}, 310, 210};
        Series picture{atVertices ? "picture" : "", 1, true, {}};
        Series vertices{"at vertices", 3, true, {}};
        Series frames{"", 1, true, {}};
        Series onces{"", 1, true, {}};
        std::vector<std::vector<std::string>> rows;
        for (std::size_t i = 0; i < sweep.settings.size(); ++i) {
            const Measurement* const m = find(sweep.settings[i]);
            if (m == nullptr) continue;
            const auto x = static_cast<double>(i);
            picture.marks.push_back({x, percent * m->error, percent * m->errorDeviation, title(*m), ""});
            vertices.marks.push_back({x, percent * m->vertexError, percent * m->vertexErrorDeviation, title(*m), ""});
            frames.marks.push_back({x, m->frameMs, 0, title(*m), ""});
            onces.marks.push_back({x, m->readyMs + m->refineMs, 0, title(*m), ""});
            rows.push_back({escaped(sweep.values[i]), plusMinus(m->error, m->errorDeviation), shown(m->median, percent),
                            plusMinus(m->vertexError, m->vertexErrorDeviation), shown(m->frameMs), shown(m->traceMs),
                            shown(m->buildMs), shown(m->estimateMs), shown(m->readyMs), shown(m->refineMs),
                            shown(m->within10Ms), shown(m->bytes, perMegabyte)});
        }
        error.series = {picture};
        if (atVertices) error.series.push_back(vertices);
        frame.series = {frames};
        once.series = {onces};
        add("<h3>{}{}</h3>\n<div class=\"row\">{}{}{}</div>\n<details><summary>numbers</summary>{}</details>\n",
            code(sweep.key), sweep.with.empty() ? "" : " with " + code(sweep.with), svg(error), svg(frame), svg(once),
            table({escaped(sweep.key), "error, %", "median, %", "at vertices, %", "ms a frame", "trace", "build",
                   "estimate", "ready, ms", "refine, ms", "10 % after, ms", "MB"},
                  rows));
    }
}

void Page::everything() {
    std::vector<std::size_t> order(f_.measurements.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return f_.measurements[a].error < f_.measurements[b].error; });
    std::vector<std::vector<std::string>> rows;
    for (const std::size_t i : order) {
        const Measurement& m = f_.measurements[i];
        rows.push_back({code(shortName(m)), m.stage, plusMinus(m.error, m.errorDeviation), shown(m.median, percent),
                        shown(m.frameMs), shown(m.refineMs), shown(m.within10Ms), shown(m.receivers), shown(m.photons),
                        shown(m.bytes, perMegabyte)});
    }
    add("<h2>Everything measured</h2>\n<details><summary>{} settings, the most accurate first; measurements.csv has "
        "all columns"
        "</summary>{}</details>\n",
        rows.size(),
        table({"beside the common settings", "why", "error, %", "median, %", "ms a frame", "refine once, ms",
               "10 % after, ms", "receivers in view", "photons a frame", "MB"},
              rows, 2));
}

void Page::method() {
    add("<h2>How it was measured</h2>\n<p>The error of the picture is taken at {} random points of the surfaces in "
        "view, each with the "
        "light that its triangle's corners have: so it holds the estimator's errors and what the mesh is too coarse "
        "for. “At vertices” is "
        "without the latter, at {} vertices of the default's mesh. A point's deviation is |E − E<sub>0</sub>| over the "
        "larger of both plus a "
        "tenth of the mean; the error is its root mean square, less the noise of the reference, whose standard error "
        "is {} % in the mean. "
        "Median: of |E − E<sub>0</sub>| / E<sub>0</sub>. After ± stands the standard error by the choice of points. "
        "Times are {}. "
        "Reading the level took {} ms. Memory is that of scene, intersector, photons, texels, rows and "
        "receivers.</p>\n",
        f_.points, f_.vertices, shown(f_.truthDeviation, percent),
        f_.processorTime ? "processor time of all threads together" : "by the clock on the wall", shown(f_.loadMs));
    std::vector<std::vector<std::string>> rows;
    for (const auto& [name, value] : f_.identity) rows.push_back({escaped(name), value.empty() ? "–" : code(value)});
    const Measurement* const m = find("");
    if (m != nullptr && f_.base.threads == 1)
        rows.push_back(
            {"busy", fmt::format("{} × the processor time passed on the clock (1: the machine did nothing else)",
                                 shown(m->busy, 1, 2))});
    out_ += table({"", ""}, rows, 2);
}

} // namespace

std::string reportHtml(const Findings& found, const Analysis& analysis) { return Page(found, analysis).html(); }

} // namespace pietrade
