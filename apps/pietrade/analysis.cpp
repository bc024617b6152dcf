#include "apps/pietrade/analysis.h"

#include "apps/pietrade/front.h"

#include <fmt/format.h>

#include <cmath>

namespace pietrade {
namespace {

/// Numbers into Findings::measurements, from numbers into a part of them.
std::vector<std::size_t> through(const std::vector<std::size_t>& part, const std::vector<std::size_t>& numbers) {
    std::vector<std::size_t> result;
    for (const std::size_t i : numbers) result.push_back(part[i]);
    return result;
}

std::optional<std::size_t> through(const std::vector<std::size_t>& part, std::optional<std::size_t> number) {
    return number ? std::optional(part[*number]) : std::nullopt;
}

std::string named(const Measurement& m) { return m.settings.empty() ? "the default" : m.settings; }

} // namespace

double pictureMs(const Measurement& m, double near) { return near > 0.1 ? m.within20Ms : m.within10Ms; }

Analysis analyse(const Findings& found) {
    Analysis a;
    std::vector<Cost> frames;
    std::size_t reached = 0;
    for (std::size_t i = 0; i < found.measurements.size(); ++i) {
        const Measurement& m = found.measurements[i];
        // Other numbers of threads are no other point of the trade.
        if (changed(found.base, m.settings).threads != found.base.threads) continue;
        a.compared.push_back(i);
        frames.push_back({m.error, m.frameMs});
        reached += std::isnan(m.within10Ms) ? 0 : 1;
    }
    constexpr std::size_t few = 5;
    a.near = reached < few ? 0.2 : 0.1;
    std::vector<Cost> pictures;
    for (const std::size_t i : a.compared)
        pictures.push_back({found.measurements[i].error, pictureMs(found.measurements[i], a.near)});
    a.frames = through(a.compared, front(frames));
    a.pictures = through(a.compared, front(pictures));
    for (const double ms : {1.0, 2.0, 4.0, 8.0, 16.0, 33.0})
        a.byFrame.push_back({ms, through(a.compared, bestWithin(frames, ms))});
    for (const double error : {0.2, 0.1, 0.05, 0.03, 0.02})
        a.byError.push_back({error, through(a.compared, fastestWithin(frames, error))});
    a.byPicture.push_back({a.near, a.pictures.empty() ? std::nullopt : std::optional(a.pictures.front())});
    return a;
}

std::string options(const Findings& found, const Measurement& m) {
    return optionString(changed(found.base, m.settings));
}

std::string command(const Findings& found, const Measurement& m) {
    const std::string settings = options(found, m);
    return settings.empty() ? fmt::format("osgviewer {}", found.levelArgument)
                            : fmt::format("osgviewer -O \"{}\" {}", settings, found.levelArgument);
}

std::vector<std::string> advice(const Findings& found, const Analysis& analysis) {
    std::vector<std::string> lines;
    const auto& all = found.measurements;
    std::size_t last = all.size(); // no number
    for (const auto& [ms, choice] : analysis.byFrame) {
        if (!choice || *choice == last) continue; // more time buys nothing
        last = *choice;
        lines.push_back(fmt::format("For {:g} ms a frame take {}: an error of {:.1f} % at {:.1f} ms.", ms,
                                    named(all[*choice]), 100 * all[*choice].error, all[*choice].frameMs));
    }
    last = all.size();
    for (const auto& [error, choice] : analysis.byError) {
        if (!choice) {
            lines.push_back(fmt::format("Nothing measured here has an error of {:g} % or less.", 100 * error));
            break;
        }
        if (*choice == last) continue;
        last = *choice;
        lines.push_back(fmt::format("For {:g} % error take {}: {:.1f} ms a frame, {:.1f} %.", 100 * error,
                                    named(all[*choice]), all[*choice].frameMs, 100 * all[*choice].error));
    }
    for (const auto& [near, choice] : analysis.byPicture)
        if (choice)
            lines.push_back(fmt::format("First within {:g} % of the truth is {}: {:.0f} ms after the level is opened.",
                                        100 * near, named(all[*choice]), pictureMs(all[*choice], near)));
    return lines;
}

} // namespace pietrade
