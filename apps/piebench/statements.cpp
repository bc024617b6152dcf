// What the pi-engine's paper says of its parameters, measured. Times are relative as there (4.5.1): with over without,
// so "25 % faster" is 0.75.

#include "apps/piebench/machine.h"
#include "apps/piebench/paper.h"
#include "apps/piebench/stop.h"
#include "pie/core/clock.h"
#include "pie/core/parallel.h"
#include "pie/engine/options.h"

#include <fmt/format.h>
#include <glm/trigonometric.hpp>

#include <cmath>
#include <iterator>

namespace piebench {
namespace {

using pie::engine::Settings;

enum class Claim : std::uint8_t {
    Change, ///< a relative time: agrees when it changes the same way, by half to twice as much (in logarithms)
    Little, ///< no more than a tenth
    Size,   ///< a number: agrees within a factor of 1.5
    Order,  ///< 1 where an order holds, 0 where not
};

struct Statement {
    const char* what;
    const char* where;
    Claim claim;
    double paper, measured;
};

const char* verdict(const Statement& s) {
    switch (s.claim) {
    case Claim::Little: return std::abs(s.measured - 1) <= 0.1 ? "agrees" : "disagrees";
    case Claim::Order: return s.measured == s.paper ? "agrees" : "disagrees";
    case Claim::Size:
        return std::abs(std::log(s.measured / s.paper)) <= std::log(1.5) ? "agrees"
               : s.measured > s.paper                                    ? "larger"
                                                                         : "smaller";
    case Claim::Change: break;
    }
    const double share = std::log(s.measured) / std::log(s.paper);
    return share <= 0    ? "disagrees"
           : share < 0.5 ? "same direction, less"
           : share <= 2  ? "agrees"
                         : "same direction, more";
}

/// The measurements behind the statements.
class Bench {
public:
    Bench(const PaperOptions& options, const Settings& settings)
        : seconds_(options.seconds), settings_(paperSettings(settings)),
          small_(valueOr(load(bundledLevel("small"), settings_))),
          normal_(valueOr(load(bundledLevel("normal"), settings_))),
          cornell_(valueOr(load(bundledLevel("cornell"), settings_))) {}

    [[nodiscard]] std::vector<Statement> all() const;

private:
    [[nodiscard]] Stages time(const Subject& subject, const Settings& settings, std::uint64_t photons,
                              std::size_t accumulation = 10) const {
        const auto frames = pacedFrames(Estimator::Nearest, subject, settings, photons, accumulation);
        return paced(*frames, accumulation, seconds_);
    }
    [[nodiscard]] double ms(const Subject& subject, const Settings& settings, std::uint64_t photons,
                            std::size_t accumulation = 10) const {
        return frameMs(time(subject, settings, photons, accumulation));
    }
    [[nodiscard]] Settings with(const char* pair) const {
        Settings own = settings_;
        valueOr(own.setPair(pair, pie::engine::Source::CommandLine));
        return own;
    }
    [[nodiscard]] Subject unrefined(const LoadedLevel& level) const {
        return valueOr(refined(level, level.mesh.triangles.size(), settings_));
    }
    [[nodiscard]] double treeOverNone(const LoadedLevel& level) const;
    [[nodiscard]] double primaryRayMs(const LoadedLevel& level) const;
    void flashlight(std::vector<Statement>& list) const;

    double seconds_;
    Settings settings_;
    LoadedLevel small_, normal_, cornell_;
};

/// 200 photons a frame over ten, the values of parameters 9 and 10.
double Bench::treeOverNone(const LoadedLevel& level) const {
    const Subject subject = unrefined(level);
    return ms(subject, with("intersector=bsp"), 2000) / ms(subject, with("intersector=brute_force"), 2000);
}

/// Milliseconds of 10,000 photons without a reflection, by the level's tree.
double Bench::primaryRayMs(const LoadedLevel& level) const {
    constexpr std::uint64_t count = 10'000;
    const pie::lights::LightSet lights(level.lights, level.scene);
    const auto tree = pie::intersect::makeIntersector(pie::intersect::Kind::Bsp, *level.scene, level.level->tree);
    pie::photons::TracerOptions options;
    options.recursionDepth = 0;
    options.storeDirectLight = true;
    const pie::photons::PhotonTracer tracer(*level.scene, lights, *tree, options);
    std::vector<pie::photons::Photon> photons;
    std::vector<double> times;
    const auto start = pie::Clock::now();
    while (times.size() < 3 || pie::millisecondsSince(start) < 1e3 * seconds_) {
        photons.clear();
        const auto began = pie::Clock::now();
        const double processor = pie::processorMilliseconds();
        tracer.trace(0, count, photons);
        times.push_back(pie::threads() == 1 ? pie::processorMilliseconds() - processor : pie::millisecondsSince(began));
    }
    return median(std::move(times));
}

/// Fig 6.9: 10,369 triangles, a spot light at the eye, 100 photons a frame, nine reflections of each.
void Bench::flashlight(std::vector<Statement>& list) const {
    constexpr std::size_t triangles = 10'369;
    LoadedLevel lit = small_;
    const pie::level::Level::View view = small_.level->firstView();
    pie::lights::SpotLight spot;
    spot.position = view.eye;
    spot.direction = {std::cos(glm::radians(view.yaw)), std::sin(glm::radians(view.yaw)), 0.0F};
    spot.power = pie::Rgb(1e8F);
    lit.lights = {spot};
    Settings settings = with("scattering=split");
    settings.recursionDepth = 1;
    settings.diffuseReflections = 9;
    const Subject cached = valueOr(refined(lit, triangles, settings));
    const Subject corners = valueOr(refined(lit, triangles, settings, Questions::PerCorner));
    // A photon that hits is stored, and so are its nine reflections: 1,000 a frame, less what leaves through the sky.
    const double withCache = ms(cached, settings, 10'000);
    const double without = ms(corners, settings, 10'000);
    list.push_back({"estimate cache, flashlight of fig 6.9: 21 frames a second become 30", "6.3", Claim::Change,
                    21.0 / 30, withCache / without});
    list.push_back({"without the cache a vertex is estimated up to 5–6 times", "parameter 3", Claim::Size, 5.5,
                    static_cast<double>(corners.which.size()) / static_cast<double>(cached.which.size())});
}

std::vector<Statement> Bench::all() const {
    std::vector<Statement> list;
    const double treeSmall = treeOverNone(small_);
    const double treeNormal = treeOverNone(normal_);
    list.push_back({"BSP tree, small level, not refined: 25 % faster", "parameter 1", Claim::Change, 0.75, treeSmall});
    list.push_back({"BSP tree, normal level: 75 % faster", "parameter 1", Claim::Change, 0.25, treeNormal});
    list.push_back({"the larger level gains more from the tree (1: yes)", "parameter 1", Claim::Order, 1,
                    treeNormal < treeSmall ? 1.0 : 0.0});
    list.push_back({"15 times the triangles take 7.7 times as long for a primary ray, by the tree", "6.3", Claim::Size,
                    47'500.0 / 6'200, primaryRayMs(normal_) / primaryRayMs(small_)});
    flashlight(list);

    const Subject refinedSmall = valueOr(refined(small_, 10'369, settings_));
    list.push_back({"sphere slice: little impact on the time", "parameter 7", Claim::Little, 1,
                    ms(refinedSmall, with("use_sphere_slice=true"), 10'000) /
                        ms(refinedSmall, with("use_sphere_slice=false"), 10'000)});
    const Subject box = valueOr(refined(cornell_, 0, settings_));
    list.push_back({"k = 50 in place of 200, Cornell box: 50 % faster", "parameter 4", Claim::Change, 0.5,
                    ms(box, with("max_search_count=50"), 20'000) / ms(box, with("max_search_count=200"), 20'000)});

    list.push_back({"photons and triangles both doubled: half the frame rate (6,400 to 12,800)", "table 6.1",
                    Claim::Size, 27.0 / 12,
                    ms(valueOr(refined(small_, 12'800, settings_)), settings_, 12'800) /
                        ms(valueOr(refined(small_, 6'400, settings_)), settings_, 6'400)});
    const Subject whole = unrefined(normal_);
    const double once = ms(whole, settings_, 10'000, 1);
    const double sixteen = ms(whole, settings_, 10'000, 16);
    list.push_back({"16 accumulation frames in place of 1: a frame takes a 13th", "table 6.2", Claim::Change,
                    0.63 / 8.25, sixteen / once});
    list.push_back({"and all photons are renewed in 1.22 times the time", "table 6.2", Claim::Size, 1.94 / 1.59,
                    16 * sixteen / once});
    const Stages large = time(valueOr(refined(normal_, 55'000, settings_)), with("intersector=bsp"), 15'000);
    list.push_back({"55,000 triangles, 1,500 photons a frame: intersection takes 94 % of it", "6.3", Claim::Size,
                    1 - 2.5 / 40, large.trace / large.total});
    return list;
}

} // namespace

Json statements(const PaperOptions& options, const Settings& settings) {
    Json report{{"program", "piebench"}, {"command", "statements"}, {"machine", machineJson()}};
    report["threads"] = pie::threads();
    report["time"] = pie::threads() == 1 ? "processor" : "wall clock";
    report["statements"] = Json::array();
    for (const Statement& s : Bench(options, settings).all())
        report["statements"].push_back({{"statement", s.what},
                                        {"where", s.where},
                                        {"paper", rounded(s.paper, 3)},
                                        {"measured", rounded(s.measured, 3)},
                                        {"verdict", verdict(s)}});
    report["load_after"] = load();
    return report;
}

std::string statementsText(const Json& report) {
    fmt::memory_buffer text;
    const auto to = std::back_inserter(text);
    fmt::format_to(to,
                   "{}, {} thread(s), {} time. Relative times are with over without.\n\n"
                   "| the paper | where | its number | measured | |\n|---|---|---|---|---|\n",
                   report["machine"]["processor"].get<std::string>(), report["threads"].get<unsigned>(),
                   report["time"].get<std::string>());
    for (const Json& s : report["statements"])
        fmt::format_to(to, "| {} | {} | {:.3g} | {:.3g} | {} |\n", s["statement"].get<std::string>(),
                       s["where"].get<std::string>(), s["paper"].get<double>(), s["measured"].get<double>(),
                       s["verdict"].get<std::string>());
    return fmt::to_string(text);
}

} // namespace piebench
