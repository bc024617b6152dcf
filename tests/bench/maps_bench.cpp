// The kd-tree against nanoflann on the same points and queries, in one run and one thread: build, and the k nearest
// within a radius. The exact map answers every hundredth query. Points lie on the inner surfaces of rooms, as photons
// do; queries are receivers on the same surfaces. The programs alternate, round by round; each ratio is of medians.
// Answers are compared before anything is timed.
//
//   maps_bench [photons] [queries] [rounds] [k]

#include "apps/piebench/nanoflann_photons.h"
#include "pie/core/parallel.h"
#include "pie/maps/exact.h"
#include "pie/maps/kd_tree.h"
#include "tests/bench/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

namespace {

using pie::Vec3;
using pie::bench::median;
using pie::bench::milliseconds;
using pie::photons::Photon;

constexpr float radius = 192;

float unit(std::mt19937& random) { return static_cast<float>(random() >> 8U) * 0x1p-24F; }

/// On a wall, floor or ceiling of one of 48 rooms.
Vec3 place(std::mt19937& random) {
    const auto room = random() % 48;
    const auto row = room / 8;
    const Vec3 origin(600.0F * static_cast<float>(room % 8), 600.0F * static_cast<float>(row), 0.0F);
    Vec3 p(512.0F * unit(random), 512.0F * unit(random), 256.0F * unit(random));
    switch (random() % 6) {
    case 0: p.x = 0; break;
    case 1: p.x = 512; break;
    case 2: p.y = 0; break;
    case 3: p.y = 512; break;
    case 4: p.z = 0; break;
    default: p.z = 256; break;
    }
    return origin + p;
}

std::size_t argument(int count, char** arguments, int number, std::size_t otherwise) {
    return count > number ? std::strtoull(arguments[number], nullptr, 10) : otherwise;
}

/// Both sides of the comparison.
struct Sides {
    explicit Sides(std::size_t count) : k(count) {}
    std::size_t k;
    pie::maps::KdTree tree;
    pie::maps::ExactMap exact;
    pie::maps::NearestQueue queue;
    std::vector<std::uint32_t> numbers = std::vector<std::uint32_t>(k);
    std::vector<float> distances = std::vector<float>(k);

    template <class Map> float ask(const Map& map, const Vec3& point) {
        map.nearest(
            point, k, radius, [](const Photon&) { return true; }, queue);
        return queue.full() ? queue.farthest().distanceSquared : 0.0F;
    }
    float ours(const Vec3& point) { return ask(tree, point); }
    float theirs(const piebench::NanoflannIndex& index, const Vec3& point) {
        nanoflann::KNNResultSet<float, std::uint32_t> result(k);
        result.init(numbers.data(), distances.data());
        // It has no search that is bounded by both. What it takes for the k-th distance so far bounds it.
        distances[k - 1] = std::nextafter(radius * radius, 2 * radius * radius);
        index.findNeighbors(result, &point.x, nanoflann::SearchParams());
        return result.full() && distances[k - 1] <= radius * radius ? distances[k - 1] : 0.0F;
    }
};

} // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): what goes wrong may end a measurement
int main(int argumentCount, char** arguments) {
    const std::size_t photonCount = argument(argumentCount, arguments, 1, 25'600);
    const std::size_t queryCount = argument(argumentCount, arguments, 2, 34'155);
    const std::size_t rounds = std::max<std::size_t>(1, argument(argumentCount, arguments, 3, 11));
    pie::setThreads(1);
    std::mt19937 random(1);
    piebench::PhotonCloud cloud;
    cloud.photons.resize(photonCount);
    for (Photon& photon : cloud.photons) photon.position = place(random);
    std::vector<Vec3> queries(queryCount);
    for (Vec3& query : queries) query = place(random);

    Sides sides(argument(argumentCount, arguments, 4, 50));
    sides.tree.build(cloud.photons);
    piebench::NanoflannIndex index(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    index.buildIndex();
    std::size_t different = 0;
    for (const Vec3& query : queries)
        if (sides.ours(query) != sides.theirs(index, query)) ++different;

    std::vector<double> buildOurs;
    std::vector<double> buildTheirs;
    std::vector<double> searchOurs;
    std::vector<double> searchTheirs;
    std::vector<double> searchExact;
    sides.exact.build(cloud.photons);
    float sink = 0;
    for (std::size_t round = 0; round < rounds; ++round) {
        std::vector<Photon> copy = cloud.photons;
        buildOurs.push_back(milliseconds([&] { sides.tree.build(std::move(copy)); }));
        buildTheirs.push_back(milliseconds([&] { index.buildIndex(); }));
        searchOurs.push_back(milliseconds([&] {
            for (const Vec3& query : queries) sink += sides.ours(query);
        }));
        searchTheirs.push_back(milliseconds([&] {
            for (const Vec3& query : queries) sink += sides.theirs(index, query);
        }));
        searchExact.push_back(milliseconds([&] {
            for (std::size_t i = 0; i < queries.size(); i += 100) sink += sides.ask(sides.exact, queries[i]);
        }));
    }
    fmt::print("{} photons, {} queries, k = {}, radius {}, one thread, processor time, median of {} rounds; {} answers "
               "differ\n",
               photonCount, queryCount, sides.k, radius, rounds, different);
    fmt::print("build   ours {:8.3f} ms   nanoflann {:8.3f} ms   ratio {:.2f}\n", median(buildOurs),
               median(buildTheirs), median(buildTheirs) / median(buildOurs));
    fmt::print("search  ours {:8.3f} ms   nanoflann {:8.3f} ms   ratio {:.2f}   {:.0f} searches/s\n",
               median(searchOurs), median(searchTheirs), median(searchTheirs) / median(searchOurs),
               1000.0 * static_cast<double>(queryCount) / median(searchOurs));
    const double exactQueries = std::ceil(static_cast<double>(queryCount) / 100);
    fmt::print("exact   {:.1f} times as long a search as ours\n",
               median(searchExact) / exactQueries / (median(searchOurs) / static_cast<double>(queryCount)));
    return different == 0 && sink >= 0.0F ? 0 : 1;
}
