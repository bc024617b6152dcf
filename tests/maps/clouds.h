#pragma once
// Clouds of photons that are hard on a search, and a random number with an address.

#include "pie/photons/photon.h"

#include <functional>
#include <random>
#include <string>
#include <vector>

namespace pie::maps::test {

using photons::Photon;

inline Photon photonAt(const Vec3& position) {
    Photon photon;
    photon.position = position;
    return photon;
}

struct Cloud {
    std::string name;
    std::vector<Photon> photons;
    std::vector<Vec3> queries;
};

inline float unit(std::mt19937& random) { return static_cast<float>(random() >> 8U) * 0x1p-24F; }
inline Vec3 unit3(std::mt19937& random) {
    const float x = unit(random);
    const float y = unit(random);
    return {x, y, unit(random)};
}

inline Cloud makeCloud(std::string name, std::size_t count, std::size_t queries, std::uint32_t seed,
                       const std::function<Vec3(std::mt19937&)>& place) {
    Cloud cloud{std::move(name), {}, {}};
    std::mt19937 random(seed);
    for (std::size_t i = 0; i < count; ++i) {
        cloud.photons.push_back(photonAt(place(random)));
        cloud.photons.back().id = static_cast<std::uint32_t>(i);
    }
    for (std::size_t i = 0; i < queries; ++i) {
        const Vec3 q = place(random);
        // Half of the queries lie where photons may lie, so that ties at distance zero come up.
        cloud.queries.push_back(i % 2 == 0 ? q : q + 2.0F * unit3(random) - 1.0F);
    }
    return cloud;
}

/// Uniform, clustered, one point, a line, few distinct points, a grid with many ties, a plane, far from the origin, at
/// both ends of the range of floats.
inline std::vector<Cloud> clouds(std::size_t count, std::size_t queries) {
    const auto whole = [](std::mt19937& r, unsigned below) { return static_cast<float>(r() % below); };
    const auto cloud = [&](const char* name, std::uint32_t seed, const std::function<Vec3(std::mt19937&)>& place) {
        return makeCloud(name, count, queries, seed, place);
    };
    return {
        cloud("uniform", 1, [](std::mt19937& r) { return 10.0F * unit3(r); }),
        cloud("clustered", 2,
              [&](std::mt19937& r) {
                  const Vec3 centre(whole(r, 7), whole(r, 3), 0.0F);
                  return centre + 0.01F * (unit3(r) + unit3(r) - unit3(r));
              }),
        cloud("one point", 3, [](std::mt19937&) { return Vec3(3.0F, -2.0F, 1.0F); }),
        cloud("line", 4, [](std::mt19937& r) { return unit(r) * Vec3(10.0F, 5.0F, -3.0F); }),
        cloud("few points", 5, [&](std::mt19937& r) { return Vec3(whole(r, 2), whole(r, 3), 1.0F); }),
        cloud("grid", 6, [&](std::mt19937& r) { return Vec3(whole(r, 8), whole(r, 8), whole(r, 8)); }),
        cloud("plane", 7, [](std::mt19937& r) { return 10.0F * unit3(r) * Vec3(1.0F, 1.0F, 0.0F); }),
        cloud("far away", 8, [](std::mt19937& r) { return Vec3(1e7F, -1e7F, 1e6F) + 50.0F * unit3(r); }),
        cloud("tiny", 9, [](std::mt19937& r) { return 1e-20F * unit3(r); }),
        cloud("huge", 10, [](std::mt19937& r) { return 3e38F * (2.0F * unit3(r) - 1.0F); }),
    };
}

} // namespace pie::maps::test
