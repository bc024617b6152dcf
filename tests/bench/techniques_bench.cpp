// Bias, noise and time of every technique of the photon map, where the answer is known: a closed cube of 512 units with
// a lamp in its middle, 10,000 photons a frame, at vertices 64 units apart.
//
//   techniques_bench photons     direct light from photons: volumes, areas, kernels
//   techniques_bench frames      the same against the frames in the map: rules for the radius
//   techniques_bench gather      reflected light: from photons, and by final gathering
//   techniques_bench cache       the irradiance cache against gathering everywhere
//
// Prints CSV. Over 16 runs with other photons (gather: 4): bias is the rms over vertices of the mean error, noise that
// of the standard deviation, both in per cent of the mean irradiance of the wall; share: of errors within one standard
// error; time: processor time over that of the paper's estimate in the same run. The answer for one reflection is that
// of 65,536 rays that end in the formula of direct light.

#include "pie/core/parallel.h"
#include "pie/gather/final_gather.h"
#include "pie/photons/tracer.h"
#include "pie/sampling/directions.h"
#include "tests/bench/timing.h"
#include "tests/gather/scenes.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <string_view>

namespace {

using pie::Rgb;
using pie::Vec3;
using pie::gather::AreaEstimate;
using pie::gather::Estimate;
using pie::gather::FinalGatherOptions;
using pie::gather::Kernel;
using pie::gather::NearestOptions;
using pie::gather::NearestPhotons;
using pie::gather::RadiusRule;
using pie::gather::SearchVolume;
using pie::maps::RealtimeMap;

constexpr float side = 512;
constexpr float rho = 0.5F;
constexpr float watts = 1e6F;
constexpr int cells = 8; ///< between vertices of the wall
constexpr std::uint64_t perFrame = 10'000;
constexpr std::uint64_t mostRuns = 16;

double exactDirect(const Vec3& point) {
    const float distance = glm::length(point - 0.5F * side);
    return double{watts} * 0.5 * double{side} / (4 * std::numbers::pi * std::pow(double{distance}, 3));
}

struct Cube {
    std::shared_ptr<const pie::scene::Scene> scene;
    std::unique_ptr<pie::intersect::Intersector> intersector;
    pie::lights::LightSet lights;
    pie::scene::Receivers receivers; ///< vertices of the floor
    std::vector<bool> onEdge;

    Cube() {
        pie::gather::test::SceneBuilder builder;
        builder.grey(rho);
        builder.room(Vec3(0.0F), Vec3(side));
        scene = builder.make();
        intersector = pie::intersect::makeIntersector(pie::intersect::Kind::Embree, *scene, {});
        pie::lights::PointLight lamp;
        lamp.position = Vec3(0.5F * side);
        lamp.power = Rgb(watts);
        lamp.falloff.minDistance = 0;
        lights = pie::lights::LightSet({lamp}, scene);
        for (int y = 0; y <= cells; ++y)
            for (int x = 0; x <= cells; ++x) {
                const Vec3 point(static_cast<float>(x) * side / cells, static_cast<float>(y) * side / cells, 0.0F);
                receivers.points.push_back(pie::gather::test::receiverAt(point, {0.0F, 0.0F, 1.0F}));
                receivers.points.back().inset =
                    glm::clamp(point, Vec3(1.0F, 1.0F, 0.0F), Vec3(side - 1, side - 1, 0.0F));
                onEdge.push_back(x == 0 || y == 0 || x == cells || y == cells);
            }
    }
    /// Photons of a run: as many frames as the map holds.
    void fill(RealtimeMap& map, std::uint64_t run, unsigned depth) const {
        pie::photons::TracerOptions options;
        options.storeDirectLight = true;
        options.recursionDepth = depth;
        const pie::photons::PhotonTracer tracer(*scene, lights, *intersector, options);
        for (std::uint64_t frame = 0; frame < map.accumulationFrames(); ++frame) {
            std::vector<pie::photons::Photon> photons;
            (void)tracer.trace((run * map.accumulationFrames() + frame) * perFrame, perFrame, photons);
            map.replaceOldest(std::move(photons));
        }
        map.rebuild();
    }
    [[nodiscard]] std::vector<double> direct() const {
        std::vector<double> exact;
        for (const auto& at : receivers.points) exact.push_back(exactDirect(at.position));
        return exact;
    }
    [[nodiscard]] std::vector<double> reflected() const;
};

/// Light of all reflections on the walls of the cube, which are all alike: a table over a quarter of a wall, each entry
/// the mean of rays that end in the formula of direct light and in the table, again and again until nothing changes.
class Reflected {
public:
    Reflected() {
        for (int round = 0; round < 25; ++round) {
            std::vector<double> next(table_.size());
            for (int y = 0; y <= steps; ++y)
                for (int x = 0; x <= steps; ++x)
                    next[at(x, y)] = gather({0.5F * side + spacing * static_cast<float>(x),
                                             0.5F * side + spacing * static_cast<float>(y), 0.0F},
                                            4096);
            table_ = next;
        }
    }
    /// At a point of the floor.
    [[nodiscard]] double gather(const Vec3& point, unsigned rays) const {
        const Vec3 origin = glm::clamp(point, Vec3(1.0F, 1.0F, 0.125F), Vec3(side - 1, side - 1, 0.125F));
        double sum = 0;
        for (unsigned i = 0; i < rays; ++i) {
            const Vec3 d = pie::sampling::cosineHemisphere({halton_(i, 0), halton_(i, 1)});
            float t = std::numeric_limits<float>::max();
            int wall = 0;
            for (int axis = 0; axis < 3; ++axis) {
                if (d[axis] == 0.0F) continue;
                const float there = ((d[axis] > 0.0F ? side : 0.0F) - origin[axis]) / d[axis];
                if (there >= t) continue;
                t = there;
                wall = axis;
            }
            const Vec3 hit = origin + t * d;
            sum += exactDirect(hit) + value(hit[(wall + 1) % 3], hit[(wall + 2) % 3]);
        }
        return sum * double{rho} / rays;
    }

private:
    static constexpr int steps = 16;
    static constexpr float spacing = 0.5F * side / steps;
    static std::size_t at(int x, int y) { return static_cast<std::size_t>(y * (steps + 1) + x); }
    [[nodiscard]] double value(float u, float v) const {
        const auto place = [](float w) { return std::min(std::abs(w - 0.5F * side) / spacing, steps - 1e-3F); };
        const float x = place(u);
        const float y = place(v);
        const int i = static_cast<int>(x);
        const int j = static_cast<int>(y);
        const double fx = double{x} - i;
        const double fy = double{y} - j;
        return (1 - fy) * ((1 - fx) * table_[at(i, j)] + fx * table_[at(i + 1, j)]) +
               fy * ((1 - fx) * table_[at(i, j + 1)] + fx * table_[at(i + 1, j + 1)]);
    }
    pie::sampling::Halton halton_;
    std::vector<double> table_ = std::vector<double>((steps + 1) * (steps + 1), 0.0);
};

std::vector<double> Cube::reflected() const {
    const Reflected light;
    std::vector<double> exact;
    for (const auto& receiver : receivers.points) exact.push_back(light.gather(receiver.position, 65'536));
    return exact;
}

/// One line: what an estimator says of `truth` over all runs. `ask` makes it for a map and explains every receiver.
using Ask = std::function<double(const RealtimeMap& map, std::span<const std::uint32_t> which, std::span<Estimate>)>;

void measure(const Cube& cube, std::string_view name, const std::vector<double>& truth, unsigned depth,
             std::size_t frames, const Ask& ask, double& unit, std::uint64_t runs = mostRuns) {
    const std::size_t count = truth.size();
    std::vector<double> sums(count);
    std::vector<double> squares(count);
    double within = 0;
    double seconds = 0;
    double photons = 0;
    const std::vector<std::uint32_t> which = pie::gather::test::all(cube.receivers);
    for (std::uint64_t run = 0; run < runs; ++run) {
        RealtimeMap map(frames);
        cube.fill(map, run, depth);
        std::vector<Estimate> found(count);
        seconds += ask(map, which, found);
        for (std::size_t i = 0; i < count; ++i) {
            const auto e = static_cast<double>(found[i].irradiance.x);
            sums[i] += e / static_cast<double>(runs);
            squares[i] += e * e / static_cast<double>(runs);
            within += std::abs(e - truth[i]) <= double{found[i].standardError} ? 1 : 0;
            photons += found[i].photons / static_cast<double>(runs * count);
        }
    }
    if (unit == 0) unit = seconds / static_cast<double>(runs);
    double mean = 0;
    for (const double t : truth) mean += t / static_cast<double>(count);
    fmt::print("{},{}", name, frames);
    for (const bool edge : {false, true}) {
        double bias = 0;
        double noise = 0;
        double there = 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (cube.onEdge[i] != edge) continue;
            const double variance = std::max(0.0, squares[i] - sums[i] * sums[i]) * static_cast<double>(runs) /
                                    static_cast<double>(runs - 1);
            // The mean of the runs has noise of its own, which is no bias.
            bias += std::max(0.0, std::pow(sums[i] - truth[i], 2) - variance / static_cast<double>(runs));
            noise += variance;
            ++there;
        }
        fmt::print(",{:.3g},{:.3g}", 100 * std::sqrt(bias / there) / mean, 100 * std::sqrt(noise / there) / mean);
    }
    // What does not explain itself, says nothing of photons either.
    if (photons > 0)
        fmt::print(",{:.3g},{:.3g},{:.3g}\n", within / static_cast<double>(runs * count), photons,
                   seconds / static_cast<double>(runs) / unit);
    else
        fmt::print(",,,{:.3g}\n", seconds / static_cast<double>(runs) / unit);
    std::fflush(stdout);
}

constexpr std::string_view head = "technique,frames,bias_inner,noise_inner,bias_edge,noise_edge,share,photons,time\n";

Ask fromPhotons(const Cube& cube, const NearestOptions& options) {
    return [&cube, options](const RealtimeMap& map, std::span<const std::uint32_t> which, std::span<Estimate> found) {
        const NearestPhotons estimator(*cube.scene, cube.receivers, map, options);
        std::vector<Rgb> irradiance(which.size());
        estimator.estimate(which, irradiance); // makes the area tables, once for all frames
        constexpr int times = 5;
        const double seconds = 1e-3 / times * pie::bench::milliseconds([&] {
                                   for (int i = 0; i < times; ++i) estimator.estimate(which, irradiance);
                               });
        estimator.explain(which, found);
        return seconds;
    };
}

void photons() {
    const Cube cube;
    const std::vector<double> truth = cube.direct();
    fmt::print("{}", head);
    double unit = 0;
    NearestOptions paper;
    const auto line = [&](std::string_view name, const NearestOptions& options) {
        measure(cube, name, truth, 0, 4, fromPhotons(cube, options), unit);
    };
    line("paper", paper);
    for (const auto& [name, volume] :
         {std::pair("volume sphere", SearchVolume::Sphere), std::pair("volume slice", SearchVolume::Slice),
          std::pair("volume cylinder", SearchVolume::Cylinder),
          std::pair("volume ellipsoid", SearchVolume::Ellipsoid)}) {
        NearestOptions options = paper;
        options.volume = volume;
        line(name, options);
    }
    NearestOptions anySphere = paper;
    anySphere.volume = SearchVolume::Sphere;
    anySphere.incomingDirection = false;
    line("volume sphere and any direction", anySphere);
    for (const auto& [name, area] :
         {std::pair("area pi_r2", AreaEstimate::Disc), std::pair("area box", AreaEstimate::Box),
          std::pair("area oriented_box", AreaEstimate::OrientedBox), std::pair("area ellipse", AreaEstimate::Ellipse),
          std::pair("area convex_hull", AreaEstimate::Hull), std::pair("area true_area", AreaEstimate::True)}) {
        NearestOptions options = paper;
        options.area = area;
        line(name, options);
    }
    for (const auto& [name, kernel] :
         {std::pair("kernel constant", Kernel::Constant), std::pair("kernel cone", Kernel::Cone),
          std::pair("kernel gaussian", Kernel::Gaussian), std::pair("kernel epanechnikov", Kernel::Epanechnikov)}) {
        NearestOptions options = paper;
        options.area = AreaEstimate::True;
        options.kernel = kernel;
        line(name, options);
    }
    NearestOptions heuristic = paper;
    heuristic.area = AreaEstimate::True;
    heuristic.radiusHeuristic = true;
    line("radius heuristic", heuristic);
}

void frames() {
    const Cube cube;
    const std::vector<double> truth = cube.direct();
    fmt::print("{}", head);
    for (const auto& [name, radius] : {std::pair("nearest", RadiusRule::Nearest), std::pair("fixed", RadiusRule::Fixed),
                                       std::pair("progressive", RadiusRule::Progressive)})
        for (const std::size_t count : {1U, 2U, 4U, 8U, 16U, 32U, 64U}) {
            NearestOptions options;
            options.area = AreaEstimate::True;
            options.kernel = Kernel::Epanechnikov;
            options.radius = radius;
            options.maxCount = 100;
            options.maxRadius = radius == RadiusRule::Fixed ? 70.0F : 192.0F; // 100 photons of one frame
            double unit = 0;
            measure(cube, name, truth, 0, count, fromPhotons(cube, options), unit);
        }
}

void gather() {
    const Cube cube;
    const std::vector<double> truth = cube.reflected();
    fmt::print("{}", head);
    double unit = 0;
    NearestOptions nearest;
    nearest.maxCount = 100;
    nearest.area = AreaEstimate::True;
    nearest.kernel = Kernel::Epanechnikov;
    NearestOptions indirect = nearest;
    indirect.indirectOnly = true;
    measure(cube, "photons", truth, 60, 4, fromPhotons(cube, indirect), unit);
    const auto line = [&](std::string_view name, const FinalGatherOptions& options) {
        const Ask ask = [&](const RealtimeMap& map, std::span<const std::uint32_t> which, std::span<Estimate> found) {
            const pie::gather::FinalGather estimator(*cube.scene, *cube.intersector, cube.receivers, map, nearest,
                                                     options, &cube.lights);
            std::vector<Rgb> irradiance(which.size());
            const double seconds = 1e-3 * pie::bench::milliseconds([&] { estimator.estimate(which, irradiance); });
            for (std::size_t i = 0; i < which.size(); ++i) found[i].irradiance = irradiance[i];
            return seconds;
        };
        measure(cube, name, truth, 60, 4, ask, unit, 4);
    };
    FinalGatherOptions options;
    for (const unsigned samples : {64U, 256U, 1024U}) {
        options.samples = samples;
        options.secondarySamples = 0;
        line(fmt::format("{} rays", samples), options);
    }
    options.samples = 256;
    options.secondarySamples = 16;
    for (const float distance : {16.0F, 64.0F}) {
        options.secondaryDistance = distance;
        line(fmt::format("256 rays and again within {}", distance), options);
    }
    for (const unsigned every : {1U, 4U}) {
        options.precompute = every;
        line(fmt::format("… and precomputed at every {}", every == 1 ? "photon" : "4th"), options);
    }
}

/// Along the middle of the floor, 4 units apart: how many are records, and how far the others are off.
void cache() {
    Cube cube;
    cube.receivers.points.clear();
    for (int i = 0; i <= 128; ++i) {
        const Vec3 point(4.0F * static_cast<float>(i), 0.5F * side, 0.0F);
        cube.receivers.points.push_back(pie::gather::test::receiverAt(point, {0.0F, 0.0F, 1.0F}));
        cube.receivers.points.back().inset.x = std::clamp(point.x, 1.0F, side - 1);
    }
    RealtimeMap map(4);
    cube.fill(map, 0, 60);
    NearestOptions nearest;
    nearest.maxCount = 100;
    nearest.area = AreaEstimate::True;
    nearest.kernel = Kernel::Epanechnikov;
    const std::vector<std::uint32_t> which = pie::gather::test::all(cube.receivers);
    std::vector<Rgb> whole(which.size());
    fmt::print("accuracy,records,receivers,error\n");
    for (const float accuracy : {0.0F, 0.05F, 0.1F, 0.2F, 0.3F, 0.5F, 1.0F}) {
        FinalGatherOptions options;
        options.secondarySamples = 0;
        options.cacheAccuracy = accuracy;
        const pie::gather::FinalGather estimator(*cube.scene, *cube.intersector, cube.receivers, map, nearest, options);
        std::vector<Rgb> found(which.size());
        estimator.estimate(which, found);
        if (accuracy == 0.0F) whole = found;
        double squares = 0;
        for (std::size_t i = 0; i < which.size(); ++i)
            squares += std::pow(double{found[i].x} / double{whole[i].x} - 1, 2) / static_cast<double>(which.size());
        fmt::print("{},{},{},{:.3g}\n", accuracy, accuracy == 0.0F ? which.size() : estimator.records(), which.size(),
                   100 * std::sqrt(squares));
    }
}

} // namespace

int main(int argumentCount, char** arguments) {
    pie::setThreads(1);
    const std::string_view wanted = argumentCount > 1 ? arguments[1] : "";
    if (wanted == "photons")
        photons();
    else if (wanted == "frames")
        frames();
    else if (wanted == "gather")
        gather();
    else if (wanted == "cache")
        cache();
    else
        return fmt::print(stderr, "techniques_bench photons|frames|gather|cache\n"), 1;
    return 0;
}
