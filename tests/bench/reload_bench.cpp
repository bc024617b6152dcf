// From a save to its light: how long a level takes from its file to a node, refined, to the first frame that shows its
// light, and until that is within five per cent of what it settles to.
//
//   reload_bench LEVEL [times] [key=value …]      prints one line of JSON, medians of `times` (3) loads
//
// The light is that of what the first player start sees, 90 degrees wide; the error is the mean absolute difference
// over the mean. Wall clock, as an author waits by it: nothing else should run.

#include "apps/pietrade/view.h"
#include "osgPlugins/osgpie/load.h"
#include "pie/core/clock.h"
#include "pie/core/parallel.h"
#include "tests/bench/timing.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using namespace pie;

/// Milliseconds since the save.
struct Reload {
    double read = 0, refined = 0, lit = 0, close = 0, settled = 0;
    std::size_t frames = 0;
};

struct Picture {
    double milliseconds = 0;
    std::vector<Rgb> light;
};

double error(const std::vector<Rgb>& light, const std::vector<Rgb>& settled) {
    double difference = 0;
    double sum = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
        difference += static_cast<double>(meanChannel(glm::abs(light[i] - settled[i])));
        sum += static_cast<double>(meanChannel(settled[i]));
    }
    return sum > 0 ? difference / sum : 0;
}

Result<Reload> reload(const std::string& level, const engine::Settings& settings) {
    constexpr std::size_t most = 20'000;
    constexpr double closeEnough = 0.05;
    Reload result;
    const auto start = Clock::now();
    auto node = osgpie::loadLevelNode(level, settings);
    if (!node) return node.error();
    result.read = millisecondsSince(start);
    (*node)->complete();
    result.refined = millisecondsSince(start);
    engine::Engine& engine = (*node)->engine();
    const level::Level::View first = engine.level().firstView();
    const auto view = pietrade::seen(engine.mesh(), engine.level(), engine.receivers(),
                                     pietrade::Camera{first.eye, first.yaw, 0}, 1000);
    std::vector<Picture> pictures;
    do {
        engine.advance();
        Picture& picture = pictures.emplace_back();
        picture.light.resize(view.receivers.size());
        engine.irradiance(view.receivers, picture.light);
        picture.milliseconds = millisecondsSince(start);
    } while (!engine.statistics().still && pictures.size() < most);
    result.frames = pictures.size();
    result.lit = pictures.front().milliseconds;
    result.settled = pictures.back().milliseconds;
    const std::vector<Rgb>& settled = pictures.back().light;
    // From here on it stays so: a frame that is near by chance does not count.
    std::size_t close = pictures.size();
    while (close > 0 && error(pictures[close - 1].light, settled) <= closeEnough) --close;
    result.close = pictures[std::min(close, pictures.size() - 1)].milliseconds;
    return result;
}

double medianOf(const std::vector<Reload>& reloads, double Reload::*what) {
    std::vector<double> values;
    values.reserve(reloads.size());
    for (const Reload& one : reloads) values.push_back(one.*what);
    return bench::median(values);
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        fmt::print(stderr, "usage: reload_bench LEVEL [times] [key=value …]\n");
        return 2;
    }
    const int times = argc > 2 ? std::max(1, std::atoi(argv[2])) : 3;
    engine::Settings settings;
    for (int i = 3; i < argc; ++i)
        if (const auto set = settings.setPair(argv[i], engine::Source::CommandLine); !set)
            return fmt::print(stderr, "{}\n", set.error().message()), 2;
    std::vector<Reload> reloads;
    for (int i = 0; i < times; ++i) {
        const Result<Reload> one = reload(argv[1], settings);
        if (!one) return fmt::print(stderr, "{}\n", one.error().message()), 1;
        reloads.push_back(*one);
    }
    fmt::print(
        "{{\"level\":\"{}\",\"threads\":{},\"load\":{},\"read_ms\":{:.0f},\"refined_ms\":{:.0f},\"lit_ms\":{:.0f},"
        "\"within_5_percent_ms\":{:.0f},\"settled_ms\":{:.0f},\"frames\":{}}}\n",
        argv[1], threads(), bench::loadAverage(), medianOf(reloads, &Reload::read), medianOf(reloads, &Reload::refined),
        medianOf(reloads, &Reload::lit), medianOf(reloads, &Reload::close), medianOf(reloads, &Reload::settled),
        reloads.back().frames);
    return 0;
}
