// One photon map against several (pie::maps::Partition), on shipped levels, in one run and one thread: build and search
// of the same photons for the same receivers, what searches look at, and how far the light is from one map's. Rounds
// alternate between the kinds; times are medians of processor time.
//
//   split_bench time [photons] [rounds] [level …]       prints CSV
//   split_bench error [photons] [receivers] [level …]   the same against the path tracer
//
// time: estimate (disc: area pi_r2; true_area), split, maps with photons, cells of the level, milliseconds of build
// and search, tree nodes (leaves among them), photons read and photons used per receiver, and the share of receivers
// whose light differs by more than a tenth from that of one map.
//
// error: reflected light from photons and exact direct light, E, against the path tracer's R at 2 % standard error (or
// 65,536 paths), for a whole sphere, for the slice and over the true area: root mean square of (E − R) / (R + mean R /
// 10), and mean of E − R over mean R.

#include "pie/core/parallel.h"
#include "pie/gather/nearest_photons.h"
#include "pie/lights/import.h"
#include "pie/photons/tracer.h"
#include "pie/reference/path_tracer.h"
#include "pie/scene/mesh.h"
#include "tests/bench/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

namespace {

using pie::Rgb;
using pie::bench::median;
using pie::bench::milliseconds;
using pie::gather::AreaEstimate;
using pie::gather::NearestOptions;
using pie::gather::NearestPhotons;
using pie::maps::Partition;
using pie::maps::RealtimeMap;
using pie::maps::SplitBy;
using pie::photons::Photon;

constexpr SplitBy kinds[] = {SplitBy::None, SplitBy::Normal, SplitBy::Cell, SplitBy::Both};
constexpr const char* names[] = {"none", "normal", "cell", "both"};

struct Level {
    pie::level::Level level;
    std::shared_ptr<pie::scene::Scene> scene;
    std::vector<pie::lights::Light> sources;
    std::unique_ptr<pie::intersect::Intersector> embree;
    pie::scene::Receivers receivers;
    std::vector<Photon> photons;

    Level(pie::level::Level loaded, std::uint64_t count)
        : level(std::move(loaded)), scene(std::make_shared<pie::scene::Scene>(pie::scene::makeScene(level))),
          sources(pie::lights::importLights(level, *scene).lights),
          embree(makeIntersector(pie::intersect::Kind::Embree, *scene, level.tree)) {
        const pie::lights::LightSet lights(sources, scene);
        const pie::photons::PhotonTracer tracer(*scene, lights, *embree, {});
        tracer.trace(0, count, photons);
        pie::scene::Mesh mesh = pie::scene::makeMesh(level);
        pie::scene::RefineOptions refine;
        refine.maxEdge = 64;
        pie::scene::refine(mesh, refine);
        receivers = pie::scene::makeReceivers(mesh, level);
    }
};

/// One way to divide the photons.
struct Kind {
    std::shared_ptr<const Partition> partition;
    RealtimeMap map;
    std::unique_ptr<NearestPhotons> estimator;
    std::vector<double> build, search;
    std::vector<Rgb> irradiance;
    double used = 0; ///< photons of an estimate, mean

    Kind(const Level& level, SplitBy by, const NearestOptions& options)
        : partition(by == SplitBy::None ? nullptr
                                        : std::make_shared<const Partition>(*level.scene, level.level.tree, by)),
          map(1, pie::maps::Search::KdTree, partition),
          estimator(std::make_unique<NearestPhotons>(*level.scene, level.receivers, map, options)),
          irradiance(level.receivers.points.size()) {
        map.replaceOldest(std::vector<Photon>(level.photons));
    }
    [[nodiscard]] std::size_t maps() const {
        return map.visit([](const auto& tree) -> std::size_t {
            if constexpr (std::is_same_v<std::decay_t<decltype(tree)>, pie::maps::SplitTree>) return tree.maps();
            return 1;
        });
    }
};

NearestOptions searchOptions(AreaEstimate area) {
    NearestOptions options;
    options.maxCount = 100;
    options.area = area;
    options.kernel = pie::gather::Kernel::Epanechnikov;
    return options;
}

void measure(const std::string& name, const Level& level, AreaEstimate area, std::size_t rounds) {
    const NearestOptions options = searchOptions(area);
    std::vector<std::unique_ptr<Kind>> all;
    for (const SplitBy by : kinds) all.push_back(std::make_unique<Kind>(level, by, options));
    std::vector<std::uint32_t> which(level.receivers.points.size());
    std::iota(which.begin(), which.end(), 0U);
    for (const auto& kind : all) {
        // Also what is made at first sight, as area tables.
        kind->map.rebuild();
        std::vector<pie::gather::Estimate> estimates(which.size());
        kind->estimator->explain(which, estimates);
        for (const auto& estimate : estimates) kind->used += estimate.photons;
        kind->used /= static_cast<double>(which.size());
    }
    for (std::size_t round = 0; round < rounds; ++round)
        for (const auto& kind : all) {
            kind->build.push_back(milliseconds([&] { kind->map.rebuild(); }));
            kind->search.push_back(milliseconds([&] { kind->estimator->estimate(which, kind->irradiance); }));
        }
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Kind& kind = *all[i];
        const auto before = kind.estimator->visits();
        std::vector<Rgb> irradiance(which.size());
        kind.estimator->estimate(which, irradiance);
        const auto after = kind.estimator->visits();
        std::size_t changed = 0;
        for (std::size_t r = 0; r < which.size(); ++r) {
            const float one = pie::meanChannel(all[0]->irradiance[r]);
            changed += std::abs(pie::meanChannel(irradiance[r]) - one) > 0.1F * one ? 1U : 0U;
        }
        const auto count = static_cast<double>(which.size());
        fmt::print("{},{},{},{},{},{},{},{:.2f},{:.2f},{:.1f},{:.1f},{:.1f},{:.4f}\n", name, level.photons.size(),
                   which.size(), area == AreaEstimate::True ? "true_area" : "disc", names[i], kind.maps(),
                   kind.partition == nullptr ? 1 : kind.partition->cells(), median(kind.build), median(kind.search),
                   static_cast<double>(after.nodes - before.nodes + after.leaves - before.leaves) / count,
                   static_cast<double>(after.photons - before.photons) / count, kind.used,
                   static_cast<double>(changed) / count);
        std::fflush(stdout);
    }
}

std::vector<double> trace(const Level& level, std::uint32_t depth) {
    pie::reference::Options options;
    options.target = 0.02;
    options.mostPaths = 1U << 16U;
    options.recursionDepth = depth;
    const pie::reference::PathTracer tracer(level.scene, level.sources, *level.embree, options);
    std::vector<pie::reference::Value> values(level.receivers.points.size());
    tracer.trace(level.receivers.points, values);
    std::vector<double> irradiance;
    for (const auto& value : values)
        irradiance.push_back((value.irradiance.x + value.irradiance.y + value.irradiance.z) / 3);
    return irradiance;
}

void errors(const std::string& name, Level& level, std::size_t receivers) {
    auto& points = level.receivers.points;
    const std::size_t step = std::max<std::size_t>(1, points.size() / receivers);
    for (std::size_t i = 0; i * step < points.size(); ++i) points[i] = points[i * step];
    points.resize((points.size() + step - 1) / step);
    const std::vector<double> direct = trace(level, 0);
    const std::vector<double> truth = trace(level, pie::reference::Options{}.recursionDepth);
    const double mean = std::accumulate(truth.begin(), truth.end(), 0.0) / static_cast<double>(truth.size());
    std::vector<std::uint32_t> which(points.size());
    std::iota(which.begin(), which.end(), 0U);
    struct Way {
        const char* name;
        AreaEstimate area;
        pie::gather::SearchVolume volume;
    };
    for (const Way& way : {Way{"sphere", AreaEstimate::Disc, pie::gather::SearchVolume::Sphere},
                           Way{"disc", AreaEstimate::Disc, pie::gather::SearchVolume::Slice},
                           Way{"true_area", AreaEstimate::True, pie::gather::SearchVolume::Slice}})
        for (std::size_t i = 0; i < std::size(kinds); ++i) {
            NearestOptions options = searchOptions(way.area);
            options.volume = way.volume;
            Kind kind(level, kinds[i], options);
            kind.map.rebuild();
            kind.estimator->estimate(which, kind.irradiance);
            double squares = 0;
            double sum = 0;
            for (std::size_t r = 0; r < which.size(); ++r) {
                const double off = direct[r] + static_cast<double>(pie::meanChannel(kind.irradiance[r])) - truth[r];
                squares += std::pow(off / (truth[r] + 0.1 * mean), 2);
                sum += off;
            }
            const auto count = static_cast<double>(which.size());
            fmt::print("{},{},{},{},{},{:.4f},{:.4f}\n", name, level.photons.size(), which.size(), way.name, names[i],
                       std::sqrt(squares / count), sum / count / mean);
            std::fflush(stdout);
        }
}

} // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): what goes wrong may end a measurement
int main(int count, char** arguments) {
    const std::string mode = count > 1 ? arguments[1] : "time";
    const bool timing = mode == "time";
    const auto number = [&](int at, std::size_t otherwise) {
        return count > at ? std::max<std::size_t>(1, std::strtoull(arguments[at], nullptr, 10)) : otherwise;
    };
    const std::uint64_t photons = number(2, 100'000);
    const std::size_t second = number(3, timing ? 7 : 300);
    std::vector<std::string> levels(arguments + std::min(count, 4), arguments + count);
    if (levels.empty()) levels = {"oa_dm1", "kaos2", "ctf_inyard"};
    if (timing) pie::setThreads(1);
    fmt::print("{}\n", timing
                           ? "level,photons,receivers,estimate,split,maps,cells,build_ms,search_ms,nodes,photons_read,"
                             "photons_used,changed"
                           : "level,photons,receivers,estimate,split,error,mean");
    for (const std::string& name : levels) {
        auto location = pie::level::locate(name, "/usr/share/games/openarena/baseoa");
        auto loaded = location ? pie::level::loadLevel(*std::move(location)) : location.error();
        if (!loaded) return fmt::print(stderr, "split_bench: {}\n", loaded.error().message()), 1;
        Level level(*std::move(loaded), photons);
        if (!timing)
            errors(name, level, second);
        else
            for (const AreaEstimate area : {AreaEstimate::Disc, AreaEstimate::True}) measure(name, level, area, second);
    }
    return 0;
}
