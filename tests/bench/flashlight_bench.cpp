// The flashlight of pi-engine, fig 6.9: a level refined to as many triangles as theirs, a spot light at the view that
// walks along a path, every receiver asked for in every frame. How long frames take against a budget, and how much
// what is seen fluctuates: between frames of a still scene, while the light stands still but is taken for changed, and
// after it has stopped.
//
//   flashlight_bench LEVEL [triangles] [budget_ms] [threads]      prints one line of JSON
//
// Wall clock, as a budget is one of wall clock: nothing else should run.

#include "pie/brushes/load.h"
#include "pie/core/clock.h"
#include "pie/core/parallel.h"
#include "pie/engine/engine.h"
#include "tests/bench/timing.h"

#include <fmt/format.h>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

namespace {

using namespace pie;

struct Walk {
    engine::Engine& engine;
    std::size_t number;
    Vec3 eye;
    double yaw; ///< radians
    std::vector<std::uint32_t> which;
    std::vector<Rgb> light;
    std::vector<double> times;

    /// One frame with the light at `step` of its path; negative: left as it is. In batches as large as drawables are.
    void frame(double step) {
        constexpr std::size_t drawable = 1000;
        if (step >= 0) {
            // To and fro ahead of the player's start, looking about.
            const double turn = yaw + 0.8 * std::sin(0.02 * step);
            const double ahead = 60 - 60 * std::cos(0.01 * step);
            lights::SpotLight spot;
            spot.position = eye + static_cast<float>(ahead) *
                                      Vec3(static_cast<float>(std::cos(yaw)), static_cast<float>(std::sin(yaw)), 0.0F);
            spot.direction = Vec3(static_cast<float>(std::cos(turn)), static_cast<float>(std::sin(turn)), -0.1F);
            spot.power = Rgb(4 * std::numbers::pi_v<float> * 7500 * 500);
            engine.setLight(number, spot);
        }
        const auto start = Clock::now();
        engine.advance();
        for (std::size_t first = 0; first < which.size(); first += drawable) {
            const std::size_t count = std::min(drawable, which.size() - first);
            engine.irradiance(std::span(which).subspan(first, count), std::span(light).subspan(first, count));
        }
        times.push_back(millisecondsSince(start));
    }
};

double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values.empty()
               ? 0
               : values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

/// Standard deviation of every vertex over frames, root mean square over vertices, per cent of their mean light.
class Fluctuation {
public:
    void add(const std::vector<Rgb>& light) {
        sum_.resize(light.size(), 0);
        squares_.resize(light.size(), 0);
        for (std::size_t i = 0; i < light.size(); ++i) {
            const auto value = static_cast<double>(meanChannel(light[i]));
            sum_[i] += value;
            squares_[i] += value * value;
        }
        ++frames_;
    }
    [[nodiscard]] double percent() const {
        double variance = 0;
        double mean = 0;
        for (std::size_t i = 0; i < sum_.size(); ++i) {
            variance += std::max(0.0, squares_[i] / frames_ - sum_[i] * sum_[i] / (frames_ * frames_));
            mean += sum_[i] / frames_;
        }
        const auto count = static_cast<double>(sum_.size());
        return mean > 0 ? 100 * std::sqrt(variance / count) / (mean / count) : 0;
    }

private:
    std::vector<double> sum_, squares_;
    double frames_ = 0;
};

double difference(const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
    double sum = 0;
    double mean = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const auto d = static_cast<double>(meanChannel(a[i]) - meanChannel(b[i]));
        sum += d * d;
        mean += static_cast<double>(meanChannel(b[i]));
    }
    const auto count = static_cast<double>(a.size());
    return 100 * std::sqrt(sum / count) / (mean / count);
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        fmt::print(stderr, "usage: flashlight_bench LEVEL [triangles] [budget_ms] [threads]\n");
        return 2;
    }
    const std::size_t triangles = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 10'369;
    engine::Settings settings;
    settings.budgetMs = argc > 3 ? std::strtof(argv[3], nullptr) : 8.0F;
    setThreads(argc > 4 ? static_cast<unsigned>(std::atoi(argv[4])) : 0);
    auto location = level::locate(argv[1], "");
    if (!location) return fmt::print(stderr, "{}\n", location.error().message()), 1;
    auto loaded = brushes::loadLevel(*std::move(location));
    if (!loaded) return fmt::print(stderr, "{}\n", loaded.error().message()), 1;
    auto level = std::make_shared<const level::Level>(*std::move(loaded));
    // Edges as long as it takes: the number of triangles is what was asked for.
    for (const char* pair : {"max_edge=1"})
        if (!settings.setPair(pair, engine::Source::CommandLine)) return 1;
    settings.maxTriangles = static_cast<int>(triangles);
    engine::Engine engine(level, settings);
    engine.prepare();
    Walk walk{engine,
              engine.lightCount(),
              level->firstView().eye,
              glm::radians(static_cast<double>(level->firstView().yaw)),
              {},
              {},
              {}};
    walk.which.resize(engine.receivers().points.size());
    std::iota(walk.which.begin(), walk.which.end(), 0U);
    walk.light.resize(walk.which.size());
    constexpr int most = 20'000;
    int frames = 0;
    // The level alone, until it is still.
    do walk.frame(-1);
    while (!engine.statistics().still && ++frames < most);
    const std::size_t settledAfter = walk.times.size();
    Fluctuation still;
    for (int i = 0; i < 100; ++i) {
        walk.frame(-1);
        still.add(walk.light);
    }
    const double stillMs = quantile({walk.times.end() - 100, walk.times.end()}, 0.5);
    for (int i = 0; i < 100; ++i) walk.frame(0); // costs get known
    walk.times.clear();
    for (int i = 0; i < 600; ++i) walk.frame(i);
    const double median = quantile(walk.times, 0.5);
    const double high = quantile(walk.times, 0.95);
    // Stopped, but set anew in every frame.
    for (int i = 0; i < 60; ++i) walk.frame(599);
    Fluctuation held;
    for (int i = 0; i < 100; ++i) {
        walk.frame(599);
        held.add(walk.light);
    }
    // Left alone: it goes on to converge.
    const std::vector<Rgb> before = walk.light;
    Fluctuation converging;
    frames = 0;
    double largestStep = 0;
    std::vector<Rgb> last = walk.light;
    do {
        walk.frame(-1);
        converging.add(walk.light);
        largestStep = std::max(largestStep, difference(walk.light, last));
        last = walk.light;
    } while (!engine.statistics().still && ++frames < most);
    fmt::print("{{\"level\":\"{}\",\"triangles\":{},\"receivers\":{},\"threads\":{},\"load\":{},\"budget_ms\":{:.3g},"
               "\"settled_after_frames\":{},\"still_ms\":{:.4f},\"moving_ms_median\":{:.3f},\"moving_ms_p95\":{:.3f},"
               "\"still_fluctuation_percent\":{:.5f},\"held_fluctuation_percent\":{:.5f},"
               "\"converging_fluctuation_percent\":{:.4f},\"largest_step_percent\":{:.4f},\"stop_to_still_frames\":{},"
               "\"stop_to_still_change_percent\":{:.4f}}}\n",
               level->name, engine.mesh().triangles.size(), walk.which.size(), threads(), bench::loadAverage(),
               static_cast<double>(settings.budgetMs), settledAfter, stillMs, median, high, still.percent(),
               held.percent(), converging.percent(), largestStep, frames, difference(walk.light, before));
    return 0;
}
